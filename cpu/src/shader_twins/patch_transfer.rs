//! Transfer from a shooting patch to another one.

use common::constants::PATCH_SUM_LANES;
use common::mesh::{Mesh, Patch};
use common::reduce::tree_sum;

/// Returns Σ w·A over the texels of a patch; `links` are those of all texels.
pub fn patch_transfer(mesh: &Mesh, links: &[f32], patch: &Patch) -> f32 {
    tree_sum::<_, PATCH_SUM_LANES>(0.0, patch.count as usize, |k| {
        let k = patch.first as usize + k;
        links[k] * mesh.texels[k].area
    })
}
