//! Radiosity by rays, for scenes of many small faces: each texel's rays are traced once, and the texels that they meet
//! are kept. A form factor is the share of the rays that meet a texel.
//!
//! ```text
//! H = o(D + F ρH/o)      F_kj = rays of texel k that meet texel j, over all rays of k
//! ```
//! o is the open share of a texel: the rest lies under bodies. Rays start on the open part.
//! D, the light of the lamps and from outside, is estimated by the same rays and as many to points of lamps (`texel_rays`,
//! `lamp_tree`, `sky_light`). The rays of a texel are two halves with sequences of their own. The system is solved for
//! each half; the answer is the mean of the two, and its noise half of their difference. Rays are added where they reduce
//! the noise most, until it is as small as requested.

mod lamp_tree;
mod pair_rays;
pub mod relight;
pub mod residual;
mod seen_lamp;
mod sky_light;
mod texel_rays;

use crate::dense::open_points::OpenParts;
use crate::hierarchy::solver::TexelSolution;
use common::mesh::{Mesh, Texel};
use common::passes::ProgressCallback;
use common::rays::Rays;
use common::scene::Scene;
use common::{Error, Result};
use glam::{DVec3, Vec3, Vec3A};
use sky_light::SkyLight;
use std::ops::ControlFlow;
use texel_rays::{Halves, TexelRays};

/// Least number of rays of each half of a texel.
const MIN_RAY_COUNT: f32 = 2.0;
/// Largest number of rays of each half of a texel, as far as the Sobol sequence goes.
const MAX_RAY_COUNT: f32 = 65_535.0;
/// Largest number of bytes in which the rays of both halves are kept.
const MAX_RAY_BYTES: u64 = 1 << 29;
/// Largest growth of a texel's number of rays in one round.
const MAX_RAY_GROWTH: f32 = 16.0;
/// Growth above which rays are distributed anew, and those traced so far discarded.
const MIN_DISCARD_GROWTH: f32 = 3.0;
/// The noise variance of n stratified rays falls as n to minus this power.
const VARIANCE_EXPONENT: f32 = 1.25;
/// Noise that the first rays leave as a rule, for the progress that is reported.
const FIRST_NOISE: f32 = 0.3;
/// Share of a round's work that later rounds take as a rule, and share of a round that is its bounces.
const LATER_ROUNDS: f64 = 0.1;
/// See [`LATER_ROUNDS`].
const BOUNCE_SHARE: f64 = 0.15;
/// Rounds of tracing.
pub const MAX_TRACING_ROUNDS: u32 = 16;
/// The iteration ends when this share of the first power is unshot.
const UNSHOT_SHARE: f64 = 1e-5;
/// Largest number of bounces.
pub const MAX_BOUNCES: u32 = 2000;

/// Solves `scene` on the texels of `mesh` to an RMS `noise` relative to the reflected light, and sets their light from
/// outside.
///
/// Errors: [`Error::Interrupted`]; those of the sky.
pub fn solve_by_rays(scene: &Scene, mesh: &mut Mesh, noise: f32, watch: ProgressCallback) -> Result<TexelSolution> {
    let (solution, outside) = {
        let rays = Rays::new(mesh);
        let open = OpenParts::new(scene, mesh, &rays);
        let mut traced = TexelRays::new(mesh, &rays, &open, SkyLight::new(scene, mesh, &rays)?);
        let solution = RaySolver::new(mesh, &open.shares).solve_to_noise(&mut traced, noise, watch)?;
        (solution, traced.outside_light())
    };
    for (texel, outside) in mesh.texels.iter_mut().zip(outside) {
        texel.sky = outside;
    }
    Ok(solution)
}

/// Solves for the emission of the texels of `mesh` alone, with its first `bounces` reflections, to an RMS `noise` relative
/// to the reflected light. Solves from different `sequence`s of random numbers have independent noise; that of
/// [`solve_by_rays`] is 0, and a solve uses at most [`MAX_TRACING_ROUNDS`] numbers.
///
/// Errors: [`Error::Interrupted`].
pub fn solve_emission_by_rays(
    scene: &Scene,
    mesh: &Mesh,
    bounces: u32,
    sequence: u32,
    noise: f32,
    watch: ProgressCallback,
) -> Result<TexelSolution> {
    let rays = Rays::new(mesh);
    let open = OpenParts::new(scene, mesh, &rays);
    solve_emission(mesh, (&rays, &open), (bounces, sequence), noise, watch)
}

/// Does the same with the `rays` and open parts of a mesh of the same faces and texels.
fn solve_emission(
    mesh: &Mesh,
    (rays, open): (&Rays, &OpenParts),
    (bounces, sequence): (u32, u32),
    noise: f32,
    watch: ProgressCallback,
) -> Result<TexelSolution> {
    let mut traced = TexelRays::new(mesh, rays, open, None).with_sequence(sequence);
    let solver = RaySolver {
        max_bounces: bounces,
        ..RaySolver::new(mesh, &open.shares)
    };
    solver.solve_to_noise(&mut traced, noise, watch)
}

/// The rays of all texels, traced once and kept.
trait KeptRays: Sync {
    /// Bytes in which a ray is kept.
    const BYTES_PER_RAY: u64;
    /// Mean number of rays of each half with which a solve begins.
    const FIRST_RAY_COUNT: f32;
    /// The first rays only show where later ones are drawn to.
    const LEARNS: bool;

    /// Discards all rays, so that their numbers and directions may follow from what they brought: kept, they would be many
    /// where they happened to bring much, and the light would come out too dark. `radiosity` is what they found.
    fn discard_rays(&mut self, radiosity: &[Vec3A]);

    /// Traces until texel k has `counts[k]` rays of each half.
    ///
    /// Errors: [`Error::Interrupted`].
    fn trace_rays(&mut self, counts: &[u32], watch: &mut dyn FnMut(f64) -> ControlFlow<()>) -> Result<()>;

    /// Returns the light at each texel that is not reflected by the system that is solved, of each half.
    fn direct_light(&self) -> Vec<Halves>;

    /// Returns F times a radiosity, for each half.
    fn gather_radiosity(&self, radiosity: &[Halves]) -> Vec<Halves>;

    /// Returns the variance of what a ray of each texel brings, by channel.
    fn ray_variances(&self, radiosity: &[Vec3A]) -> Vec<Vec3A>;
}

/// Returns the number of rays of the second of two meshes of these many `texels` that has 1/`ratio` of the noise of `rays` of
/// the first.
pub fn grown_rays(rays: u64, texels: [u64; 2], ratio: f32) -> u64 {
    let each = rays as f64 / texels[0].max(1) as f64 * f64::from(growth_for(ratio, 1.0));
    let least = f64::from(2.0 * TexelRays::FIRST_RAY_COUNT);
    ((each.max(least) * texels[1] as f64) as u64).min(MAX_RAY_BYTES / TexelRays::BYTES_PER_RAY)
}

/// Returns the number of rays that are traced for `rays` to be kept: the first ones are discarded where many are added.
pub fn count_traced_rays(rays: u64, texels: u64) -> u64 {
    let first = (2.0 * TexelRays::FIRST_RAY_COUNT) as u64 * texels;
    let discarded = rays as f64 > f64::from(MIN_DISCARD_GROWTH) * first as f64;
    if discarded { rays + first } else { rays }
}

/// Returns the factor by which rays of this noise are to grow in number for the `wanted` noise.
pub fn growth_for(noise: f32, wanted: f32) -> f32 {
    (noise / wanted).powf(2.0 / VARIANCE_EXPONENT)
}

/// Returns the variance of `count` values from their sum and that of their squares.
fn sample_variance(sum: Vec3A, squares: Vec3A, count: usize) -> Vec3A {
    let share = 1.0 / count.max(1) as f32;
    (squares * share - (sum * share) * (sum * share)).max(Vec3A::ZERO)
}

/// Returns `count` times `growth`, at least one more.
fn grow_count(count: u32, growth: f32) -> u32 {
    (count as f32 * growth)
        .ceil()
        .max(count as f32 + 1.0)
        .min(MAX_RAY_COUNT) as u32
}

/// Returns `next`, reduced towards `counts` so that the total stays within `most`.
fn limit_total(mut next: Vec<u32>, counts: &[u32], most: u64) -> Vec<u32> {
    let all: u64 = next.iter().map(|n| 2 * u64::from(*n)).sum();
    if all > most {
        let share = most as f64 / all as f64;
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
    open: &'a [f32],
    /// H of each texel that is known, the mean over its area, and to which the solve adds; empty if there is none.
    known: &'a [Vec3],
    max_bounces: u32,
    passes: u32,
}

impl<'a> RaySolver<'a> {
    fn new(mesh: &'a Mesh, open: &'a [f32]) -> Self {
        Self {
            mesh,
            open,
            known: &[],
            max_bounces: MAX_BOUNCES,
            passes: 0,
        }
    }

    /// Traces rays until the noise is at most `noise`, relative to the RMS of the reflected light.
    ///
    /// Errors: [`Error::Interrupted`].
    fn solve_to_noise<R: KeptRays>(
        mut self,
        traced: &mut R,
        noise: f32,
        watch: ProgressCallback,
    ) -> Result<TexelSolution> {
        let mut counts = self.first_counts(R::FIRST_RAY_COUNT);
        let mut last = false;
        // Progress before the round, and work of later rounds over that of this one.
        let (mut before, mut later) = (0.0, f64::from(growth_for(FIRST_NOISE, noise)));
        for round in 0.. {
            let span = (1.0 - before) / (1.0 + later);
            let end = before + span;
            traced.trace_rays(&counts, &mut |done| {
                watch(end - span * (1.0 - done * (1.0 - BOUNCE_SHARE)))
            })?;
            let bounces = self.iterate_bounces(traced, &mut |done| watch(end - span * BOUNCE_SHARE * (1.0 - done)))?;
            (before, later) = (end, LATER_ROUNDS);
            let found = self.relative_noise(&bounces);
            let total: u64 = counts.iter().map(|n| 2 * u64::from(*n)).sum();
            let learns = R::LEARNS && round == 0;
            last |= !learns && found <= noise || round + 1 >= MAX_TRACING_ROUNDS;
            if !last {
                let growth = growth_for(found, noise).min(MAX_RAY_GROWTH);
                let radiosity = self.reflected_radiosity(&bounces);
                let next = match growth > MIN_DISCARD_GROWTH {
                    _ if learns => counts.clone(),
                    true => self.distribute_rays(traced, &counts, &bounces, &radiosity, growth),
                    false => counts.iter().map(|n| grow_count(*n, growth)).collect(),
                };
                let next = limit_total(next, &counts, MAX_RAY_BYTES / R::BYTES_PER_RAY);
                last = !learns && next == counts;
                if learns || growth > MIN_DISCARD_GROWTH && !last {
                    traced.discard_rays(&radiosity);
                }
                counts = next;
            }
            if last {
                return Ok(self.finish(&bounces, total));
            }
        }
        Err(Error::Interrupted)
    }

    /// Returns the first number of rays of each half of each texel: `first` in the mean, in proportion to the root of its
    /// area.
    fn first_counts(&self, first: f32) -> Vec<u32> {
        let roots = self.mesh.texels.iter().map(|texel| texel.area.sqrt());
        let mean = roots.clone().sum::<f32>() / self.mesh.texels.len().max(1) as f32;
        let count = |root: f32| (first * root / mean).clamp(MIN_RAY_COUNT, MAX_RAY_COUNT) as u32;
        roots.map(count).collect()
    }

    /// Iterates H = D + FρH until the unshot power with all its bounces is [`UNSHOT_SHARE`] of the first. No row of ρF
    /// gains.
    fn iterate_bounces<R: KeptRays>(
        &mut self,
        traced: &R,
        watch: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<RayBounces> {
        let texels = &self.mesh.texels;
        // Reflectance of the open part for H of the whole area.
        let of_open = |(texel, open): (&Texel, &f32)| match *open > 0.0 {
            true => Vec3A::from(texel.reflectance / *open),
            false => Vec3A::ZERO,
        };
        let reflectance: Vec<Vec3A> = texels.iter().zip(self.open).map(of_open).collect();
        let power = |unshot: &[Halves]| -> f64 {
            let parts = unshot.iter().zip(texels).zip(self.open);
            let part = |(([a, b], texel), open): ((&Halves, &Texel), &f32)| {
                f64::from(((*a + *b).abs() * (texel.area * *open)).max_element())
            };
            parts.map(part).sum()
        };
        let mut received = traced.direct_light();
        let reflect = |(h, rho): (&Halves, &Vec3A)| h.map(|h| h * *rho);
        let mut unshot: Vec<Halves> = received.iter().zip(&reflectance).map(reflect).collect();
        let first = power(&unshot);
        let (mut now, mut ratio, mut bounces) = (first, 0.0, 0);
        while now > UNSHOT_SHARE * first * (1.0 - ratio) && bounces < self.max_bounces {
            // The unshot power falls by a factor from bounce to bounce.
            if watch(((now / first).ln() / UNSHOT_SHARE.ln()).min(1.0)).is_break() {
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
            converged: bounces < self.max_bounces,
        })
    }

    /// Returns ρ of each texel over the RMS of the light reflected of `received` and what is known.
    fn reflection_weights(&self, received: &[Vec3A]) -> Vec<Vec3A> {
        let (mut square, mut area) = (DVec3::ZERO, 0.0);
        for (k, (texel, h)) in self.mesh.texels.iter().zip(received).enumerate() {
            let known = self.known.get(k).copied().unwrap_or_default();
            let reflected = (texel.reflectance * (known + Vec3::from(*h))).as_dvec3();
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

    /// Returns the radiosity of each texel's open part that is reflected of the light of `bounces`.
    fn reflected_radiosity(&self, bounces: &RayBounces) -> Vec<Vec3A> {
        let reflected = bounces.mean.iter().zip(&self.mesh.texels).zip(self.open);
        let radiosity = reflected.map(|((h, texel), open)| match *open > 0.0 {
            true => Vec3A::from(texel.reflectance) * *h / *open,
            false => Vec3A::ZERO,
        });
        radiosity.collect()
    }

    /// Returns the number of rays of each half of each texel, in all `growth` times as many for the same variance, with
    /// most where they reduce it most: n ~ √A ρσ, where σ² is the variance of what the rays bring. No texel loses rays.
    fn distribute_rays<R: KeptRays>(
        &self,
        traced: &R,
        counts: &[u32],
        bounces: &RayBounces,
        radiosity: &[Vec3A],
        growth: f32,
    ) -> Vec<u32> {
        let variances = traced.ray_variances(radiosity);
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
    fn finish(self, bounces: &RayBounces, links: u64) -> TexelSolution {
        let to_vec3 = |values: &[Vec3A]| values.iter().map(|v| Vec3::from(*v)).collect();
        let unshot = bounces.unshot.iter().zip(self.open);
        TexelSolution {
            irradiance: to_vec3(&bounces.mean),
            residual: unshot
                .map(|([a, b], open)| Vec3::from(0.5 * (*a + *b)) * *open)
                .collect(),
            variance: to_vec3(&bounces.variance),
            coarse_error: vec![0.0; self.open.len()],
            open: self.open.to_vec(),
            links,
            passes: self.passes,
            converged: bounces.converged,
        }
    }
}
