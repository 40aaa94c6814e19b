//! Solutions by a caller's solver, and their comparison.

use crate::scene::MeshedScene;
use crate::violation::Violation;
use common::mesh::Mesh;
use common::scene::Scene;
use glam::{DVec3, Vec3};

/// Anything that solves a scene: returns the radiosity of each texel of the mesh, W/m², in the mesh's order. A solver
/// with texels of its own finds those of the mesh by [`common::texel::texel_outline`], from the face and the index of
/// [`common::mesh::Texel`].
pub type SceneSolver<'s> = dyn Fn(&Scene, &Mesh) -> Vec<Vec3> + 's;

/// Names of the channels.
pub(crate) const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// Values of the texels of a mesh, finite, not negative, and not all 0 where faces emit light.
pub(crate) struct Solution {
    /// Mesh.
    pub mesh: Mesh,
    /// Name of each face.
    names: Vec<String>,
    /// Value of each texel, W/m².
    pub values: Vec<DVec3>,
}

impl Solution {
    /// Solves a scene and checks that the values can be compared.
    ///
    /// Errors: [`Violation::Painted`], [`Violation::Mesh`], [`Violation::Length`], [`Violation::Value`],
    /// [`Violation::Dark`].
    pub fn new(solver: &SceneSolver, scene: &MeshedScene) -> Result<Self, Violation> {
        if let Some(k) = scene.scene.faces.iter().position(|face| face.paint.is_some()) {
            return Err(Violation::Painted(scene.scene.face_label(k)));
        }
        let mesh = scene.mesh()?;
        let values = solver(&scene.scene, &mesh);
        if values.len() != mesh.texels.len() {
            let (texels, values) = (mesh.texels.len(), values.len());
            return Err(Violation::Length { texels, values });
        }
        let names = scene.scene.faces.iter().map(|face| face.name.clone()).collect();
        let solution = Self {
            mesh,
            names,
            values: values.iter().map(|value| value.as_dvec3()).collect(),
        };
        for (k, value) in values.iter().enumerate() {
            let is_wrong = |c: &usize| !(value[*c].is_finite() && value[*c] >= 0.0);
            if let Some(channel) = (0..3).find(is_wrong) {
                let (place, value) = (solution.texel_label(k, channel), value[channel]);
                return Err(Violation::Value { place, value });
            }
        }
        let is_lit = solution.mesh.texels.iter().any(|texel| texel.emission != Vec3::ZERO);
        match is_lit && values.iter().all(|value| *value == Vec3::ZERO) {
            true => Err(Violation::Dark),
            false => Ok(solution),
        }
    }

    /// Returns the name of a texel's channel: "texel 3 of face 1 (ceiling), red".
    pub fn texel_label(&self, k: usize, channel: usize) -> String {
        let texel = &self.mesh.texels[k];
        let name = &self.names[texel.face as usize];
        let (index, face) = (texel.index, texel.face + 1);
        format!("texel {index} of face {face} ({name}), {}", CHANNELS[channel])
    }

    /// Returns the largest value of each channel.
    pub fn largest(&self) -> DVec3 {
        self.values.iter().fold(DVec3::ZERO, |most, value| most.max(*value))
    }

    /// Compares each value with `expected(k)`, within `bound(k)`.
    ///
    /// Errors: [`Violation::Differs`].
    pub fn compare(
        &self,
        property: &'static str,
        expected: impl Fn(usize) -> DVec3,
        bound: impl Fn(usize) -> DVec3,
    ) -> Result<(), Violation> {
        for (k, found) in self.values.iter().enumerate() {
            let (expected, bound) = (expected(k), bound(k));
            for c in 0..3 {
                let place = || self.texel_label(k, c);
                check_value(property, place, [found[c], expected[c]], bound[c])?;
            }
        }
        Ok(())
    }

    /// Compares each value with that of texel `texels[k]` of another solution. The tolerance is a share of the largest
    /// value of the channel.
    ///
    /// Errors: [`Violation::Differs`]; [`Violation::Nothing`] if all values are 0.
    pub fn compare_with(
        &self,
        property: &'static str,
        other: &Self,
        texels: &[usize],
        tolerance: f64,
    ) -> Result<(), Violation> {
        let largest = self.largest().max(other.largest());
        if largest == DVec3::ZERO {
            return Err(Violation::nothing(property, "no face emits light"));
        }
        let bound = tolerance * largest;
        self.compare(property, |k| other.values[texels[k]], |_| bound)
    }
}

/// Compares a value with what is expected.
///
/// Errors: [`Violation::Differs`], also of values that are not numbers.
pub(crate) fn check_value(
    property: &'static str,
    place: impl Fn() -> String,
    [found, expected]: [f64; 2],
    bound: f64,
) -> Result<(), Violation> {
    let is_near = (found - expected).abs() <= bound;
    is_near.then_some(()).ok_or_else(|| Violation::Differs {
        property,
        place: place(),
        found,
        expected,
        bound,
    })
}

/// Checks that a tolerance is a share: 0 ≤ `tolerance` < 1.
///
/// Errors: [`Violation::Nothing`].
pub(crate) fn check_tolerance(property: &'static str, tolerance: f64) -> Result<(), Violation> {
    let is_share = (0.0..1.0).contains(&tolerance);
    let reason = || format!("the tolerance is {tolerance}");
    is_share
        .then_some(())
        .ok_or_else(|| Violation::nothing(property, reason()))
}
