//! Direct light from outside the scene: the sky's faces are linked to the texels as lamps are.

use crate::hierarchy::final_gather::ReceiverSelection;
use crate::hierarchy::linker::{LinkMethod, LinkThresholds, RequestedLight};
use crate::hierarchy::solver::{ErrorBudget, HierarchicalSolver, MIN_REFLECTANCE, with_solver};
use common::Result;
use common::capture::sky::build_sky_faces;
use common::escape::{escape_directions, meets_front};
use common::mesh::Mesh;
use common::passes::ProgressCallback;
use common::rays::Rays;
use common::scene::Scene;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// Relative error of light from outside in a solve by shooting or by the dense system.
pub const SKY_ERROR: f32 = 0.005;

/// Rays that look for a way out of the scene.
const OUTSIDE_RAY_COUNT: usize = 1 << 17;
/// Step between the directions of successive rays: coprime to their number, and large.
const DIRECTION_STRIDE: usize = 387;
/// Thresholds of the first gathering, which finds how much light there is.
const FIRST_THRESHOLDS: LinkThresholds = LinkThresholds {
    source: 2e-2,
    visibility: 2e-2,
    near: 2e-2,
    edge: 2e-2,
};
/// Approximate progress of both gatherings.
const GATHER_PROGRESS: [Range<f64>; 2] = [0.0..0.2, 0.2..1.0];

/// Sets the irradiance from outside of each texel of `mesh`, the mean over its area, to a relative `error`.
///
/// Errors: those of [`crate::hierarchy::solver::solve_scene`].
pub fn receive_sky(scene: &Scene, mesh: &mut Mesh, error: f32, watch: ProgressCallback) -> Result<()> {
    let Some(sky) = scene.sky.as_ref().filter(|_| sees_outside(mesh)) else {
        return Ok(());
    };
    let built = build_sky_faces(sky, mesh.origin, mesh.unit)?;
    let count = scene.faces.len();
    let whole = Scene {
        faces: scene.faces.iter().cloned().chain(built.faces).collect(),
        ..Scene::default()
    };
    let own = mesh.faces.iter().map(|face| face.resolution);
    let resolutions: Vec<[u32; 2]> = own.chain(built.resolutions).collect();
    let around = Mesh::within_bounds(&whole, &resolutions, 1, (mesh.origin, mesh.unit))?;
    // With one patch a face the texels are in the order of the faces.
    let texels = mesh.texels.len();
    let mut radiosity = vec![Vec3::ZERO; texels];
    radiosity.extend(built.radiosity);
    let received = with_solver(&whole, &around, &[], LinkMethod::Shafts, |mut solver| {
        let lamps = solver.fit_sources(&radiosity);
        let receivers = ReceiverSelection::on_faces(0..count);
        // Nearly all of the area is the sky's.
        let even = solver.area_mean(&radiosity).as_vec3();
        solver.scale = inverse_light(even * MIN_REFLECTANCE);
        let mut gather = |solver: &HierarchicalSolver, thresholds, progress| {
            let arriving = RequestedLight::Arriving;
            solver.gather_at_texels(arriving, &lamps, &receivers, thresholds, progress, watch)
        };
        let [first, second] = GATHER_PROGRESS;
        let estimate = gather(&solver, FIRST_THRESHOLDS, first)?;
        solver.scale = inverse_light(reflected_rms(&around, &estimate[..texels]));
        // Shadows of light from all sides are soft; a sun's edge is far above this.
        let soft_edges = ErrorBudget::for_error(error).direct.with_soft_edges();
        gather(&solver, soft_edges, second)
    })?;
    for (k, own) in mesh.texels_in_face_order().into_iter().enumerate() {
        mesh.texels[own].sky = received[k];
    }
    Ok(())
}

/// Returns whether any of about [`OUTSIDE_RAY_COUNT`] rays from the texels leaves the scene: a closed room needs no links.
fn sees_outside(mesh: &Mesh) -> bool {
    let rays = Rays::new(mesh);
    let directions = escape_directions();
    let each = (OUTSIDE_RAY_COUNT / mesh.texels.len().max(1)).clamp(1, directions.len());
    mesh.texels.par_iter().enumerate().any(|(k, texel)| {
        let face = &mesh.faces[texel.face as usize];
        (0..each).any(|n| {
            // All directions in turn from one texel to the next, spread evenly over the hemisphere.
            let d = directions[(k * each + n) * DIRECTION_STRIDE % directions.len()];
            !meets_front(&rays, face.sheet, texel.position, face.direction_in_frame(d))
        })
    })
}

/// Returns the RMS over the first texels of the light that they reflect of `received`.
fn reflected_rms(mesh: &Mesh, received: &[Vec3]) -> Vec3 {
    let (mut squares, mut area) = (DVec3::ZERO, 0.0);
    for (texel, h) in mesh.texels.iter().zip(received) {
        let light = (*h * texel.reflectance.max(Vec3::splat(MIN_REFLECTANCE))).as_dvec3();
        squares += light * light * f64::from(texel.area);
        area += f64::from(texel.area);
    }
    (squares / area.max(f64::MIN_POSITIVE)).map(f64::sqrt).as_vec3()
}

/// Returns 1/light in each channel; 0 without light.
fn inverse_light(light: Vec3) -> Vec3 {
    light.map(|light| if light > 0.0 { 1.0 / light } else { 0.0 })
}
