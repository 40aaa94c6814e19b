//! Sample points on texels and patches.
//!
//! The twin of `gpu/src/shaders/sampling.wgsl`: its functions stand where other modules use them, too, and are re-exported.

pub use common::sampling::{
    fold_triangle, grid_coordinate, near_point_uv, patch_uv, pcg_hash, sample_coordinate, texel_uv,
};
