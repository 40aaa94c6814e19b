//! Propagates residuals through later bounces.
//!
//! ```text
//! x = ρ F (r + x)
//! ```
//! r is the mean residual of each group of texels; F comes from the rays that gathered the sample. Errors that
//! change sign within a group average out on their way to other groups; the others grow, in white rooms without
//! limit.

use super::RegatheredTexel;
use common::Result;
use common::mesh::{Mesh, Texel};
use common::scene::Scene;
use common::texel::PatchGrid;
use cpu::dense::Matrix;
use glam::DVec3;

/// Smallest number of sampled texels per group.
const MIN_TEXELS_PER_GROUP: usize = 4;

/// A partition of the texels into groups.
pub struct TexelGroups {
    of_texel: Vec<usize>,
    areas: Vec<f64>,
    reflectance: Vec<DVec3>,
}

impl TexelGroups {
    /// Makes groups for a sample of `sampled` texels: K×K parts of each face if there are few faces; consecutive
    /// faces of the scene if there are many.
    pub fn new(scene: &Scene, mesh: &Mesh, sampled: usize) -> Self {
        let max_groups = sampled / MIN_TEXELS_PER_GROUP;
        let faces = mesh.faces.len();
        let k = (max_groups / faces.max(1)).isqrt() as u32;
        let mut first = vec![0; faces];
        let mut count = faces.min(max_groups);
        if k > 1 {
            count = 0;
            for (face, first) in first.iter_mut().enumerate() {
                *first = count;
                count += face_parts(scene, mesh, face, k).patch_count() as usize;
            }
        }
        let of = |texel: &Texel| {
            let face = texel.face as usize;
            if k > 1 {
                first[face] + face_parts(scene, mesh, face, k).patch_of_texel(texel.index) as usize
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
            *sum = if *area > 0.0 { *sum / *area } else { DVec3::ZERO };
        }
        Self {
            of_texel,
            areas,
            reflectance,
        }
    }

    /// Returns the group of a texel.
    pub fn group_of(&self, texel: usize) -> usize {
        self.of_texel[texel]
    }

    /// Solves for x of each group twice: from the sampled texels of even number, and from those of odd number.
    ///
    /// Errors: those of the dense solver.
    pub fn later_bounces(&self, sampled: &[RegatheredTexel]) -> Result<[Vec<DVec3>; 2]> {
        let transfer = self.transfer_matrix(sampled);
        let n = self.areas.len();
        let matrix = Matrix::from_weights(self.areas.clone(), |j, i| transfer[j * n + i])?;
        let halves = [0, 1].map(|half| {
            let residual = self.mean_residuals(sampled, half);
            let all = matrix.solve(&residual, &self.reflectance)?.radiosity;
            Ok(all.iter().zip(residual).map(|(all, r)| *all - r).collect())
        });
        let [even, odd] = halves;
        Ok([even?, odd?])
    }

    /// Mean residual of each group: from its sampled texels of one half, or from all if the half has none.
    /// Partly covered texels count 0, because their points are gathered one by one.
    fn mean_residuals(&self, sampled: &[RegatheredTexel], half: usize) -> Vec<DVec3> {
        let mut sums = vec![[(DVec3::ZERO, 0.0); 2]; self.areas.len()];
        for (k, sample) in sampled.iter().enumerate() {
            let residual = if sample.partly_covered {
                DVec3::ZERO
            } else {
                sample.area * sample.propagated
            };
            for (sum, counts) in sums[self.group_of(sample.texel)].iter_mut().zip([k % 2 == half, true]) {
                if counts {
                    sum.0 += residual;
                    sum.1 += sample.area;
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

    /// F in row-major order: the share of each group's rays that meet fronts of each group.
    fn transfer_matrix(&self, sampled: &[RegatheredTexel]) -> Vec<f64> {
        let n = self.areas.len();
        let (mut transfer, mut all) = (vec![0.0; n * n], vec![0.0; n]);
        for sample in sampled {
            let row = self.group_of(sample.texel);
            all[row] += sample.area;
            for (group, share) in &sample.group_shares {
                transfer[row * n + group] += sample.area * share;
            }
        }
        for (row, all) in transfer.chunks_mut(n.max(1)).zip(all) {
            let scale = if all > 0.0 { 1.0 / all } else { 0.0 };
            row.iter_mut().for_each(|share| *share *= scale);
        }
        transfer
    }
}

fn face_parts(scene: &Scene, mesh: &Mesh, face: usize, k: u32) -> PatchGrid {
    PatchGrid::new(scene.faces[face].shape, mesh.faces[face].resolution, k)
}
