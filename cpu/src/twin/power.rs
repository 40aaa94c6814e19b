//! What a cell has yet to shoot, and what it receives from a shot. Twin of
//! `gpu/src/shaders/power.wgsl` and `gpu/src/shaders/received.wgsl`.

use common::constants::{LANES, SELECT_LANES};
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

/// Σ w·A over a cell's texels, `links` those of all texels.
pub fn received(mesh: &Mesh, links: &[f32], cell: &Cell) -> f32 {
    tree_sum::<_, LANES>(0.0, cell.count as usize, |k| {
        let k = cell.first as usize + k;
        links[k] * mesh.texels[k].area
    })
}

/// ΣF of a shooter of this `area`: what the cells take, over what it gives.
pub fn closure(received: &[f32], area: f32) -> f32 {
    let sum = tree_sum::<_, SELECT_LANES>(0.0, received.len(), |k| received[k]);
    if area > 0.0 { sum / area } else { 0.0 }
}
