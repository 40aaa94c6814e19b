//! One step of an adaptive solve, and its values on other texels.

use super::resolution::{resample_face, square_resolutions};
use common::mesh::Mesh;
use common::scene::Face;
use common::texel::first_texels;
use cpu::hierarchy::solver::HierarchicalSolution;
use glam::{DVec3, Vec3};

/// One step of an adaptive solve.
pub struct SolveStep {
    /// Texels per side of each face.
    pub sides: Vec<u32>,
    /// The texels with their ρ and E.
    pub mesh: Mesh,
    /// The hierarchical solution.
    pub outcome: HierarchicalSolution,
    /// ρH of each texel, in face order.
    pub reflected: Vec<DVec3>,
    /// B of each texel, in face order.
    pub radiosity: Vec<DVec3>,
}

impl SolveStep {
    /// Makes a step from `outcome` on `mesh`: B = E + ρH.
    pub fn new(sides: Vec<u32>, mesh: Mesh, outcome: HierarchicalSolution) -> Self {
        let reflected = |k: usize| (mesh.texels[k].reflectance * outcome.irradiance[k]).as_dvec3();
        let order = mesh.texels_in_face_order();
        let radiosity = |k: &usize| mesh.texels[*k].emission.as_dvec3() + reflected(*k);
        Self {
            radiosity: order.iter().map(radiosity).collect(),
            reflected: order.into_iter().map(reflected).collect(),
            sides,
            mesh,
            outcome,
        }
    }

    /// Replaces B of each texel, given in the mesh's order. (E of a captured wall is B₀ − ρH₀, and may change
    /// much from step to step.)
    pub fn with_radiosity(mut self, radiosity: &[Vec3]) -> Self {
        let order = self.mesh.texels_in_face_order().into_iter();
        self.radiosity = order.map(|k| radiosity[k].as_dvec3()).collect();
        self
    }

    /// Error of the step's coarse light over `goal`, on `to` texels per side of each face.
    pub fn coarse_error(&self, faces: &[Face], to: &[u32], goal: f64) -> Vec<f32> {
        let off = |k: usize| DVec3::splat(f64::from(self.outcome.coarse_error[k]) / goal);
        resample_step(faces, self, to, &off)
            .iter()
            .map(|off| off.x as f32)
            .collect()
    }
}

/// Resamples values of the texels of `step` (in its mesh's order) to `to` texels per side of each face: means
/// over areas, in face order.
pub fn resample_step(faces: &[Face], step: &SolveStep, to: &[u32], values: &dyn Fn(usize) -> DVec3) -> Vec<DVec3> {
    let first = first_texels(&square_resolutions(&step.sides));
    let ordered: Vec<DVec3> = step.mesh.texels_in_face_order().into_iter().map(values).collect();
    let each = faces.iter().enumerate().map(|(f, face)| {
        let own = &ordered[first[f]..first[f + 1]];
        resample_face(own, face, step.sides[f], to[f])
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
