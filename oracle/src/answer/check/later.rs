//! What an error becomes by later bounces.
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

/// Groups at most: each is to have some looks.
const MOST: usize = 256;

/// Texels in groups.
pub struct Groups {
    of_texel: Vec<usize>,
    areas: Vec<f64>,
    reflectance: Vec<DVec3>,
}

impl Groups {
    /// K×K parts of each face, where the faces are few; where they are many, neighbours in the file.
    pub fn new(scene: &Scene, mesh: &Mesh) -> Self {
        let faces = mesh.faces.len();
        let k = (MOST / faces.max(1)).isqrt() as u32;
        let mut first = vec![0; faces];
        let mut count = faces.min(MOST);
        if k > 1 {
            count = 0;
            for face in 0..faces {
                first[face] = count;
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
            let missed = self.missed(looks.iter().skip(half).step_by(2));
            let all = matrix.solve(&missed, &self.reflectance)?.radiosity;
            Ok(all.iter().zip(missed).map(|(all, r)| *all - r).collect())
        });
        let [even, odd] = halves;
        Ok([even?, odd?])
    }

    /// The mean of what a group's texels miss.
    fn missed<'a>(&self, looks: impl Iterator<Item = &'a Look>) -> Vec<DVec3> {
        let mut sums = vec![(DVec3::ZERO, 0.0); self.areas.len()];
        for look in looks {
            let sum = &mut sums[self.of(look.texel)];
            sum.0 += look.area * 0.5 * (look.missed[0] + look.missed[1]);
            sum.1 += look.area;
        }
        let mean = |(sum, area)| if area > 0.0 { sum / area } else { DVec3::ZERO };
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
