//! Sample points on texels and patches.

pub use common::sampling::{
    fold_triangle, grid_coordinate, near_point_uv, patch_uv, pcg_hash, sample_coordinate, texel_uv,
};
