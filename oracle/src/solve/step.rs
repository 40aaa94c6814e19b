//! One step of a solve to an error.

use super::sides::{averaged, squares};
use crate::judge::diff::reflected::offsets;
use common::mesh::Mesh;
use common::scene::Face;
use cpu::hierarchy::solve::Outcome;
use glam::{DVec3, Vec3};

/// One step.
pub struct Step {
    /// Texels a side of each face.
    pub sides: Vec<u32>,
    /// Them, with their own ρ and E.
    pub mesh: Mesh,
    /// What was found.
    pub outcome: Outcome,
    /// ρH of each texel, in face order.
    pub reflected: Vec<DVec3>,
    /// And B.
    pub radiosity: Vec<DVec3>,
}

impl Step {
    /// Of `outcome` on `mesh`: B = E + ρH.
    pub fn new(sides: Vec<u32>, mesh: Mesh, outcome: Outcome) -> Self {
        let reflected = |k: usize| (mesh.texels[k].reflectance * outcome.irradiance[k]).as_dvec3();
        let order = mesh.in_face_order();
        let radiosity = |k: &usize| mesh.texels[*k].emission.as_dvec3() + reflected(*k);
        Self {
            radiosity: order.iter().map(radiosity).collect(),
            reflected: order.into_iter().map(reflected).collect(),
            sides,
            mesh,
            outcome,
        }
    }

    /// The same with the B of each texel, in the mesh's order: of a captured wall E is what ρH leaves, and
    /// may be much where it was little before.
    pub fn shining(mut self, radiosity: &[Vec3]) -> Self {
        let order = self.mesh.in_face_order().into_iter();
        self.radiosity = order.map(|k| radiosity[k].as_dvec3()).collect();
        self
    }

    /// How far its coarse light was off, over `goal`, on `to` texels a side of each face.
    pub fn off(&self, faces: &[Face], to: &[u32], goal: f64) -> Vec<f32> {
        let off = |k: usize| DVec3::splat(f64::from(self.outcome.off[k]) / goal);
        onto(faces, self, to, &off)
            .iter()
            .map(|off| off.x as f32)
            .collect()
    }
}

/// Of each texel of `step`, in its mesh's order, on `to` texels a side of each face: means over areas, in
/// face order.
pub fn onto(
    faces: &[Face],
    step: &Step,
    to: &[u32],
    values: &dyn Fn(usize) -> DVec3,
) -> Vec<DVec3> {
    let first = offsets(&squares(&step.sides));
    let ordered: Vec<DVec3> = step.mesh.in_face_order().into_iter().map(values).collect();
    let each = faces.iter().enumerate().map(|(f, face)| {
        let own = &ordered[first[f]..first[f + 1]];
        averaged(own, face, step.sides[f], to[f])
    });
    each.flatten().collect()
}

/// As f32.
pub fn narrowed(values: Vec<DVec3>) -> Vec<Vec3> {
    values.into_iter().map(|v| v.as_vec3()).collect()
}
