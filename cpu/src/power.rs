//! What a cell has yet to shoot and what it took from the latest shot. Twin of
//! `gpu/src/shaders/power.wgsl`.

use common::constants::LANES;
use common::mesh::{Cell, Mesh};
use common::reduce::tree_sum;
use common::shooting::Field;
use glam::Vec4;

/// Sums over a cell's texels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellSum {
    /// Σ r·A per channel; w: Σ|r|·A over the channels.
    pub residual: Vec4,
    /// Σ F·A of the latest shot.
    pub received: f32,
}

impl std::ops::Add for CellSum {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            residual: self.residual + other.residual,
            received: self.received + other.received,
        }
    }
}

/// The sums of `cell`.
pub fn power(mesh: &Mesh, field: &Field, cell: &Cell) -> CellSum {
    tree_sum::<_, LANES>(CellSum::default(), cell.count as usize, |k| {
        let k = cell.first as usize + k;
        let area = mesh.texels[k].area;
        let r = field.residual[k].truncate();
        CellSum {
            residual: (r * area).extend((r.x.abs() + r.y.abs() + r.z.abs()) * area),
            received: field.irradiance[k].w * area,
        }
    })
}
