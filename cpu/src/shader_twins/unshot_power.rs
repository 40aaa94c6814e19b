//! Unshot flux of a patch.

use common::constants::PATCH_SUM_LANES;
use common::mesh::{Mesh, Patch};
use common::reduce::tree_sum;
use common::shooting::RadiosityField;
use glam::Vec4;

/// Returns Σ r·A per channel over the texels of a patch; w: Σ|r|·A over the channels.
pub fn unshot_power(mesh: &Mesh, field: &RadiosityField, patch: &Patch) -> Vec4 {
    tree_sum::<_, PATCH_SUM_LANES>(Vec4::ZERO, patch.count as usize, |k| {
        let k = patch.first as usize + k;
        let area = mesh.texels[k].area;
        let r = field.residual[k].truncate();
        (r * area).extend((r.x.abs() + r.y.abs() + r.z.abs()) * area)
    })
}
