//! Whether there is any light at all, and whether it has a limit.

use common::mesh::{Mesh, Texel};
use common::scene::Scene;
use common::shooting::Run;
use common::{Error, Result};
use glam::Vec3;
use rayon::prelude::*;

/// Pairs of faces that are asked whether they face each other: a second's work.
const PAIRS: usize = 1 << 28;

/// What is to be said of an answer in which all is dark.
pub fn missing(mesh: &Mesh, run: &Run) -> Option<String> {
    let shines = |t: &Texel| t.emission != Vec3::ZERO && t.area > 0.0;
    if !mesh.texels.iter().any(shines) {
        return Some("no face emits light: everything is dark; give a material Ke (OBJ) or emissiveFactor (glTF)".into());
    }
    let irradiance = || run.field.irradiance.iter();
    let lit = irradiance().any(|h| h.truncate() != Vec3::ZERO);
    (!lit && run.converged && run.shooters > 0 && !could_reflect(mesh)).then(|| {
        "no front sees a lamp: if the faces are inside out, --two-sided makes a front of each back"
            .into()
    })
}

/// Whether some lamp faces something that reflects.
pub fn could_reflect(mesh: &Mesh) -> bool {
    let of = |holds: fn(&Texel) -> bool| {
        let texels = mesh.texels.iter().filter(|texel| texel.area > 0.0);
        let mut faces: Vec<u32> = texels.filter(|t| holds(t)).map(|t| t.face).collect();
        faces.dedup();
        faces
    };
    let lamps = of(|texel| texel.emission != Vec3::ZERO);
    let others = of(|texel| texel.reflectance != Vec3::ZERO);
    if lamps.len() * others.len() > PAIRS {
        return true;
    }
    let face = |k: &u32| &mesh.faces[*k as usize];
    let lit = |lamp: &u32| others.iter().any(|other| face(lamp).faces(face(other)));
    lamps.par_iter().any(lit)
}

/// Refuses an answer that f32 could not hold.
pub fn finite(scene: &Scene, run: &Run) -> Result<()> {
    let field = &run.field;
    let finite = |values: &[glam::Vec4]| values.iter().all(|v| v.is_finite());
    if finite(&field.radiosity) && finite(&field.irradiance) && finite(&field.residual) {
        return Ok(());
    }
    Err(Error::input(
        &scene.name,
        "",
        "its light grows without limit: do faces lie on each other, or pass through each other? --conserve bounds it",
    ))
}
