//! What a cell has yet to shoot. Twin of `gpu/src/shaders/power.wgsl`.

use common::constants::LANES;
use common::mesh::{Cell, Mesh};
use common::reduce::tree_sum;
use common::shooting::Field;
use glam::Vec4;

/// Σ r·A per channel over a cell's texels; w: Σ|r|·A over the channels.
pub fn power(mesh: &Mesh, field: &Field, cell: &Cell) -> Vec4 {
    tree_sum::<_, LANES>(Vec4::ZERO, cell.count as usize, |k| {
        let k = cell.first as usize + k;
        let area = mesh.texels[k].area;
        let r = field.residual[k].truncate();
        (r * area).extend((r.x.abs() + r.y.abs() + r.z.abs()) * area)
    })
}
