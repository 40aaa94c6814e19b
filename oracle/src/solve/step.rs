//! One step of an adaptive solve, and its values on other texels.

use super::resolution::resample_face;
use common::mesh::Mesh;
use common::scene::Face;
use common::texel::first_texels;
use cpu::hierarchy::solver::TexelSolution;
use glam::{DVec3, Vec3};

/// One step of an adaptive solve.
pub struct SolveStep {
    /// Texels W×H of each face.
    pub resolutions: Vec<[u32; 2]>,
    /// The texels with their ρ and E.
    pub mesh: Mesh,
    /// The hierarchical solution.
    pub outcome: TexelSolution,
    /// ρH of each texel, in face order.
    pub reflected: Vec<DVec3>,
    /// B of each texel, in face order.
    pub radiosity: Vec<DVec3>,
    /// Variance of B of each texel from the noise of rays, in face order.
    pub variance: Vec<DVec3>,
}

impl SolveStep {
    /// Makes a step from `outcome` on `mesh`: B = E + ρH.
    pub fn new(resolutions: Vec<[u32; 2]>, mesh: Mesh, outcome: TexelSolution) -> Self {
        let reflected = |k: usize| (mesh.texels[k].reflectance * outcome.irradiance[k]).as_dvec3();
        let order = mesh.texels_in_face_order();
        let radiosity = |k: &usize| mesh.texels[*k].emission.as_dvec3() + reflected(*k);
        let variance = |k: &usize| {
            let reflectance = mesh.texels[*k].reflectance.as_dvec3();
            reflectance * reflectance * outcome.variance[*k].as_dvec3()
        };
        Self {
            variance: order.iter().map(variance).collect(),
            radiosity: order.iter().map(radiosity).collect(),
            reflected: order.into_iter().map(reflected).collect(),
            resolutions,
            mesh,
            outcome,
        }
    }

    /// Returns the RMS noise of B over the RMS of ρH, in the worst channel.
    pub fn relative_noise(&self) -> f64 {
        let (mut noise, mut light) = (DVec3::ZERO, DVec3::ZERO);
        for (n, k) in self.mesh.texels_in_face_order().into_iter().enumerate() {
            let area = f64::from(self.mesh.texels[k].area);
            noise += self.variance[n] * area;
            light += self.reflected[n] * self.reflected[n] * area;
        }
        let share = |c: usize| {
            if noise[c] > 0.0 {
                (noise[c] / light[c]).sqrt()
            } else {
                0.0
            }
        };
        share(0).max(share(1)).max(share(2))
    }

    /// Replaces B of each texel, given in the mesh's order. (E of a captured wall is B₀ − ρH₀, and may change
    /// much from step to step.)
    pub fn with_radiosity(mut self, radiosity: &[Vec3]) -> Self {
        let order = self.mesh.texels_in_face_order().into_iter();
        self.radiosity = order.map(|k| radiosity[k].as_dvec3()).collect();
        self
    }

    /// Error of the step's coarse light over `goal`, on `to` texels of each face.
    pub fn coarse_error(&self, faces: &[Face], to: &[[u32; 2]], goal: f64) -> Vec<f32> {
        let off = |k: usize| DVec3::splat(f64::from(self.outcome.coarse_error[k]) / goal);
        resample_step(faces, self, to, &off)
            .iter()
            .map(|off| off.x as f32)
            .collect()
    }
}

/// Resamples values of the texels of `step` (in its mesh's order) to `to` texels of each face: means over areas, in face
/// order.
pub fn resample_step(faces: &[Face], step: &SolveStep, to: &[[u32; 2]], values: &dyn Fn(usize) -> DVec3) -> Vec<DVec3> {
    let first = first_texels(&step.resolutions);
    let ordered: Vec<DVec3> = step.mesh.texels_in_face_order().into_iter().map(values).collect();
    let each = faces.iter().enumerate().map(|(f, face)| {
        let own = &ordered[first[f]..first[f + 1]];
        resample_face(own, face, step.resolutions[f], to[f])
    });
    each.flatten().collect()
}

/// Converts to f32.
pub fn narrow_to_f32(values: Vec<DVec3>) -> Vec<Vec3> {
    values.into_iter().map(|v| v.as_vec3()).collect()
}

impl AsRef<SolveStep> for SolveStep {
    fn as_ref(&self) -> &SolveStep {
        self
    }
}
