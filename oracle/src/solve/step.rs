//! One step of an adaptive solve, and its values on other texels.

use super::resolution::resample_face;
use common::mesh::Mesh;
use common::scene::Face;
use common::texel::{first_texels, texel_count};
use cpu::hierarchy::solver::TexelSolution;
use glam::{DVec3, Vec3};

/// One step of an adaptive solve.
pub struct SolveStep {
    /// Texels W×H of each face.
    pub resolutions: Vec<[u32; 2]>,
    /// First texel of each face, in face order, and the number of all.
    first_texels: Vec<usize>,
    /// The texels with their ρ and E.
    pub mesh: Mesh,
    /// The hierarchical solution.
    pub outcome: TexelSolution,
    /// ρH of each texel, in face order.
    pub reflected: Vec<DVec3>,
    /// B of each texel, in face order.
    pub radiosity: Vec<DVec3>,
    /// Noise of B of each texel, in face order: half of the difference between the halves of the rays. Its square is the
    /// variance.
    pub noise: Vec<DVec3>,
    /// What smoothing removed from B of each texel, in face order, for either half; empty without smoothing.
    removed: Vec<[DVec3; 2]>,
}

impl SolveStep {
    /// Makes a step from `outcome` on `mesh`: B = E + ρH.
    pub fn new(resolutions: Vec<[u32; 2]>, mesh: Mesh, outcome: TexelSolution) -> Self {
        let reflected = |k: usize| (mesh.texels[k].reflectance * outcome.irradiance[k]).as_dvec3();
        let order = mesh.texels_in_face_order();
        let radiosity = |k: &usize| mesh.texels[*k].emission.as_dvec3() + reflected(*k);
        let noise = |k: &usize| (mesh.texels[*k].reflectance * outcome.noise[*k]).as_dvec3();
        let removed = |k: &usize| {
            let halves = outcome.removed.get(*k)?;
            Some(halves.map(|half| (mesh.texels[*k].reflectance * half).as_dvec3()))
        };
        Self {
            removed: order.iter().filter_map(removed).collect(),
            noise: order.iter().map(noise).collect(),
            radiosity: order.iter().map(radiosity).collect(),
            reflected: order.into_iter().map(reflected).collect(),
            first_texels: first_texels(&resolutions),
            resolutions,
            mesh,
            outcome,
        }
    }

    /// Returns the noise variance of the means of B over `texels` of `face`, number `f`, times its area.
    pub fn noise_of_face(&self, face: &Face, f: usize, texels: [u32; 2]) -> DVec3 {
        let first = self.first_texels[f];
        let own = &self.noise[first..self.first_texels[f + 1]];
        let means = resample_face(own, face, self.resolutions[f], texels);
        means.iter().map(|d| *d * *d).sum::<DVec3>() * face.area() / f64::from(texel_count(texels))
    }

    /// Returns the squared light that smoothing removed from the means of B over `texels` of `face`, number `f`, times its area.
    pub fn removed_from_face(&self, face: &Face, f: usize, texels: [u32; 2]) -> DVec3 {
        let Some(own) = self.removed.get(self.first_texels[f]..self.first_texels[f + 1]) else {
            return DVec3::ZERO;
        };
        let [a, b] = [0, 1].map(|half| {
            let values: Vec<DVec3> = own.iter().map(|halves| halves[half]).collect();
            resample_face(&values, face, self.resolutions[f], texels)
        });
        let product = a.iter().zip(&b).map(|(a, b)| *a * *b).sum::<DVec3>();
        product * face.area() / f64::from(texel_count(texels))
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
    let first = &step.first_texels;
    let ordered: Vec<DVec3> = step.mesh.texels_in_face_order().into_iter().map(values).collect();
    let each = faces.iter().enumerate().map(|(f, face)| {
        let own = &ordered[first[f]..first[f + 1]];
        resample_face(own, face, step.resolutions[f], to[f])
    });
    each.flatten().collect()
}

/// Returns the open area of each texel of `step`.
pub fn open_areas(step: &SolveStep) -> Vec<f32> {
    let texels = step.mesh.texels.iter().zip(&step.outcome.open);
    texels.map(|(texel, open)| texel.area * open).collect()
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
