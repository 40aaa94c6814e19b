//! What an error becomes through later bounces.
//!
//! ```text
//! x = ρ F (r + x)
//! ```
//! r: what each group of faces is found to miss, a mean over its area; F from the rays that looked.
//! Errors that change within a group even out on their way to others; those that do not grow, in
//! white rooms without limit.

use super::Look;
use common::Result;
use common::mesh::{Mesh, Texel};
use common::scene::Scene;
use common::texel::Cells;
use cpu::matrix::Matrix;
use glam::DVec3;

/// Looks that each group is to have, at least.
const EACH: usize = 4;

/// Texels in groups.
pub struct Groups {
    of_texel: Vec<usize>,
    areas: Vec<f64>,
    reflectance: Vec<DVec3>,
}

impl Groups {
    /// K×K parts of each face, where the faces are few; where they are many, neighbours in the file.
    pub fn new(scene: &Scene, mesh: &Mesh, looks: usize) -> Self {
        let most = looks / EACH;
        let faces = mesh.faces.len();
        let k = (most / faces.max(1)).isqrt() as u32;
        let mut first = vec![0; faces];
        let mut count = faces.min(most);
        if k > 1 {
            count = 0;
            for (face, first) in first.iter_mut().enumerate() {
                *first = count;
                count += parts(scene, mesh, face, k).count() as usize;
            }
        }
        let of = |texel: &Texel| {
            let face = texel.face as usize;
            if k > 1 {
                first[face] + parts(scene, mesh, face, k).of_texel(texel.index) as usize
            } else {
                face * count / faces
            }
        };
        let of_texel: Vec<usize> = mesh.texels.iter().map(of).collect();
        let (mut areas, mut reflectance) = (vec![0.0; count], vec![DVec3::ZERO; count]);
        for (texel, group) in mesh.texels.iter().zip(&of_texel) {
            areas[*group] += f64::from(texel.area);
            reflectance[*group] += texel.reflectance.as_dvec3() * f64::from(texel.area);
        }
        for (sum, area) in reflectance.iter_mut().zip(&areas) {
            *sum = if *area > 0.0 {
                *sum / *area
            } else {
                DVec3::ZERO
            };
        }
        Self {
            of_texel,
            areas,
            reflectance,
        }
    }

    /// The group of a texel.
    pub fn of(&self, texel: usize) -> usize {
        self.of_texel[texel]
    }

    /// x of each group by the looks of even number, and by those of odd number.
    pub fn later(&self, looks: &[Look]) -> Result<[Vec<DVec3>; 2]> {
        let transfer = self.transfer(looks);
        let n = self.areas.len();
        let matrix = Matrix::from_weights(self.areas.clone(), |j, i| transfer[j * n + i])?;
        let halves = [0, 1].map(|half| {
            let missed = self.missed(looks, half);
            let all = matrix.solve(&missed, &self.reflectance)?.radiosity;
            Ok(all.iter().zip(missed).map(|(all, r)| *all - r).collect())
        });
        let [even, odd] = halves;
        Ok([even?, odd?])
    }

    /// The mean of what a group's texels miss, but for those whose points were asked one by one: of those of one half, of all where that has none of it.
    fn missed(&self, looks: &[Look], half: usize) -> Vec<DVec3> {
        let mut sums = vec![[(DVec3::ZERO, 0.0); 2]; self.areas.len()];
        for (k, look) in looks.iter().enumerate() {
            let missed = if look.cut {
                DVec3::ZERO
            } else {
                look.area * look.carried
            };
            for (sum, counts) in sums[self.of(look.texel)]
                .iter_mut()
                .zip([k % 2 == half, true])
            {
                if counts {
                    sum.0 += missed;
                    sum.1 += look.area;
                }
            }
        }
        let mean = |[own, all]: [(DVec3, f64); 2]| match (own.1 > 0.0, all.1 > 0.0) {
            (true, _) => own.0 / own.1,
            (_, true) => all.0 / all.1,
            _ => DVec3::ZERO,
        };
        sums.into_iter().map(mean).collect()
    }

    /// F, row after row: the share of a group's rays that meet fronts of each other one.
    fn transfer(&self, looks: &[Look]) -> Vec<f64> {
        let n = self.areas.len();
        let (mut transfer, mut all) = (vec![0.0; n * n], vec![0.0; n]);
        for look in looks {
            let row = self.of(look.texel);
            all[row] += look.area;
            for (group, share) in &look.met {
                transfer[row * n + group] += look.area * share;
            }
        }
        for (row, all) in transfer.chunks_mut(n.max(1)).zip(all) {
            let scale = if all > 0.0 { 1.0 / all } else { 0.0 };
            row.iter_mut().for_each(|share| *share *= scale);
        }
        transfer
    }
}

fn parts(scene: &Scene, mesh: &Mesh, face: usize, k: u32) -> Cells {
    Cells::new(scene.faces[face].shape, mesh.faces[face].resolution, k)
}
