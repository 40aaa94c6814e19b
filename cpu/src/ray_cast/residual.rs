//! The residual of a given solution by rays, as [`crate::hierarchy::residual`] finds it by links.

use super::{MAX_BOUNCES, MAX_TRACING_ROUNDS, solve_emission};
use crate::dense::open_points::OpenParts;
use crate::hierarchy::residual::GatheredResidual;
use common::Result;
use common::mesh::{Mesh, Texel};
use common::passes::ProgressCallback;
use common::rays::Rays;
use common::scene::Scene;
use glam::Vec3;

/// Share of the progress that the first bounce takes.
const GATHER_PROGRESS: f64 = 0.4;
/// Sequences of random numbers: other ones than a solve's, whose noise would hide.
const ONCE_SEQUENCE: u32 = MAX_TRACING_ROUNDS;
const ALL_SEQUENCE: u32 = 2 * MAX_TRACING_ROUNDS;

/// Gathers the radiosity E + `reflected` at each texel of `mesh`, to an RMS `noise` relative to the reflected light;
/// `reflected` is ρH.
///
/// Errors: [`common::Error::Interrupted`].
pub fn gather_residual_by_rays(
    scene: &Scene,
    mesh: &Mesh,
    reflected: &[Vec3],
    noise: f32,
    watch: ProgressCallback,
) -> Result<GatheredResidual> {
    let rays = Rays::new(mesh);
    let parts = OpenParts::new(scene, mesh, &rays);
    let open = &parts.shares;
    // Reflected light leaves from the open part of a texel.
    let with_added = |added: &dyn Fn(usize, &Texel) -> Vec3| {
        let mut lit = mesh.clone();
        for (k, texel) in lit.texels.iter_mut().enumerate().filter(|(k, _)| open[*k] > 0.0) {
            texel.emission += added(k, &mesh.texels[k]) / open[k];
        }
        lit
    };
    let outside = |found: Vec<Vec3>| -> Vec<Vec3> {
        let texels = found.iter().zip(&mesh.texels);
        texels.map(|(h, texel)| *h + texel.sky).collect()
    };
    let given = with_added(&|k, _| reflected[k]);
    let once = solve_emission(&given, (&rays, &parts), (0, ONCE_SEQUENCE), noise, &mut |done| {
        watch(GATHER_PROGRESS * done)
    })?;
    let lit = with_added(&|_, texel| texel.reflectance * texel.sky);
    let every = solve_emission(&lit, (&rays, &parts), (MAX_BOUNCES, ALL_SEQUENCE), noise, &mut |done| {
        watch(GATHER_PROGRESS + (1.0 - GATHER_PROGRESS) * done)
    })?;
    let irradiance = outside(once.irradiance);
    let all = outside(every.irradiance);
    Ok(GatheredResidual {
        later: all.iter().zip(&irradiance).map(|(all, once)| *all - *once).collect(),
        irradiance,
        variance: [once.noise, every.noise].map(|noise| noise.into_iter().map(|d| d * d).collect()),
        open: parts.shares,
    })
}
