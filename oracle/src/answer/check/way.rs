//! A way to gather light on a texel: by rays from cells of its own size.

use super::places::exact;
use common::form_factor::FormFactor;
use common::mesh::{Cell, Mesh};
use common::shooting::Field;
use cpu::link::{Sums, factor, sample};
use cpu::rays::{Rays, Sight};
use glam::DVec3;

/// Rays of a texel, at least and at most: four times those of the answer, shared out by the light
/// that each cell could bring; each has one.
const RAYS: [u64; 2] = [1 << 12, 1 << 16];
/// Cells that shine, few enough for [`places::exact`] to be asked of each; of more, only those that bring
/// at least this share of the light.
const FEW: usize = 128;

/// A way to gather.
pub struct Way {
    /// Its cells, on the same texels.
    pub mesh: Mesh,
    /// F.
    form_factor: FormFactor,
    /// Whether F is asked more closely where it matters.
    exact: bool,
    /// Radiosity of each cell.
    radiosity: Vec<DVec3>,
    /// Rays of a texel.
    rays: u64,
}

impl Way {
    /// The answer's light on the cells of another mesh of the same texels.
    pub fn new(
        own: Mesh,
        (form_factor, exact): (FormFactor, bool),
        mesh: &Mesh,
        field: &Field,
    ) -> Self {
        let order = mesh.in_face_order();
        let place = own.in_face_order();
        let mut light = vec![[DVec3::ZERO; 2]; own.texels.len()];
        for (from, to) in order.into_iter().zip(place) {
            let emission = mesh.texels[from].emission.as_dvec3();
            let b = field.radiosity[from].truncate().as_dvec3();
            light[to] = [emission, b - emission];
        }
        let mean = |cell: &Cell| {
            let mut sum = DVec3::ZERO;
            for k in cell.texels() {
                let [emission, reflected] = light[k];
                // What a covered part emits is lost.
                let leaving = emission * f64::from(cell.open) + reflected;
                sum += leaving * f64::from(own.texels[k].area);
            }
            sum / f64::from(cell.shooter.area).max(f64::MIN_POSITIVE)
        };
        let radiosity: Vec<DVec3> = own.cells.iter().map(mean).collect();
        let shining = radiosity.iter().filter(|b| **b != DVec3::ZERO).count() as u64;
        let coarser = (own.cells.len() as u64).div_ceil(mesh.cells.len().max(1) as u64);
        let asked = 4 * shining / coarser * u64::from(mesh.samples);
        let samples = u64::from(own.samples);
        Self {
            mesh: own,
            form_factor,
            exact,
            radiosity,
            rays: asked.clamp(RAYS[0], RAYS[1]).min(shining * samples),
        }
    }

    /// Rays that a texel takes, at most.
    pub fn rays(&self) -> u64 {
        self.mesh.cells.len() as u64 + self.rays
    }

    /// H of the texel that is `texel` in the answer's `mesh`.
    pub fn gather(&self, rays: &Rays, mesh: &Mesh, texel: usize) -> DVec3 {
        let Some(k) = self.same(mesh, texel) else {
            return DVec3::ZERO;
        };
        let light = self.light(k);
        let power = |pair: &(u32, f32)| self.power(pair);
        let all: f64 = light.iter().map(power).sum();
        let mut sum = DVec3::ZERO;
        for pair in light {
            let asked = (self.rays as f64 * power(&pair) / all).ceil() as u32;
            let samples = asked.clamp(1, self.mesh.samples);
            let (i, form_factor) = pair;
            sum += self.radiosity[i as usize] * self.link(rays, i, k, form_factor, samples);
        }
        sum
    }

    /// The cells that bring light to texel `k` where nothing hides them, with their F.
    fn light(&self, k: u32) -> Vec<(u32, f32)> {
        let shining = (0..).zip(&self.radiosity);
        let shining = shining.filter(|(_, b)| **b != DVec3::ZERO);
        let mut light: Vec<(u32, f32)> = shining
            .map(|(i, _)| (i, factor(&self.mesh, self.form_factor, i, k)))
            .collect();
        if self.exact {
            let all: f64 = light.iter().map(|pair| self.power(pair)).sum();
            let few = light.len() <= FEW;
            for pair in &mut light {
                if few || self.power(pair) * FEW as f64 >= all {
                    pair.1 = exact(&self.mesh, pair.0, k);
                }
            }
        }
        light.retain(|(_, form_factor)| *form_factor > 0.0);
        light
    }

    fn power(&self, (i, form_factor): &(u32, f32)) -> f64 {
        f64::from(*form_factor) * self.radiosity[*i as usize].abs().element_sum()
    }

    /// w of a cell and a texel, from the first so many samples.
    fn link(&self, rays: &Rays, i: u32, k: u32, form_factor: f32, samples: u32) -> f64 {
        let cell = &self.mesh.cells[i as usize];
        let ends = [cell.face, self.mesh.texels[k as usize].face];
        let mut sums = Sums {
            form_factor,
            ..Sums::default()
        };
        for s in 0..samples {
            sample(&self.mesh, i, k, s, &mut sums, |q, p| {
                if rays.visible(q, p, ends) {
                    Sight::Clear
                } else {
                    Sight::Blocked
                }
            });
        }
        f64::from(sums.link(cell.open))
    }

    /// The number here of a texel of `mesh`: only the order within a face differs.
    fn same(&self, mesh: &Mesh, texel: usize) -> Option<u32> {
        let wanted = &mesh.texels[texel];
        let face = mesh.texels[..texel]
            .iter()
            .rposition(|t| t.face != wanted.face)
            .map_or(0, |k| k + 1);
        let here = self.mesh.texels.get(face..)?;
        let offset = here.iter().position(|t| t.index == wanted.index)?;
        Some((face + offset) as u32)
    }
}
