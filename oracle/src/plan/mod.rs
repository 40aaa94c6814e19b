//! What a solve will take, estimated before it starts.
//!
//! [`counts`] are arithmetic on the scene and the settings, [`memory`] is what they take,
//! [`fits`] refuses what this machine cannot hold and says what it can, [`passes`] and [`trial`]
//! estimate the time, [`ahead`] announces what takes long, [`defaults`] keep scenes of many faces
//! from taking long.

pub mod ahead;
pub mod counts;
pub mod defaults;
#[allow(
    clippy::disallowed_methods,
    reason = "reads the system's own /proc/meminfo"
)]
pub mod fits;
pub mod memory;
pub mod passes;
pub mod trial;

pub use counts::Counts;
