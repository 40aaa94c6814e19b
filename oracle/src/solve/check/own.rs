//! The light on a texel by rays from the answer's own cells, with a form factor of one's choice:
//! what of an error is the item buffer's, and what the form factor's.

use common::form_factor::FormFactor;
use common::mesh::{Cell, Mesh};
use common::rays::{Rays, Sight};
use common::shooting::Field;
use cpu::twin::link::{Sums, factor, sample};
use glam::DVec3;

/// A way to gather.
pub struct Own<'a> {
    mesh: &'a Mesh,
    form_factor: FormFactor,
    /// Radiosity of each cell.
    radiosity: Vec<DVec3>,
}

impl<'a> Own<'a> {
    /// The answer's light on its cells.
    pub fn new(mesh: &'a Mesh, field: &Field, form_factor: FormFactor) -> Self {
        let mean = |cell: &Cell| {
            let mut sum = DVec3::ZERO;
            for k in cell.texels() {
                let texel = &mesh.texels[k];
                let emission = texel.emission.as_dvec3();
                let reflected = field.radiosity[k].truncate().as_dvec3() - emission;
                // What a covered part emits is lost.
                sum += (emission * f64::from(cell.open) + reflected) * f64::from(texel.area);
            }
            sum / f64::from(cell.shooter.area).max(f64::MIN_POSITIVE)
        };
        Self {
            mesh,
            form_factor,
            radiosity: mesh.cells.iter().map(mean).collect(),
        }
    }

    /// H of texel `k`.
    pub fn gather(&self, rays: &Rays, k: usize) -> DVec3 {
        let shining = (0..).zip(&self.radiosity);
        let shining = shining.filter(|(_, b)| **b != DVec3::ZERO);
        shining
            .map(|(i, b)| *b * self.link(rays, i, k as u32))
            .sum()
    }

    fn link(&self, rays: &Rays, i: u32, k: u32) -> f64 {
        let cell = &self.mesh.cells[i as usize];
        let ends = [cell.face, self.mesh.texels[k as usize].face];
        let mut sums = Sums {
            form_factor: factor(self.mesh, self.form_factor, i, k),
            ..Sums::default()
        };
        for s in 0..self.mesh.samples {
            sample(self.mesh, i, k, s, &mut sums, |q, p| {
                if rays.visible(q, p, ends) {
                    Sight::Clear
                } else {
                    Sight::Blocked
                }
            });
        }
        f64::from(sums.link(cell.open))
    }
}
