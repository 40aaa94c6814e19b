//! Files of a solve: `lightmap.exr` (radiosity, residual, irradiance, W/m²) and `result.json`.
//! [`mod@write`] writes them (all files or none: [`pending`]), [`read`] reads them back and decodes the
//! pixels by [`pixels`]. The description holds a checksum of the lightmap.

pub(crate) mod faces;
pub mod pending;
pub mod pixels;
pub mod read;
pub mod warning;
pub mod write;

pub use read::StoredSolution;
pub use warning::{Warning, WarningCode};
pub use write::{PhaseSeconds, Solution, atlas_channel, encode_lightmap, prepare_directory, write_file};
