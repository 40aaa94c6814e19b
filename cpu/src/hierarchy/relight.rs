//! Relighting: objects are put into a room with known B₀ and H₀, and only the change is solved.
//!
//! ```text
//! occluded  T = (K₀ − K) B₀             on the room, where objects stand between
//! objects   G = K B₀                    on the objects
//! change    δ = e + ρKδ                 e = −ρT on the room, E + ρG on the objects
//! ```
//! K₀ and K are transport without and with the objects. Receivers whose view no object occludes are skipped.

use crate::hierarchy::final_gather::ReceiverSelection;
use crate::hierarchy::linker::{LinkMethod, RequestedLight};
use crate::hierarchy::solver::{ErrorBudget, HierarchicalSolver, TexelSolution, with_solver};
use crate::occlusion::occluders::Occluders;
use common::mesh::Mesh;
use common::passes::ProgressCallback;
use common::scene::Scene;
use common::{Error, Result};
use glam::Vec3;
use std::ops::{ControlFlow, Range};

/// Approximate progress of each step.
const OCCLUDED_PROGRESS: Range<f64> = 0.0..0.3;
/// See [`OCCLUDED_PROGRESS`].
const OBJECTS_PROGRESS: Range<f64> = 0.3..0.5;
/// See [`OCCLUDED_PROGRESS`].
const CHANGE_PROGRESS_START: f64 = 0.5;

/// A room's light on the texels of a mesh whose first faces are the room's; values on objects are not read.
pub struct RoomLight<'a> {
    /// B₀ of each texel's open part, W/m².
    pub radiosity: &'a [Vec3],
    /// H₀ of each texel's open part.
    pub irradiance: &'a [Vec3],
    /// Open share of each texel without objects.
    pub open: &'a [f32],
}

/// Solves for the change of H, the mean over each texel's area, that the objects of `mesh` cause; on the objects
/// themselves for all H. E and ρ are the texels'. Shafts find the occluded light whatever the `method`.
///
/// Errors: those of [`crate::hierarchy::solver::solve_scene`].
pub fn relight(
    scene: &Scene,
    mesh: &Mesh,
    known: &RoomLight,
    coarse_error: &[f32],
    (budget, method): (ErrorBudget, LinkMethod),
    watch: ProgressCallback,
) -> Result<TexelSolution> {
    with_solver(scene, mesh, coarse_error, method, |solver| {
        solve_change(solver, known, budget, watch)
    })
}

fn solve_change(
    mut solver: HierarchicalSolver,
    known: &RoomLight,
    budget: ErrorBudget,
    watch: ProgressCallback,
) -> Result<TexelSolution> {
    let mesh = solver.scene.mesh;
    let of_room = |k: usize| !mesh.is_object(mesh.texels[k].face);
    let on_room = |values: &[Vec3]| -> Vec<Vec3> {
        let value = |k: usize| if of_room(k) { values[k] } else { Vec3::ZERO };
        (0..values.len()).map(value).collect()
    };
    let texels = || 0..mesh.texels.len();
    solver.known = on_room(known.irradiance);
    solver.scale = solver.inverse_rms(&vec![Vec3::ZERO; mesh.texels.len()]);
    let area: Vec<f32> = texels().map(|k| mesh.texels[k].area * known.open[k]).collect();
    let sources = solver.fit_open_parts(&area, &on_room(known.radiosity));

    let objects = Occluders::from_objects(mesh);
    let room = 0..mesh.room_faces as usize;
    let on_room_faces = ReceiverSelection::on_faces(room.clone());
    let on_room_faces = on_room_faces.limit_radius(0.5 * object_radius(mesh));
    // Captured light comes from all sides.
    let soft_edges = budget.direct.with_soft_edges();
    let occluded = solver.gather_at_texels(
        RequestedLight::OccludedBy(&objects),
        &sources,
        &on_room_faces,
        soft_edges,
        OCCLUDED_PROGRESS,
        watch,
    )?;
    let on_objects = ReceiverSelection::on_faces(room.end..mesh.faces.len());
    let received = solver.gather_at_texels(
        RequestedLight::Arriving,
        &sources,
        &on_objects,
        budget.direct,
        OBJECTS_PROGRESS,
        watch,
    )?;

    let direct: Vec<Vec3> = texels()
        .map(|k| if of_room(k) { -occluded[k] } else { received[k] })
        .collect();
    let reflected = solver.reflected_radiosity(&solver.open_part_mean(&direct));
    let emission: Vec<Vec3> = texels()
        .map(|k| match of_room(k) {
            true => reflected[k],
            false => mesh.texels[k].emission + reflected[k],
        })
        .collect();
    if emission.iter().any(|e| !e.is_finite()) {
        return Err(Error::Fault("captured light is not finite".into()));
    }
    let ambient = solver.ambient_irradiance(&emission);
    let mut change_watch =
        |done: f64| -> ControlFlow<()> { watch(CHANGE_PROGRESS_START + (1.0 - CHANGE_PROGRESS_START) * done) };
    let light = solver.open_part_mean(&direct);
    let later = solver.solve_indirect(&emission, &light, ambient, budget, &mut change_watch)?;
    // A part that objects cover loses all its light.
    let covered = |k: usize| match of_room(k) {
        true => (known.open[k] - later.open[k]).max(0.0) * known.irradiance[k],
        false => Vec3::ZERO,
    };
    let irradiance = texels().map(|k| direct[k] + later.irradiance[k] - covered(k));
    Ok(TexelSolution {
        irradiance: irradiance.collect(),
        ..later
    })
}

/// Returns half of the longest side of the box around all objects, an estimate of one object's size.
fn object_radius(mesh: &Mesh) -> f32 {
    let objects = mesh.faces.iter().skip(mesh.room_faces as usize);
    let corners = objects.flat_map(|face| face.corners);
    let (low, high) = corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), c| {
        (low.min(c), high.max(c))
    });
    match low.x <= high.x {
        true => 0.5 * (high - low).max_element(),
        false => f32::INFINITY,
    }
}

/// Gathers H of each texel, the mean over its area, from the given `radiosity` of the texels' open parts.
///
/// Errors: those of [`crate::hierarchy::solver::solve_scene`].
pub fn gather_irradiance(
    scene: &Scene,
    mesh: &Mesh,
    radiosity: &[Vec3],
    (budget, method): (ErrorBudget, LinkMethod),
    watch: ProgressCallback,
) -> Result<Vec<Vec3>> {
    with_solver(scene, mesh, &[], method, |mut solver| {
        let sources = solver.fit_sources(radiosity);
        solver.estimate_direct(radiosity, &sources, watch)?;
        solver.gather_arriving(&sources, budget.direct, 0.0..1.0, watch)
    })
}
