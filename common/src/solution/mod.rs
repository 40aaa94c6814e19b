//! Files of a solve: `lightmap.exr` (radiosity, residual, irradiance, W/m²) and `result.json`.
//! [`mod@write`] writes them (all files or none: [`pending`]), [`read`] reads them back and decodes the
//! pixels by [`pixels`]. The description holds the files' checksums.

pub(crate) mod faces;
pub mod pending;
pub mod pixels;
pub mod read;
pub mod warning;
pub mod write;

pub use pending::{prepare_folder, prepare_outputs, write_files};
pub use read::StoredSolution;
pub use warning::{Warning, WarningCode};
pub use write::{PhaseSeconds, Solution, atlas_channel, encode_lightmap};
