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
mod merged_texels;
mod pair_rays;
pub mod relight;
pub mod residual;
mod seen_lamp;
mod sky_light;
mod smooth_light;
mod surface_fits;
mod texel_blocks;
mod texel_rays;

use crate::dense::open_points::OpenParts;
use crate::hierarchy::solver::TexelSolution;
use common::mesh::{Mesh, Texel};
use common::passes::ProgressCallback;
use common::rays::Rays;
use common::scene::Scene;
use common::{Error, Result};
use glam::{DVec3, Vec3, Vec3A};
use merged_texels::MergedTexels;
use sky_light::SkyLight;
use smooth_light::PART_COUNT;
use std::ops::ControlFlow;
pub use surface_fits::{fit_slopes, measure_fit_residuals};
use texel_blocks::TexelBlocks;
use texel_rays::TexelRays;

/// A value for each half of the rays.
pub type Halves = [Vec3A; 2];

/// Least number of rays of each half of a texel: one of each part. All numbers are multiples of it.
const MIN_RAY_COUNT: u32 = PART_COUNT as u32;
/// Larger numbers than two of these are multiples of it, so that lamps have their share of the rays whatever these are.
const STRATIFIED_RAY_COUNT: u32 = 32;
/// Largest number of rays of each half of a texel, as far as the Sobol sequence goes.
const MAX_RAY_COUNT: u32 = 65_536 - STRATIFIED_RAY_COUNT;
/// Largest number of bytes in which the rays of both halves are kept.
const MAX_RAY_BYTES: u64 = 1 << 29;
/// Largest growth of a texel's number of rays in one round.
const MAX_RAY_GROWTH: f32 = 16.0;
/// Least growth, since each round iterates all bounces anew.
const MIN_RAY_GROWTH: f32 = 1.1;
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
/// Largest number of rounds of tracing of a solve.
pub const MAX_TRACING_ROUNDS: u32 = 64;
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
        let mut solve = RaySolve::new(scene, mesh, &rays, &open)?;
        (solve.solve_to_noise(noise, watch)?, solve.outside_light())
    };
    for (texel, outside) in mesh.texels.iter_mut().zip(outside) {
        texel.sky = outside;
    }
    Ok(solution)
}

/// Change of the light if texels are merged when they send light.
pub struct MergedChange {
    /// Change of ρH of each texel, for each half of the rays.
    pub reflected: Vec<Halves>,
    /// Radiosity of the merged texels less each texel's own.
    pub sent: Vec<Halves>,
}

/// The light of a solve in two parts: H of each texel, the mean over its area, for each half of the rays.
#[derive(Default)]
pub struct DividedLight {
    /// From lamps and from outside.
    pub direct: Vec<Halves>,
    /// From other texels.
    pub reflected: Vec<Halves>,
    /// What smoothing removed from the direct light.
    pub removed_direct: Vec<Halves>,
    /// What smoothing removed from the reflected light.
    pub removed_reflected: Vec<Halves>,
}

/// A solve of a scene by rays, which it keeps from one noise to a lower one.
pub struct RaySolve<'a> {
    solver: RaySolver<'a>,
    traced: TexelRays<'a>,
}

impl<'a> RaySolve<'a> {
    /// Makes a solve of `scene` on the texels of `mesh` with their `open` parts.
    ///
    /// Errors: those of the sky.
    pub fn new(scene: &Scene, mesh: &'a Mesh, rays: &'a Rays, open: &'a OpenParts) -> Result<Self> {
        Ok(Self {
            solver: RaySolver::new(mesh, &open.shares),
            traced: TexelRays::new(mesh, rays, open, SkyLight::new(scene, mesh, rays)?),
        })
    }

    /// Gathers only light from lamps and from outside, beside other light that is known: H of each texel, the mean over its
    /// area.
    pub fn beside_light(mut self, other: Vec<Vec3A>) -> Self {
        self.solver.other = other;
        self.traced = self.traced.for_lamps_alone();
        self
    }

    /// Returns the light of the last solve in its parts.
    pub fn divided_light(&self) -> DividedLight {
        let last = self.solver.last.as_ref();
        last.map_or(DividedLight::default(), |bounces| self.solver.divide_light(bounces))
    }

    /// Smooths the light of later solves where that makes its error smaller.
    pub fn smooth_light(&mut self) {
        self.traced.smooth_later_light();
    }

    /// Traces rays until the RMS noise is `noise` relative to the reflected light.
    ///
    /// Errors: [`Error::Interrupted`].
    pub fn solve_to_noise(&mut self, noise: f32, watch: ProgressCallback) -> Result<TexelSolution> {
        self.solver.solve_to_noise(&mut self.traced, noise, watch)
    }

    /// Returns the RMS noise of the last solve relative to the reflected light, in the worst channel; 0 before the first.
    pub fn relative_noise(&self) -> f32 {
        let last = self.solver.last.as_ref();
        last.map_or(0.0, |bounces| self.solver.noise_of_bounces(bounces))
    }

    /// Returns the RMS of `noise` in H of each texel, and of what smoothing `removed` from either half, relative to the
    /// reflected light of the last solve, in the worst channel.
    pub fn relate_noise(&self, noise: &[Vec3A], removed: &[Halves]) -> f32 {
        let last = self.solver.last.as_ref();
        last.map_or(0.0, |bounces| {
            self.solver.relative_noise(noise, removed, &bounces.weight)
        })
    }

    /// Returns by how much the light of the last solve changes if the texels are merged two by two when they send light.
    ///
    /// Errors: [`Error::Interrupted`]; [`Error::Fault`] if there was no solve.
    pub fn change_if_merged(&mut self, watch: ProgressCallback) -> Result<MergedChange> {
        let merged = MergedTexels::new(self.solver.mesh, self.solver.open);
        let coarse = self.solver.iterate_bounces(&self.traced, Some(&merged), watch)?;
        let sent = self.solver.radiosity_of_halves(&coarse.received);
        let mut means = sent.clone();
        merged.average_groups(&mut means);
        let Some(fine) = &self.solver.last else {
            return Err(Error::Fault("texels were merged before rays were traced".into()));
        };
        let received = coarse.received.iter().zip(&fine.received);
        let reflected = self
            .solver
            .mesh
            .texels
            .iter()
            .zip(received)
            .map(|(texel, (coarse, fine))| {
                let rho = Vec3A::from(texel.reflectance);
                [0, 1].map(|half| rho * (coarse[half] - fine[half]))
            });
        Ok(MergedChange {
            reflected: reflected.collect(),
            sent: means
                .iter()
                .zip(&sent)
                .map(|([a, b], [c, d])| [*a - *c, *b - *d])
                .collect(),
        })
    }

    /// Returns the share of each face in a change: what its light `sent` adds at each texel times that texel's `weight`, with
    /// the halves crossed, so that their noise does not multiply.
    pub fn attribute_change(&self, sent: &[Halves], weights: &[Halves]) -> Vec<f64> {
        let mut shares = vec![0.0; self.solver.mesh.faces.len()];
        self.traced.visit_hits(|texel, half, hit, share| {
            let share = f64::from((weights[texel][1 - half] * sent[hit][half]).element_sum() * share);
            shares[self.solver.mesh.texels[hit].face as usize] += share;
        });
        shares
    }

    /// Returns the light from outside at each texel.
    pub fn outside_light(&self) -> Vec<Vec3> {
        self.traced.outside_light()
    }
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
    let mut solver = RaySolver {
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

    /// Traces until texel k, or block k of texels, has `counts[k]` rays of each half.
    ///
    /// Errors: [`Error::Interrupted`].
    fn trace_rays(&mut self, counts: &[u32], watch: &mut dyn FnMut(f64) -> ControlFlow<()>) -> Result<()>;

    /// Returns the light at each texel that is not reflected by the system that is solved, of each half.
    fn direct_light(&self) -> Vec<Halves>;

    /// Returns F times a radiosity, for each half.
    fn gather_radiosity(&self, radiosity: &[Halves]) -> Vec<Halves>;

    /// Returns the light of each texel, that of the lamps and that of a radiosity, smoothed over clusters of texels; none if
    /// these rays are not to be smoothed. The error of each texel counts by its weight.
    fn smooth_light(&self, radiosity: &[Halves], weight: &[Vec3A]) -> Option<[Vec<Halves>; 2]>;

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

/// Returns the least number of rays from `count` that there may be.
fn round_count(count: f32) -> u32 {
    let step = match count > 2.0 * STRATIFIED_RAY_COUNT as f32 {
        true => STRATIFIED_RAY_COUNT,
        false => MIN_RAY_COUNT,
    };
    let steps = (count / step as f32).ceil() as u32;
    steps.saturating_mul(step).clamp(MIN_RAY_COUNT, MAX_RAY_COUNT)
}

/// Returns `count` times `growth`, at least one more of each part.
fn grow_count(count: u32, growth: f32) -> u32 {
    round_count((count as f32 * growth).max((count + MIN_RAY_COUNT) as f32))
}

/// Returns `next`, reduced towards `counts` so that the total stays within `most`.
fn limit_total(mut next: Vec<u32>, counts: &[u32], most: u64) -> Vec<u32> {
    let all: u64 = next.iter().map(|n| 2 * u64::from(*n)).sum();
    if all > most {
        let share = most as f64 / all as f64;
        for (next, n) in next.iter_mut().zip(counts) {
            let reduced = (f64::from(*next) * share) as u32;
            *next = (reduced - reduced % MIN_RAY_COUNT).max(*n);
        }
    }
    next
}

fn half_differences(light: &[Halves]) -> Vec<Vec3A> {
    light.iter().map(|[a, b]| 0.5 * (*a - *b)).collect()
}

/// Returns a light plus `sign` times another.
fn combine_light(a: &[Halves], b: &[Halves], sign: f32) -> Vec<Halves> {
    let combine = |(a, b): (&Halves, &Halves)| [0, 1].map(|half| a[half] + sign * b[half]);
    a.iter().zip(b).map(combine).collect()
}

/// The light of all bounces.
struct RayBounces {
    /// Unshot radiosity of each texel's open part.
    unshot: Vec<Halves>,
    /// H of each texel, the mean over its area, of each half.
    received: Vec<Halves>,
    /// The part of it that is not reflected.
    direct: Vec<Halves>,
    /// Both parts smoothed, if the solve smooths light.
    smoothed: Option<[Vec<Halves>; 2]>,
    /// Mean of both halves, smoothed if the solve smooths light.
    mean: Vec<Vec3A>,
    /// Half of their difference.
    noise: Vec<Vec3A>,
    /// What smoothing removed from each half; empty without it.
    removed: Vec<Halves>,
    /// ρ of each texel over the RMS of the reflected light.
    weight: Vec<Vec3A>,
    converged: bool,
}

impl RayBounces {
    /// Replaces mean and noise by those of light whose parts are `smoothed`.
    fn replace_light(&mut self, smoothed: [Vec<Halves>; 2]) {
        let all = combine_light(&smoothed[0], &smoothed[1], 1.0);
        self.mean = all.iter().map(|[a, b]| 0.5 * (*a + *b)).collect();
        self.noise = half_differences(&all);
        self.removed = combine_light(&self.received, &all, -1.0);
        self.smoothed = Some(smoothed);
    }
}

/// Sums over texels' areas of the light that they reflect, each weighted by its share.
#[derive(Clone, Copy, Default)]
struct ReflectedSums {
    light_squares: DVec3,
    shares: DVec3,
    share_squares: DVec3,
}

impl ReflectedSums {
    fn add_texel(&mut self, reflected: Vec3, share: Vec3, area: f32) {
        let (reflected, share) = (reflected.as_dvec3(), share.as_dvec3());
        let area = f64::from(area);
        self.light_squares += reflected * reflected * share * area;
        self.shares += share * area;
        self.share_squares += share * share * area;
    }

    /// Returns 1 over the RMS light, times the root of `area` over that on which the shares are: the square of the sum of
    /// shares over that of their squares.
    fn scale_to(&self, area: f64) -> Vec3 {
        let square = self.light_squares * self.shares;
        let inverse = |c: usize| match square[c] > 0.0 {
            true => (area * self.share_squares[c] / square[c]).sqrt(),
            false => 0.0,
        };
        DVec3::new(inverse(0), inverse(1), inverse(2)).as_vec3()
    }
}

/// The linear system of a mesh.
struct RaySolver<'a> {
    mesh: &'a Mesh,
    /// Open share of each texel.
    open: &'a [f32],
    /// H of each texel that is known, the mean over its area, and to which the solve adds; empty if there is none.
    known: &'a [Vec3],
    /// H of each texel beside that of lamps and from outside, if it is known; empty if it is to be found.
    other: Vec<Vec3A>,
    /// Blocks of texels that receive by the same rays; without them each texel has rays of its own.
    blocks: Option<&'a TexelBlocks>,
    max_bounces: u32,
    passes: u32,
    /// Rays of each half of each texel, or of each block; none before the first are traced.
    counts: Vec<u32>,
    /// Rounds of tracing so far.
    rounds: u32,
    /// The light of the rays so far.
    last: Option<RayBounces>,
}

impl<'a> RaySolver<'a> {
    fn new(mesh: &'a Mesh, open: &'a [f32]) -> Self {
        Self {
            mesh,
            open,
            known: &[],
            other: Vec::new(),
            blocks: None,
            max_bounces: MAX_BOUNCES,
            passes: 0,
            counts: Vec::new(),
            rounds: 0,
            last: None,
        }
    }

    /// Traces rays until the noise is at most `noise`, relative to the RMS of the reflected light. Rays of an earlier call
    /// are kept.
    ///
    /// Errors: [`Error::Interrupted`].
    fn solve_to_noise<R: KeptRays>(
        &mut self,
        traced: &mut R,
        noise: f32,
        watch: ProgressCallback,
    ) -> Result<TexelSolution> {
        if self.counts.is_empty() {
            self.counts = self.first_counts(R::FIRST_RAY_COUNT);
        }
        // Progress before the round, and work of later rounds over that of this one.
        let (mut before, mut later) = (0.0, f64::from(growth_for(FIRST_NOISE, noise)));
        loop {
            let mut bounces = match self.last.take() {
                Some(known) => known,
                None => {
                    let span = (1.0 - before) / (1.0 + later);
                    let end = before + span;
                    traced.trace_rays(&self.counts, &mut |done| {
                        watch(end - span * (1.0 - done * (1.0 - BOUNCE_SHARE)))
                    })?;
                    (before, later) = (end, LATER_ROUNDS);
                    self.rounds += 1;
                    let mut watch = |done| watch(end - span * BOUNCE_SHARE * (1.0 - done));
                    self.iterate_bounces(traced, None, &mut watch)?
                }
            };
            let radiosity = match self.other.is_empty() {
                true => self.radiosity_of_halves(&bounces.received),
                false => Vec::new(),
            };
            if let Some([direct, reflected]) = traced.smooth_light(&radiosity, &bounces.weight) {
                let known = self.other.iter().map(|light| [*light; 2]);
                let reflected = if self.other.is_empty() {
                    reflected
                } else {
                    known.collect()
                };
                bounces.replace_light([direct, reflected]);
            }
            let found = self.noise_of_bounces(&bounces);
            let learns = R::LEARNS && self.rounds == 1;
            let mut last = !learns && found <= noise || self.rounds >= MAX_TRACING_ROUNDS;
            if !last {
                let growth = growth_for(found, noise).clamp(MIN_RAY_GROWTH, MAX_RAY_GROWTH);
                let radiosity = match self.other.is_empty() {
                    true => self.reflected_radiosity(&bounces),
                    false => Vec::new(),
                };
                let next = match learns || growth > MIN_DISCARD_GROWTH {
                    true => self.distribute_rays(traced, &bounces, &radiosity, growth),
                    false => self.counts.iter().map(|n| grow_count(*n, growth)).collect(),
                };
                let next = limit_total(next, &self.counts, MAX_RAY_BYTES / R::BYTES_PER_RAY);
                last = !learns && next == self.counts;
                if learns || growth > MIN_DISCARD_GROWTH && !last {
                    traced.discard_rays(&radiosity);
                }
                self.counts = next;
            }
            if last {
                let solution = self.make_solution(&bounces);
                self.last = Some(bounces);
                return Ok(solution);
            }
        }
    }

    /// Returns the sum of the `values` of the texels of each block; without blocks the values.
    fn sum_blocks(&self, values: impl Iterator<Item = f64>) -> Vec<f64> {
        match self.blocks {
            Some(blocks) => blocks.sum_blocks(values),
            None => values.collect(),
        }
    }

    /// Returns the first number of rays of each half of each texel or block: `first` in the mean, in proportion to the root of
    /// its area.
    fn first_counts(&self, first: f32) -> Vec<u32> {
        let areas = self.sum_blocks(self.mesh.texels.iter().map(|texel| f64::from(texel.area)));
        let roots = areas.iter().map(|area| area.sqrt() as f32);
        let mean = roots.clone().sum::<f32>() / areas.len().max(1) as f32;
        let count = |root: f32| round_count(first * root / mean);
        roots.map(count).collect()
    }

    /// Iterates H = D + FρH until the unshot power with all its bounces is [`UNSHOT_SHARE`] of the first. No row of ρF
    /// gains. Texels send light as `merged`, if that is given.
    fn iterate_bounces<R: KeptRays>(
        &mut self,
        traced: &R,
        merged: Option<&MergedTexels>,
        watch: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<RayBounces> {
        let texels = &self.mesh.texels;
        let reflectance = self.open_reflectance();
        let power = |unshot: &[Halves]| -> f64 {
            let parts = unshot.iter().zip(texels).zip(self.open);
            let part = |(([a, b], texel), open): ((&Halves, &Texel), &f32)| {
                f64::from(((*a + *b).abs() * (texel.area * *open)).max_element())
            };
            parts.map(part).sum()
        };
        let direct = traced.direct_light();
        if !self.other.is_empty() {
            let known: Vec<Halves> = self.other.iter().map(|light| [*light; 2]).collect();
            let unshot = vec![[Vec3A::ZERO; 2]; direct.len()];
            return Ok(self.make_bounces(combine_light(&direct, &known, 1.0), direct, (unshot, true)));
        }
        let mut received = direct.clone();
        let reflect = |(h, rho): (&Halves, &Vec3A)| h.map(|h| h * *rho);
        let mut unshot: Vec<Halves> = received.iter().zip(&reflectance).map(reflect).collect();
        let first = power(&unshot);
        let (mut now, mut ratio, mut bounces) = (first, 0.0, 0);
        while now > UNSHOT_SHARE * first * (1.0 - ratio) && bounces < self.max_bounces {
            // The unshot power falls by a factor from bounce to bounce.
            if watch(((now / first).ln() / UNSHOT_SHARE.ln()).min(1.0)).is_break() {
                return Err(Error::Interrupted);
            }
            if let Some(merged) = merged {
                merged.average_groups(&mut unshot);
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
        Ok(self.make_bounces(received, direct, (unshot, bounces < self.max_bounces)))
    }

    fn make_bounces(
        &self,
        received: Vec<Halves>,
        direct: Vec<Halves>,
        (unshot, converged): (Vec<Halves>, bool),
    ) -> RayBounces {
        let mean: Vec<Vec3A> = received.iter().map(|[a, b]| 0.5 * (*a + *b)).collect();
        RayBounces {
            noise: half_differences(&received),
            weight: self.reflection_weights(&mean),
            removed: Vec::new(),
            smoothed: None,
            mean,
            direct,
            received,
            unshot,
            converged,
        }
    }

    /// Returns the light of `bounces` in its parts.
    fn divide_light(&self, bounces: &RayBounces) -> DividedLight {
        let found = combine_light(&bounces.received, &bounces.direct, -1.0);
        let [direct, reflected] = match &bounces.smoothed {
            Some(smoothed) => smoothed.clone(),
            None => [bounces.direct.clone(), found.clone()],
        };
        let removed = [(&bounces.direct, &direct), (&found, &reflected)];
        let [removed_direct, removed_reflected] = removed.map(|(found, smooth)| combine_light(found, smooth, -1.0));
        DividedLight {
            direct,
            reflected,
            removed_direct,
            removed_reflected,
        }
    }

    /// Returns the reflectance of each texel's open part for H of its whole area.
    fn open_reflectance(&self) -> Vec<Vec3A> {
        let of_open = |(texel, open): (&Texel, &f32)| match *open > 0.0 {
            true => Vec3A::from(texel.reflectance / *open),
            false => Vec3A::ZERO,
        };
        self.mesh.texels.iter().zip(self.open).map(of_open).collect()
    }

    /// Returns the reflected radiosity of each texel's open part from H of its whole area.
    fn radiosity_of_halves(&self, received: &[Halves]) -> Vec<Halves> {
        let reflect = |(h, rho): (&Halves, Vec3A)| h.map(|h| h * rho);
        received.iter().zip(self.open_reflectance()).map(reflect).collect()
    }

    /// Returns the weight by which [`Self::relative_noise`] takes the light of each texel: ρ over the RMS of the light
    /// reflected of `received` and what is known. In a relight the objects and the room count as much as each other, however
    /// small the objects are, and the noise of the room's change counts over the area that changes.
    fn reflection_weights(&self, received: &[Vec3A]) -> Vec<Vec3A> {
        let group = |texel: &Texel| usize::from(!self.known.is_empty() && self.mesh.is_object(texel.face));
        let mut sums = [ReflectedSums::default(); 2];
        let mut area = 0.0;
        for (k, (texel, h)) in self.mesh.texels.iter().zip(received).enumerate() {
            let change = texel.reflectance * Vec3::from(*h);
            let known = self.known.get(k).map(|known| texel.reflectance * *known);
            let share = match known {
                Some(_) if group(texel) == 0 => change.abs(),
                _ => Vec3::ONE,
            };
            sums[group(texel)].add_texel(known.unwrap_or_default() + change, share, texel.area);
            area += f64::from(texel.area);
        }
        let groups = sums.iter().filter(|sums| sums.shares != DVec3::ZERO).count() as f64;
        let scales = sums.map(|sums| sums.scale_to(area / groups));
        let weight = |texel: &Texel| Vec3A::from(texel.reflectance * scales[group(texel)]);
        self.mesh.texels.iter().map(weight).collect()
    }

    fn noise_of_bounces(&self, bounces: &RayBounces) -> f32 {
        self.relative_noise(&bounces.noise, &bounces.removed, &bounces.weight)
    }

    /// Returns the RMS `noise` of the reflected light, and of the light that smoothing `removed`, relative to it, in the worst
    /// channel.
    fn relative_noise(&self, noise: &[Vec3A], removed: &[Halves], weight: &[Vec3A]) -> f32 {
        let (mut noise_sum, mut removed_sum, mut area) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for (k, texel) in self.mesh.texels.iter().enumerate() {
            let own = f64::from(texel.area);
            let [a, b] = removed.get(k).copied().unwrap_or_default();
            let [n, a, b] = [noise[k], a, b].map(|part| Vec3::from(part * weight[k]).as_dvec3());
            noise_sum += n * n * own;
            removed_sum += a * b * own;
            area += own;
        }
        let square = (noise_sum + removed_sum.max(DVec3::ZERO)) / area.max(f64::MIN_POSITIVE);
        square.max_element().sqrt() as f32
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

    /// Returns the number of rays of each half of each texel or block, in all `growth` times as many for the same variance, with
    /// most where they reduce it most: n ~ √A ρσ, where σ² is the variance of what the rays bring. No texel loses rays.
    fn distribute_rays<R: KeptRays>(
        &self,
        traced: &R,
        bounces: &RayBounces,
        radiosity: &[Vec3A],
        growth: f32,
    ) -> Vec<u32> {
        let variances = traced.ray_variances(radiosity);
        let spread = self.mesh.texels.iter().zip(variances.iter().zip(&bounces.weight));
        let spread = spread.map(|(texel, (variance, weight))| {
            let variance = (*variance * *weight * *weight).element_sum();
            f64::from(variance * texel.area)
        });
        let spread: Vec<f64> = self.sum_blocks(spread).into_iter().map(f64::sqrt).collect();
        let now: f64 = spread
            .iter()
            .zip(&self.counts)
            .map(|(s, n)| s * s / f64::from(*n))
            .sum();
        // With n = c·s, Σ s²/n is Σ s/c.
        let per_spread = f64::from(growth) * spread.iter().sum::<f64>() / now.max(f64::MIN_POSITIVE);
        let count = |(s, n): (&f64, &u32)| {
            let most = round_count(*n as f32 * MAX_RAY_GROWTH);
            round_count((per_spread * s) as f32).clamp(*n, most)
        };
        spread.iter().zip(&self.counts).map(count).collect()
    }

    /// Returns the number of rays of both halves. Covered texels have none.
    fn count_rays(&self) -> u64 {
        let is_covered = |k: &usize| self.blocks.is_none() && self.open[*k] == 0.0;
        let counted = (0..self.counts.len()).filter(|k| !is_covered(k));
        counted.map(|k| 2 * u64::from(self.counts[k])).sum()
    }

    /// Makes the solution from the light of `bounces`.
    fn make_solution(&self, bounces: &RayBounces) -> TexelSolution {
        let to_vec3 = |values: &[Vec3A]| values.iter().map(|v| Vec3::from(*v)).collect();
        let unshot = bounces.unshot.iter().zip(self.open);
        TexelSolution {
            direct: Vec::new(),
            irradiance: to_vec3(&bounces.mean),
            residual: unshot
                .map(|([a, b], open)| Vec3::from(0.5 * (*a + *b)) * *open)
                .collect(),
            noise: to_vec3(&bounces.noise),
            removed: bounces.removed.iter().map(|halves| halves.map(Vec3::from)).collect(),
            coarse_error: vec![0.0; self.open.len()],
            open: self.open.to_vec(),
            links: self.count_rays(),
            passes: self.passes,
            converged: bounces.converged,
        }
    }
}
