//! A result of whatever origin, judged by its own light: what it shines is gathered anew at every texel, and
//! what that finds wrong is followed through all later bounces.
//!
//! ```text
//! r = E + ρKB − B      e = r + ρKr + (ρK)²r + …      B + e solves the equation
//! ```

use super::interrupt::interrupted;
use super::watch::Watch;
use crate::judge::diff::Diff;
use common::cover::sample;
use common::energy::Energy;
use common::mesh::Mesh;
use common::scene::Scene;
use common::solution::Stored;
use common::{Error, Result};
use cpu::hierarchy::account;
use cpu::hierarchy::anew::{Anew, anew};
use cpu::hierarchy::solve::{Goal, Outcome};
use glam::{DVec3, Vec3};
use std::ops::ControlFlow;

/// The error to which light is gathered, a share: less cannot be told from none.
pub const FLOOR: f32 = 0.005;
/// Points of a face that tell what of its light escapes.
const POINTS: u32 = 16;

/// What is found.
pub struct Judged {
    /// B + e, in the result's layout.
    pub truth: Stored,
    /// The result against it.
    pub diff: Diff,
    /// RMS of r over that of B − E, the worst channel.
    pub one_bounce: f64,
    /// Where the result's light goes.
    pub energy: Energy,
}

/// Judges `stored`; of `scene`, where it is given, is what faces reflect and emit.
///
/// Errors: faces of W×H texels, reflectances that are not there, [`Error::Interrupted`].
pub fn judge(stored: &Stored, scene: Option<Scene>, watch: &Watch) -> Result<Judged> {
    let mut truth = stored.clone();
    truth.dir = "its own light, gathered anew".into();
    truth.scene.notes.clear();
    // Nobody states an error of it.
    truth.others.remove("error");
    if let Some(scene) = scene {
        if scene.faces.len() != stored.scene.faces.len() {
            return Err(Error::Usage(format!(
                "{} has {} faces, {} has {}: a result is judged with the scene it was solved from",
                scene.name,
                scene.faces.len(),
                stored.dir.display(),
                stored.scene.faces.len()
            )));
        }
        truth.scene = scene;
        truth.others.remove("reflectance");
    }
    let mut mesh = watch.of("prepare", || meshed(&truth))?;
    let order = mesh.in_face_order();
    if mesh.texels.iter().all(|t| t.reflectance == Vec3::ZERO) {
        return Err(Error::Usage(format!(
            "{} says of no face what it reflects: give --scene",
            stored.dir.display()
        )));
    }
    let mut reflected = vec![Vec3::ZERO; mesh.texels.len()];
    for (k, value) in order.iter().zip(stored.reflected()) {
        reflected[*k] = value.as_vec3();
    }
    let found = watch.of("solve", || {
        let mut told = |done| {
            if interrupted() {
                return ControlFlow::Break(());
            }
            watch.tell("gathering", done)
        };
        anew(&truth.scene, &mesh, &reflected, Goal::of(FLOOR), &mut told)
    })?;
    let (mut squares, mut light) = (DVec3::ZERO, DVec3::ZERO);
    for (n, k) in order.iter().enumerate() {
        let texel = &mesh.texels[*k];
        let once = texel.reflectance * found.irradiance[*k];
        truth.radiosity[n] = truth.emission[n] + once + texel.reflectance * found.later[*k];
        let area = f64::from(texel.area);
        squares += area * (once - reflected[*k]).as_dvec3().powf(2.0);
        light += area * reflected[*k].as_dvec3().powf(2.0);
    }
    let share = |c: usize| {
        if squares[c] == 0.0 {
            0.0
        } else {
            (squares[c] / light[c]).sqrt()
        }
    };
    Ok(Judged {
        one_bounce: (0..3).map(share).fold(0.0, f64::max),
        diff: Diff::new(stored, &truth)?,
        energy: energy(stored, &mut mesh, &reflected, &found),
        truth,
    })
}

/// The faces with the texels, reflectances and emissions of a result.
fn meshed(stored: &Stored) -> Result<Mesh> {
    let mut mesh = Mesh::new(&stored.scene, &stored.resolutions, 1)?;
    let order = mesh.in_face_order();
    for (n, k) in order.into_iter().enumerate() {
        let texel = &mut mesh.texels[k];
        texel.emission = stored.emission[n];
        if let Some(reflectance) = stored.others.get("reflectance") {
            texel.reflectance = reflectance[n];
        }
    }
    sample(&mut mesh, POINTS);
    Ok(mesh)
}

/// The account of the result's own light; what it does not say of its irradiance follows from B − E, and
/// of a texel that reflects nothing from the light gathered anew.
fn energy(stored: &Stored, mesh: &mut Mesh, reflected: &[Vec3], found: &Anew) -> Energy {
    let mut irradiance = found.irradiance.clone();
    let mut residual = vec![Vec3::ZERO; mesh.texels.len()];
    for (n, k) in mesh.in_face_order().into_iter().enumerate() {
        let rho = mesh.texels[k].reflectance;
        let own = Vec3::select(rho.cmpgt(Vec3::ZERO), reflected[k] / rho, irradiance[k]);
        let of = |name: &str| stored.others.get(name).map(|values| values[n]);
        irradiance[k] = of("irradiance").unwrap_or(own);
        residual[k] = of("residual").unwrap_or_default();
    }
    let outcome = Outcome {
        irradiance,
        residual,
        open: found.open.clone(),
        off: Vec::new(),
        links: 0,
        passes: 0,
        spent: true,
    };
    account::uncover(mesh, &outcome);
    let run = account::run(mesh, &outcome);
    Energy::new(mesh, &run.field, &run.shots)
}
