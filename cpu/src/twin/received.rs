//! What a cell receives from a shot. Twin of `gpu/src/shaders/received.wgsl`.

use common::constants::LANES;
use common::mesh::{Cell, Mesh};
use common::reduce::tree_sum;

/// Σ w·A over a cell's texels, `links` those of all texels.
pub fn received(mesh: &Mesh, links: &[f32], cell: &Cell) -> f32 {
    tree_sum::<_, LANES>(0.0, cell.count as usize, |k| {
        let k = cell.first as usize + k;
        links[k] * mesh.texels[k].area
    })
}
