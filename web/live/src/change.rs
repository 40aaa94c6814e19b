//! Changes of a scene: lamps that are moved and dimmed, surfaces of another reflectance.

use common::paint::MAX_WHITE_REFLECTANCE;
use common::scene::{Face, Scene};
use common::{Error, Result};
use glam::{DVec3, Vec3};
use serde::Deserialize;

/// Change of all faces of one name.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroupChange {
    /// Name of the faces.
    pub name: String,
    /// Way by which they are moved, in the scene's unit.
    #[serde(default)]
    pub shift: [f64; 3],
    /// Factor of what they emit.
    #[serde(default = "unchanged_emission")]
    pub emission_factor: f32,
    /// Their reflectance, 0 ≤ ρ < 1; none leaves it.
    #[serde(default)]
    pub reflectance: Option<[f32; 3]>,
}

fn unchanged_emission() -> f32 {
    1.0
}

/// Returns the scene with all `changes`.
///
/// Errors: [`Error::Usage`] of a name that no face has, or of a number out of range.
pub fn change_scene(scene: &Scene, changes: &[GroupChange]) -> Result<Scene> {
    let mut changed = scene.clone();
    for change in changes {
        check_change(change)?;
        let mut found = false;
        for face in changed.faces.iter_mut().filter(|face| face.name == change.name) {
            found = true;
            change_face(face, change);
        }
        if !found {
            return Err(Error::Usage(format!("no face is called {:?}", change.name)));
        }
    }
    Ok(changed)
}

fn change_face(face: &mut Face, change: &GroupChange) {
    let shift = DVec3::from_array(change.shift);
    face.corners = face.corners.map(|corner| corner + shift);
    face.emission *= change.emission_factor;
    if let Some(reflectance) = change.reflectance {
        face.reflectance = Vec3::from_array(reflectance);
    }
    if change.reflectance.is_some() || change.emission_factor != 1.0 {
        // One colour takes the place of a picture.
        face.paint = None;
    }
}

fn check_change(change: &GroupChange) -> Result<()> {
    let is_reflectance = |x: f32| (0.0..=MAX_WHITE_REFLECTANCE).contains(&x);
    if !change.shift.iter().all(|x| x.is_finite()) {
        return Err(Error::Usage(format!(
            "{:?} cannot be moved by {:?}",
            change.name, change.shift
        )));
    }
    if !(change.emission_factor.is_finite() && change.emission_factor >= 0.0) {
        let factor = change.emission_factor;
        return Err(Error::Usage(format!(
            "{:?} cannot emit {factor} times its light",
            change.name
        )));
    }
    match change.reflectance {
        Some(rho) if !rho.iter().copied().all(is_reflectance) => Err(Error::Usage(format!(
            "{:?} cannot reflect {rho:?}: at most {MAX_WHITE_REFLECTANCE} of the light, at least 0",
            change.name
        ))),
        _ => Ok(()),
    }
}
