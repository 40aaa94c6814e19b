//! Gathers a texel's light from the solution's own patches, with rays for visibility and a chosen form factor.
//! The differences attribute the error to the item buffer and to the form factor.

use common::form_factor::FormFactor;
use common::mesh::{Mesh, Patch};
use common::rays::{LineOfSight, Rays};
use common::shooting::RadiosityField;
use cpu::shader_twins::link::{Sums, add_sample, texel_form_factor};
use glam::DVec3;

/// Gathers light from the patches of a solution.
pub struct PatchGatherer<'a> {
    mesh: &'a Mesh,
    form_factor: FormFactor,
    /// Radiosity of each patch.
    radiosity: Vec<DVec3>,
}

impl<'a> PatchGatherer<'a> {
    /// Averages the solution's light over its patches.
    pub fn new(mesh: &'a Mesh, field: &RadiosityField, form_factor: FormFactor) -> Self {
        let mean = |patch: &Patch| {
            let mut sum = DVec3::ZERO;
            for k in patch.texels() {
                let texel = &mesh.texels[k];
                let emission = texel.emission.as_dvec3();
                let reflected = field.radiosity[k].truncate().as_dvec3() - emission;
                // Emission of a covered part is lost.
                sum += (emission * f64::from(patch.open_share) + reflected) * f64::from(texel.area);
            }
            sum / f64::from(patch.shooter.area).max(f64::MIN_POSITIVE)
        };
        Self {
            mesh,
            form_factor,
            radiosity: mesh.patches.iter().map(mean).collect(),
        }
    }

    /// Gathers H of texel `k`.
    pub fn gather_texel(&self, rays: &Rays, k: usize) -> DVec3 {
        let shining = (0..).zip(&self.radiosity);
        let shining = shining.filter(|(_, b)| **b != DVec3::ZERO);
        shining.map(|(i, b)| *b * self.link_weight(rays, i, k as u32)).sum()
    }

    fn link_weight(&self, rays: &Rays, i: u32, k: u32) -> f64 {
        let patch = &self.mesh.patches[i as usize];
        let ends = [patch.face, self.mesh.texels[k as usize].face];
        let mut sums = Sums {
            form_factor: texel_form_factor(self.mesh, self.form_factor, i, k),
            ..Sums::default()
        };
        for s in 0..self.mesh.samples {
            add_sample(self.mesh, i, k, s, &mut sums, |q, p| {
                if rays.is_visible(q, p, ends) {
                    LineOfSight::Clear
                } else {
                    LineOfSight::Blocked
                }
            });
        }
        f64::from(sums.link_weight(patch.open_share))
    }
}
