//! Estimates the cost of a solve before it starts.
//!
//! [`counts`] counts texels, patches and links from scene and settings, [`coarser_defaults`] coarsens the defaults of scenes
//! of many faces, [`memory`] estimates bytes, [`memory_limit`] refuses a solve that does not fit into memory, [`passes`] and
//! [`trial`] estimate passes and time, [`forecast`] announces a long solve.

pub mod coarser_defaults;
pub mod counts;
pub mod forecast;
pub mod memory;
#[allow(clippy::disallowed_methods, reason = "reads the system's own /proc/meminfo")]
pub mod memory_limit;
pub mod passes;
pub mod trial;

pub use counts::SceneCounts;
