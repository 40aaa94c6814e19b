//! Records that all shaders share, and the index of a workgroup.

pub use common::dispatch::flat_index;
pub use common::mesh::{MeshFace, Patch, PatchPoint, Texel};

pub use crate::links::StoredRow;
pub use crate::shader_twins::deposit::ShotInFlight;
pub use common::shooting::Shot;
