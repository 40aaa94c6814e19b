//! Radiosity by rays, for scenes of many small faces: each texel's rays are traced once, and the texels that they meet
//! are kept. A form factor is the share of the rays that meet a texel.
//!
//! ```text
//! H = D + H_sky + F ρH      F_kj = rays of texel k that meet texel j, over all rays of k
//! ```
//! D, the light of the lamps, is estimated by the same rays and as many to points of lamps (`texel_rays`,
//! `lamp_tree`). The rays of a texel are two halves with sequences of their own. The system is solved for each half;
//! the answer is the mean of the two, and its noise half of their difference. Rays are added where they reduce the noise
//! most, until it is as small as requested.

mod lamp_tree;
mod seen_lamp;
mod texel_rays;

use crate::hierarchy::solver::{HierarchicalSolution, open_shares};
use common::mesh::{Mesh, Texel};
use common::passes::ProgressCallback;
use common::rays::Rays;
use common::scene::Scene;
use common::{Error, Result};
use glam::{DVec3, Vec3, Vec3A};
use std::ops::ControlFlow;
use texel_rays::{Halves, TexelRays};

/// Mean number of rays of each half with which a solve begins.
const FIRST_RAY_COUNT: f32 = 8.0;
/// Least number of rays of each half of a texel.
const MIN_RAY_COUNT: f32 = 2.0;
/// Largest number of rays of each half of a texel, as far as the Sobol sequence goes.
const MAX_RAY_COUNT: f32 = 65_535.0;
/// Largest number of all rays of both halves; each is kept in 4 bytes.
const MAX_TOTAL_RAYS: u64 = 1 << 27;
/// Largest growth of a texel's number of rays in one round.
const MAX_RAY_GROWTH: f32 = 16.0;
/// Growth above which rays are distributed anew, and those traced so far discarded.
const MIN_DISCARD_GROWTH: f32 = 3.0;
/// The noise variance of n stratified rays falls as n to minus this power.
const VARIANCE_EXPONENT: f32 = 1.25;
/// Rounds of tracing.
const MAX_TRACING_ROUNDS: u32 = 16;
/// The iteration ends when this share of the first power is unshot.
const UNSHOT_SHARE: f64 = 1e-5;
/// Largest number of bounces.
const MAX_BOUNCES: u32 = 2000;

/// Solves `scene` on the texels of `mesh` to an RMS `noise` relative to the reflected light.
///
/// Errors: [`Error::Interrupted`].
pub fn solve_by_rays(scene: &Scene, mesh: &Mesh, noise: f32, watch: ProgressCallback) -> Result<HierarchicalSolution> {
    let rays = Rays::new(mesh);
    let open = open_shares(scene, mesh);
    let mut traced = TexelRays::new(mesh, &rays);
    let mut solver = RaySolver { mesh, open, passes: 0 };
    let mut counts = solver.first_counts();
    let mut last = false;
    for round in 0.. {
        // Each round takes half of the remaining progress.
        let left = 0.5f64.powi(round as i32);
        let mut part = |done: f64| watch(1.0 - left + 0.5 * left * done);
        traced.trace_rays(&counts, &mut part)?;
        let bounces = solver.iterate_bounces(&traced, &mut || watch(1.0 - 0.5 * left))?;
        let found = solver.relative_noise(&bounces);
        let total: u64 = counts.iter().map(|n| 2 * u64::from(*n)).sum();
        last |= found <= noise || round + 1 >= MAX_TRACING_ROUNDS;
        if !last {
            let growth = (found / noise).powf(2.0 / VARIANCE_EXPONENT).min(MAX_RAY_GROWTH);
            let next = match growth > MIN_DISCARD_GROWTH {
                true => solver.distribute_rays(&traced, &counts, &bounces, growth),
                false => counts.iter().map(|n| grow_count(*n, growth)).collect(),
            };
            let next = limit_total(next, &counts);
            last = next == counts;
            if growth > MIN_DISCARD_GROWTH && !last {
                traced.discard_rays();
            }
            counts = next;
        }
        if last {
            return Ok(solver.finish(&bounces, total));
        }
    }
    Err(Error::Interrupted)
}

/// Returns `count` times `growth`, at least one more.
fn grow_count(count: u32, growth: f32) -> u32 {
    (count as f32 * growth)
        .ceil()
        .max(count as f32 + 1.0)
        .min(MAX_RAY_COUNT) as u32
}

/// Returns `next`, reduced towards `counts` so that the total stays within [`MAX_TOTAL_RAYS`].
fn limit_total(mut next: Vec<u32>, counts: &[u32]) -> Vec<u32> {
    let all: u64 = next.iter().map(|n| 2 * u64::from(*n)).sum();
    if all > MAX_TOTAL_RAYS {
        let share = MAX_TOTAL_RAYS as f64 / all as f64;
        for (next, n) in next.iter_mut().zip(counts) {
            *next = ((f64::from(*next) * share) as u32).max(*n);
        }
    }
    next
}

/// The light of all bounces.
struct RayBounces {
    /// Unshot radiosity of each texel's open part.
    unshot: Vec<Halves>,
    /// H of each texel, the mean over its area and both halves.
    mean: Vec<Vec3A>,
    /// Variance of that mean.
    variance: Vec<Vec3A>,
    /// ρ of each texel over the RMS of the reflected light.
    weight: Vec<Vec3A>,
    converged: bool,
}

/// The linear system of a mesh.
struct RaySolver<'a> {
    mesh: &'a Mesh,
    /// Open share of each texel.
    open: Vec<f32>,
    passes: u32,
}

impl RaySolver<'_> {
    /// Returns the first number of rays of each half of each texel, in proportion to the root of its area.
    fn first_counts(&self) -> Vec<u32> {
        let roots = self.mesh.texels.iter().map(|texel| texel.area.sqrt());
        let mean = roots.clone().sum::<f32>() / self.mesh.texels.len().max(1) as f32;
        let count = |root: f32| (FIRST_RAY_COUNT * root / mean).clamp(MIN_RAY_COUNT, MAX_RAY_COUNT) as u32;
        roots.map(count).collect()
    }

    /// Iterates H = D + FρH until the unshot power with all its bounces is [`UNSHOT_SHARE`] of the first. No row of F
    /// sums to more than 1, so nothing gains.
    fn iterate_bounces(
        &mut self,
        traced: &TexelRays,
        watch: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<RayBounces> {
        let texels = &self.mesh.texels;
        // Reflectance of the open part for H of the whole area.
        let of_open = |(texel, open): (&Texel, &f32)| match *open > 0.0 {
            true => Vec3A::from(texel.reflectance / *open),
            false => Vec3A::ZERO,
        };
        let reflectance: Vec<Vec3A> = texels.iter().zip(&self.open).map(of_open).collect();
        let power = |unshot: &[Halves]| -> f64 {
            let parts = unshot.iter().zip(texels).zip(&self.open);
            let part = |(([a, b], texel), open): ((&Halves, &Texel), &f32)| {
                f64::from(((*a + *b) * (texel.area * *open)).max_element())
            };
            parts.map(part).sum()
        };
        let outside = |(direct, texel): (Halves, &Texel)| direct.map(|h| h + Vec3A::from(texel.sky));
        let mut received: Vec<Halves> = traced.direct_light().into_iter().zip(texels).map(outside).collect();
        let reflect = |(h, rho): (&Halves, &Vec3A)| h.map(|h| h * *rho);
        let mut unshot: Vec<Halves> = received.iter().zip(&reflectance).map(reflect).collect();
        let first = power(&unshot);
        let (mut now, mut ratio, mut bounces) = (first, 0.0, 0);
        while now > UNSHOT_SHARE * first * (1.0 - ratio) && bounces < MAX_BOUNCES {
            if watch().is_break() {
                return Err(Error::Interrupted);
            }
            let step = traced.gather_radiosity(&unshot);
            for (received, step) in received.iter_mut().zip(&step) {
                for (received, step) in received.iter_mut().zip(step) {
                    *received += *step;
                }
            }
            unshot = step.iter().zip(&reflectance).map(reflect).collect();
            let next = power(&unshot);
            ratio = (next / now).min(0.999);
            now = next;
            bounces += 1;
        }
        self.passes += bounces;
        let mean: Vec<Vec3A> = received.iter().map(|[a, b]| 0.5 * (*a + *b)).collect();
        Ok(RayBounces {
            variance: received.iter().map(|[a, b]| 0.25 * (*a - *b) * (*a - *b)).collect(),
            weight: self.reflection_weights(&mean),
            mean,
            unshot,
            converged: bounces < MAX_BOUNCES,
        })
    }

    /// Returns ρ of each texel over the RMS of the light reflected of `received`.
    fn reflection_weights(&self, received: &[Vec3A]) -> Vec<Vec3A> {
        let (mut square, mut area) = (DVec3::ZERO, 0.0);
        for (texel, h) in self.mesh.texels.iter().zip(received) {
            let reflected = (texel.reflectance * Vec3::from(*h)).as_dvec3();
            square += reflected * reflected * f64::from(texel.area);
            area += f64::from(texel.area);
        }
        let inverse = |square: f64| if square > 0.0 { (area / square).sqrt() } else { 0.0 };
        let scale = square.map(inverse).as_vec3();
        let texels = self.mesh.texels.iter();
        texels.map(|texel| Vec3A::from(texel.reflectance * scale)).collect()
    }

    /// Returns the RMS noise of the reflected light relative to it, in the worst channel.
    fn relative_noise(&self, bounces: &RayBounces) -> f32 {
        let (mut sum, mut area) = (DVec3::ZERO, 0.0);
        let parts = bounces.weight.iter().zip(&bounces.variance);
        for (texel, (weight, variance)) in self.mesh.texels.iter().zip(parts) {
            sum += Vec3::from(*weight * *weight * *variance).as_dvec3() * f64::from(texel.area);
            area += f64::from(texel.area);
        }
        (sum / area.max(f64::MIN_POSITIVE)).max_element().sqrt() as f32
    }

    /// Returns the number of rays of each half of each texel, in all `growth` times as many for the same variance, with
    /// most where they reduce it most: n ~ √A ρσ, where σ² is the variance of what the rays bring. No texel loses rays.
    fn distribute_rays(&self, traced: &TexelRays, counts: &[u32], bounces: &RayBounces, growth: f32) -> Vec<u32> {
        let reflected = bounces.mean.iter().zip(&self.mesh.texels).zip(&self.open);
        let radiosity = reflected.map(|((h, texel), open)| match *open > 0.0 {
            true => Vec3A::from(texel.reflectance) * *h / *open,
            false => Vec3A::ZERO,
        });
        let radiosity: Vec<Vec3A> = radiosity.collect();
        let variances = traced.ray_variances(&radiosity);
        let spread = self.mesh.texels.iter().zip(variances.iter().zip(&bounces.weight));
        let spread = spread.map(|(texel, (variance, weight))| {
            let variance = (*variance * *weight * *weight).element_sum();
            f64::from((variance * texel.area).sqrt())
        });
        let spread: Vec<f64> = spread.collect();
        let now: f64 = spread.iter().zip(counts).map(|(s, n)| s * s / f64::from(*n)).sum();
        // With n = c·s, Σ s²/n is Σ s/c.
        let per_spread = f64::from(growth) * spread.iter().sum::<f64>() / now.max(f64::MIN_POSITIVE);
        let count = |(s, n): (&f64, &u32)| {
            let most = (*n as f32 * MAX_RAY_GROWTH).min(MAX_RAY_COUNT);
            ((per_spread * s).ceil() as f32).clamp(*n as f32, most) as u32
        };
        spread.iter().zip(counts).map(count).collect()
    }

    /// Makes the solution from the light of `bounces` over `links` rays.
    fn finish(self, bounces: &RayBounces, links: u64) -> HierarchicalSolution {
        let to_vec3 = |values: &[Vec3A]| values.iter().map(|v| Vec3::from(*v)).collect();
        let unshot = bounces.unshot.iter().zip(&self.open);
        HierarchicalSolution {
            irradiance: to_vec3(&bounces.mean),
            residual: unshot
                .map(|([a, b], open)| Vec3::from(0.5 * (*a + *b)) * *open)
                .collect(),
            variance: to_vec3(&bounces.variance),
            coarse_error: vec![0.0; self.open.len()],
            open: self.open,
            links,
            passes: self.passes,
            converged: bounces.converged,
        }
    }
}
