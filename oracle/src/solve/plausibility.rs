//! Plausibility checks of a result: is there any light, and is it finite?

use common::mesh::{Mesh, Texel};
use common::scene::Scene;
use common::shooting::SolveRun;
use common::{Error, Result};
use glam::Vec3;
use rayon::prelude::*;

/// Largest number of pairs of faces to test for facing each other: a second's work.
const MAX_FACE_PAIRS: usize = 1 << 28;

/// Returns a note with the reason if everything is dark.
pub fn explain_darkness(scene: &Scene, mesh: &Mesh, run: &SolveRun) -> Option<String> {
    let shines = |t: &Texel| t.source_radiosity(1.0) + t.sky != Vec3::ZERO && t.area > 0.0;
    if !mesh.texels.iter().any(shines) {
        let cure = match scene.sky {
            Some(_) => {
                "if the faces are inside out, --two-sided makes a front of each back; a closed room needs --lamp X,Y,Z,W"
            }
            None => "give a material Ke (OBJ) or emissiveFactor (glTF)",
        };
        return Some(format!(
            "no face emits light, and none comes from outside: everything is dark; {cure}"
        ));
    }
    let irradiance = || run.field.irradiance.iter();
    let lit = irradiance().any(|h| h.truncate() != Vec3::ZERO);
    (!lit && run.converged && run.shooters > 0 && !could_reflect(mesh))
        .then(|| "no front sees a lamp: if the faces are inside out, --two-sided makes a front of each back".into())
}

/// Tests if some lamp faces something that reflects.
pub fn could_reflect(mesh: &Mesh) -> bool {
    let of = |holds: fn(&Texel) -> bool| {
        let texels = mesh.texels.iter().filter(|texel| texel.area > 0.0);
        let mut faces: Vec<u32> = texels.filter(|t| holds(t)).map(|t| t.face).collect();
        faces.dedup();
        faces
    };
    let lamps = of(|texel| texel.source_radiosity(1.0) != Vec3::ZERO);
    let others = of(|texel| texel.reflectance != Vec3::ZERO);
    if lamps.len() * others.len() > MAX_FACE_PAIRS {
        return true;
    }
    let face = |k: &u32| &mesh.faces[*k as usize];
    let lit = |lamp: &u32| others.iter().any(|other| face(lamp).can_face(face(other)));
    lamps.par_iter().any(lit)
}

/// Checks that all values of a run are finite.
///
/// Errors: [`Error::Input`] for light that grows without limit.
pub fn check_finite(scene: &Scene, run: &SolveRun) -> Result<()> {
    let field = &run.field;
    let finite = |values: &[glam::Vec4]| values.iter().all(|v| v.is_finite());
    if finite(&field.radiosity) && finite(&field.irradiance) && finite(&field.residual) {
        return Ok(());
    }
    Err(Error::bad_input(
        &scene.name,
        "",
        "its light grows without limit: do faces lie on each other, or pass through each other? --conserve bounds it",
    ))
}
