//! Records that all shaders share, and the index of a workgroup.
//!
//! The twin of `gpu/src/shaders/types.wgsl`: its functions stand where other modules use them, too, and are re-exported.

pub use common::dispatch::flat_index;
pub use common::mesh::{MeshFace, Patch, PatchPoint, Texel};

pub use crate::links::StoredRow;
pub use crate::shader_twins::deposit::ShotInFlight;
pub use common::shooting::Shot;
