//! Relighting by rays: the equations of [`crate::hierarchy::relight`] on rays that are traced with and without the
//! objects, so that what the objects leave alone cancels exactly.

use super::RaySolver;
use super::pair_rays::PairRays;
use super::texel_blocks::TexelBlocks;
use crate::dense::open_points::OpenParts;
use crate::hierarchy::relight::RoomLight;
use crate::hierarchy::solver::TexelSolution;
use common::mesh::Mesh;
use common::passes::ProgressCallback;
use common::rays::Rays;
use common::scene::Scene;
use common::{Error, Result};
use glam::Vec3;

/// Solves for the change of H, the mean over each texel's area, that the objects of `mesh` cause; on the objects
/// themselves for all H; to an RMS `noise` relative to the light that the room reflects where it changes, and to that of the
/// objects. E and ρ are the texels'. Those of the room receive in blocks of `block_sizes` texels, and are interpolated.
///
/// Errors: [`Error::Interrupted`]; captured light that overflows.
pub fn relight_by_rays(
    scene: &Scene,
    mesh: &Mesh,
    known: &RoomLight,
    block_sizes: Vec<[u32; 2]>,
    noise: f32,
    watch: ProgressCallback,
) -> Result<TexelSolution> {
    let rays = Rays::new(mesh);
    let parts = OpenParts::new(scene, mesh, &rays);
    let open = &parts.shares;
    let of_room = |k: usize| !mesh.is_object(mesh.texels[k].face);
    let received = |k: usize| match of_room(k) {
        true => known.irradiance[k] * known.open[k],
        false => Vec3::ZERO,
    };
    let received: Vec<Vec3> = (0..open.len()).map(received).collect();
    // What stands on a block would be smeared over it.
    let blocks = TexelBlocks::new(mesh, block_sizes, |k| open[k] < 1.0);
    let mut solver = RaySolver {
        known: &received,
        blocks: Some(&blocks),
        ..RaySolver::new(mesh, open)
    };
    let mut traced = PairRays::new((mesh, &blocks), &rays, &parts, known);
    let mut found = solver.solve_to_noise(&mut traced, noise, watch)?;
    blocks.interpolate_blocks(mesh, &mut found.irradiance);
    blocks.interpolate_blocks(mesh, &mut found.noise);
    for k in (0..open.len()).filter(|k| of_room(*k)) {
        // A part that objects cover loses all its light.
        found.irradiance[k] -= (known.open[k] - open[k]).max(0.0) * known.irradiance[k];
    }
    match found.irradiance.iter().all(|h| h.is_finite()) {
        true => Ok(found),
        false => Err(Error::Fault("captured light is not finite".into())),
    }
}
