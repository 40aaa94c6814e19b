//! Objects put into a room whose light is known, B₀ and H₀: only what they change is solved.
//!
//! ```text
//! taken     T = (K₀ − K) B₀             on the room, where objects stand between
//! given     G = K B₀                    on the objects
//! change    δ = e + ρKδ                 e = −ρT on the room, E + ρG on the objects
//! ```
//! K₀ and K are transport without and with the objects. Where no object stands between nothing is asked,
//! and nothing changes.

use crate::hierarchy::descent::Receiving;
use crate::hierarchy::find::Way;
use crate::hierarchy::light::pull;
use crate::hierarchy::solve::{Goal, Outcome};
use crate::hierarchy::state::{Solve, prepared};
use crate::hierarchy::world::{Watch, What};
use crate::occlusion::occluders::Occluders;
use common::mesh::Mesh;
use common::scene::Scene;
use common::{Error, Result};
use glam::Vec3;
use std::ops::{ControlFlow, Range};

/// How much of the work each part takes, roughly.
const TAKEN: Range<f64> = 0.0..0.3;
/// See [`TAKEN`].
const GIVEN: Range<f64> = 0.3..0.5;
/// See [`TAKEN`].
const CHANGE: f64 = 0.5;

/// A room's light on the texels of a mesh whose first faces are the room's; of objects nothing is read.
pub struct Known<'a> {
    /// B₀ of each texel's open part, W/m².
    pub radiosity: &'a [Vec3],
    /// H₀ of it.
    pub irradiance: &'a [Vec3],
    /// The share of the texel's area that was open without objects.
    pub open: &'a [f32],
}

/// What the objects of `mesh`, which are dark but for their E, change of H, the mean over each texel's
/// area; on themselves all that they receive. E and ρ are the texels'. What objects take is found by shafts,
/// whatever the `way`.
///
/// Errors: those of [`crate::hierarchy::solve::solve`].
pub fn relight(
    scene: &Scene,
    mesh: &Mesh,
    known: &Known,
    off: &[f32],
    (goal, way): (Goal, Way),
    watch: Watch,
) -> Result<Outcome> {
    prepared(scene, mesh, off, way, |solve| {
        change(solve, known, goal, watch)
    })
}

fn change(mut solve: Solve, known: &Known, goal: Goal, watch: Watch) -> Result<Outcome> {
    let mesh = solve.world.mesh;
    let of_room = |k: usize| !mesh.is_object(mesh.texels[k].face);
    let on_room = |values: &[Vec3]| -> Vec<Vec3> {
        let value = |k: usize| if of_room(k) { values[k] } else { Vec3::ZERO };
        (0..values.len()).map(value).collect()
    };
    let texels = || 0..mesh.texels.len();
    solve.known = on_room(known.irradiance);
    solve.scale = solve.inverse_rms(&vec![Vec3::ZERO; mesh.texels.len()]);
    let area: Vec<f32> = texels()
        .map(|k| mesh.texels[k].area * known.open[k])
        .collect();
    let mut glow = pull(solve.world.tree, &area, &on_room(known.radiosity));
    solve.world.clusters.pull(solve.world.tree, &mut glow);

    let objects = Occluders::objects(mesh);
    let room = 0..mesh.room as usize;
    let near = Receiving::on(room.clone()).near(0.5 * radius(mesh));
    let what = What::Taken(&objects);
    let taken = solve.at_texels(what, &glow, &near, goal.direct.softened(), TAKEN, watch)?;
    let own = Receiving::on(room.end..mesh.faces.len());
    let given = solve.at_texels(What::Light, &glow, &own, goal.direct, GIVEN, watch)?;

    let once: Vec<Vec3> = texels()
        .map(|k| if of_room(k) { -taken[k] } else { given[k] })
        .collect();
    let reflected = solve.reflected(&solve.of_open(&once));
    let emission: Vec<Vec3> = texels()
        .map(|k| match of_room(k) {
            true => reflected[k],
            false => mesh.texels[k].emission + reflected[k],
        })
        .collect();
    if emission.iter().any(|e| !e.is_finite()) {
        return Err(Error::Fault("captured light is not finite".into()));
    }
    let ambient = solve.ambient(&emission);
    let mut told = |done: f64| -> ControlFlow<()> { watch(CHANGE + (1.0 - CHANGE) * done) };
    let light = solve.of_open(&once);
    let later = solve.bounced(&emission, &light, ambient, goal, &mut told)?;
    // What objects cover has lost all that it had.
    let covered = |k: usize| match of_room(k) {
        true => (known.open[k] - later.open[k]).max(0.0) * known.irradiance[k],
        false => Vec3::ZERO,
    };
    let irradiance = texels().map(|k| once[k] + later.irradiance[k] - covered(k));
    Ok(Outcome {
        irradiance: irradiance.collect(),
        ..later
    })
}

/// Of a ball around a typical object: half of the diagonal of all of them at most.
fn radius(mesh: &Mesh) -> f32 {
    let objects = mesh.faces.iter().skip(mesh.room as usize);
    let corners = objects.flat_map(|face| face.corners);
    let (low, high) = corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), c| {
        (low.min(c), high.max(c))
    });
    match low.x <= high.x {
        true => 0.5 * (high - low).max_element(),
        false => f32::INFINITY,
    }
}

/// H of each texel, the mean over its area, as `radiosity` of the texels' open parts sends it.
///
/// Errors: those of [`crate::hierarchy::solve::solve`].
pub fn irradiance(
    scene: &Scene,
    mesh: &Mesh,
    radiosity: &[Vec3],
    (goal, way): (Goal, Way),
    watch: Watch,
) -> Result<Vec<Vec3>> {
    prepared(scene, mesh, &[], way, |mut solve| {
        let glow = solve.glow(radiosity);
        solve.first_look(radiosity, &glow, watch)?;
        let all = Receiving::on(0..mesh.faces.len());
        solve.at_texels(What::Light, &glow, &all, goal.direct, 0.0..1.0, watch)
    })
}
