//! The cost of a solve before it starts: [`counts`] of texels, patches and links, [`coarser_defaults`] for scenes of many
//! faces, the [`memory`] it needs, and a [`forecast`] of its time.

pub mod coarser_defaults;
pub mod counts;
pub mod forecast;
#[allow(clippy::disallowed_methods, reason = "reads the system's own /proc/meminfo")]
pub mod memory;

pub use counts::SceneCounts;
