//! A solve's files: `lightmap.exr` (radiosity, residual, irradiance, W/m²) and `result.json`,
//! written by [`mod@write`] (all files or none: [`pending`]) and read back by [`read`], which decodes
//! the pixels by [`pixels`]. The description holds a checksum of the lightmap.

pub(crate) mod faces;
pub mod pending;
pub mod pixels;
pub mod read;
pub mod warning;
pub mod write;

pub use read::Stored;
pub use warning::{Code, Warning};
pub use write::{Seconds, Solution, atlas_channel, lightmap, prepare, write_file};
