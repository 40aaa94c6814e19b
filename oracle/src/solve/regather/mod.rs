//! A-posteriori error estimate of a shooting solution, by sub-sampled re-gathering. It needs no reference
//! solution and shares nothing with the solver that could hide an error: the solution's own light is gathered
//! again at a random sample of texels by rays alone, without patches, form factors or the mesh's samples.
//!
//! ```text
//! r_j = ρ(H'_j − H_j)      e_j = r_j + x_g(j)      x = ρF(r̄ + x)
//! error² = Σ A e·e' / Σ A l·l'       l = ρH + e
//! ```
//! H is the irradiance that the solution claims, H' the gathered one (`gather`). r is the error of one bounce,
//! including unshot light and variation within the source texels; x is the error of later bounces, from the means
//! of r over groups g of texels (`propagation`). e and e' come from independent rays, and x from independent texels, so
//! the mean of their product is e² without bias. No error below the standard error of that mean is reported.

mod claimed_light;
pub mod estimate;
mod gather;
mod patch_gather;
mod propagation;
mod texel_sample;

use claimed_light::{ClaimedLight, claimed_reflection};
use common::Result;
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::Scene;
use common::settings::{Settings, SolveQuality, Visibility};
use common::shooting::RadiosityField;
use estimate::largest_faces;
pub use estimate::{ErrorCause, ErrorEstimate, ErrorPart, EstimateBasis, FaceError};
use gather::RayGatherer;
use glam::DVec3;
use patch_gather::PatchGatherer;
use propagation::TexelGroups;
use rayon::prelude::*;
use texel_sample::{SampledTexel, sample_texels};

/// Error above which a warning is given.
pub const WARNING_LIMIT: f64 = 0.02;
/// Number of sampled texels, unless they leave undecided on which side of [`WARNING_LIMIT`] the error is.
const SAMPLED_TEXELS: u32 = 1 << 10;
/// Rays of each kind and half, shared by all sampled texels; secondary rays make it five times as many. At
/// reference quality four times as many, because errors are smaller and solves longer.
const RAY_BUDGET: u32 = 1 << 17;
/// Rays per sample: two halves of two kinds, and four secondary rays from each end point.
const RAYS_PER_SAMPLE: u64 = 2 * 2 * 5;
/// Pilot rays of each kind and half per texel, for the allocation of the others.
const PILOT_RAYS: u32 = 16;
/// Budget of rays for the attribution to causes, unless it leaves too few texels.
const ATTRIBUTION_RAYS: u64 = 1 << 20;
/// Smallest and largest number of texels for the attribution to causes.
const ATTRIBUTION_TEXELS: [u64; 2] = [16, 256];
/// Smallest light for relative errors, as a share of the claimed light's square.
const MIN_LIGHT_SHARE: f64 = 1e-4;

/// A texel gathered again.
pub struct RegatheredTexel {
    /// Index of the texel.
    texel: usize,
    /// Face of the texel.
    face: u32,
    /// Area that the texel represents.
    area: f64,
    /// Inclusion probability.
    probability: f64,
    /// ρH that the solution claims.
    claimed: DVec3,
    /// r, twice, from independent rays.
    residuals: [DVec3; 2],
    /// The part of r from variation within source texels.
    within_texels: [DVec3; 2],
    /// The part of r that later bounces propagate.
    propagated: DVec3,
    /// True if a body covers a part of the texel; then its points are gathered again from other texels.
    partly_covered: bool,
    /// Share of the texel's rays that met fronts of each group.
    group_shares: Vec<(usize, f64)>,
}

/// Estimates the error of `field` on `mesh`, the solution of `scene` with `settings`. A few texels suffice if the
/// error is far above [`WARNING_LIMIT`]; else more are sampled, and four times as many with four times the rays
/// while it is undecided on which side of the limit the error is.
///
/// Errors: those of the dense solver for later bounces.
pub fn estimate_by_regathering(
    scene: &Scene,
    settings: &Settings,
    mesh: &Mesh,
    field: &RadiosityField,
) -> Result<ErrorEstimate> {
    let rays = Rays::new(mesh);
    let light = ClaimedLight::new(scene, mesh, field, &rays);
    let gather = RayGatherer {
        mesh,
        light: &light,
        rays: &rays,
    };
    let finer = settings.quality == SolveQuality::Reference;
    let budget = if finer { 4 * RAY_BUDGET } else { RAY_BUDGET };
    let found = estimate_with_budget(scene, settings, &gather, field, [SAMPLED_TEXELS / 4, budget / 4])?;
    if found.lower_bound() > 2.0 * WARNING_LIMIT {
        return Ok(found);
    }
    let found = estimate_with_budget(scene, settings, &gather, field, [SAMPLED_TEXELS, budget])?;
    if found.upper_bound() <= WARNING_LIMIT || found.lower_bound() > WARNING_LIMIT {
        return Ok(found);
    }
    estimate_with_budget(scene, settings, &gather, field, [4 * SAMPLED_TEXELS, 4 * budget])
}

fn estimate_with_budget(
    scene: &Scene,
    settings: &Settings,
    gather: &RayGatherer,
    field: &RadiosityField,
    [count, budget]: [u32; 2],
) -> Result<ErrorEstimate> {
    let mesh = gather.mesh;
    let groups = TexelGroups::new(scene, mesh, count as usize);
    let chosen = sample_texels(mesh, field, u64::from(count));
    let samples = allocate_rays(gather, &chosen, budget);
    let sampled: Vec<RegatheredTexel> = (chosen.into_par_iter().zip(&samples))
        .map(|(chosen, samples)| RegatheredTexel::new(gather, field, &groups, &chosen, *samples))
        .collect();
    let later = groups.later_bounces(&sampled)?;
    let errors: Vec<[DVec3; 2]> = sampled
        .iter()
        .map(|sample| {
            let x = [&later[0], &later[1]].map(|x| x[groups.group_of(sample.texel)]);
            [0, 1].map(|half| sample.residuals[half] + x[half])
        })
        .collect();
    let light = light_squares(&sampled, &errors);
    let total = MeanSquare::from_errors(&sampled, |k| errors[k], light);
    let one = MeanSquare::from_errors(&sampled, |k| sampled[k].residuals, light);
    let x = |k: usize| {
        let sample = &sampled[k];
        [0, 1].map(|half| errors[k][half] - sample.residuals[half])
    };
    let coherent = MeanSquare::from_errors(&sampled, x, light);
    // The common part of x is one draw for all texels, not one per sampled texel.
    let common = weighted_mean(&sampled, |k| x(k)[0] - x(k)[1]).powf(2.0) * represented_area(&sampled);
    let standard_error = total.standard_error + 0.5 * divide_or_zero(common, light);
    let square = total.mean.max(standard_error);
    Ok(ErrorEstimate {
        error: square.max_element().sqrt(),
        upper: (total.mean.max(DVec3::ZERO) + 2.0 * standard_error)
            .max_element()
            .sqrt(),
        evidence: EstimateBasis::Regathered {
            one_bounce: one.mean.max_element().max(0.0).sqrt(),
            later_bounces: coherent.mean.max_element().max(0.0).sqrt(),
            floor: standard_error.max_element().sqrt(),
            rays: samples
                .iter()
                .map(|n| RAYS_PER_SAMPLE * u64::from(*n + PILOT_RAYS))
                .sum(),
            looks: sampled.len(),
        },
        parts: attribute_causes(settings, mesh, field, gather.rays, &sampled, light),
    })
}

/// Allocates the rays to the sampled texels. A texel's part of the mean's variance is (A v/n)², with v the
/// variance of a ray; for a fixed total it is least for n ∝ (A v)^⅔. Half of the rays are allocated so, half
/// equally, because pilot rays may miss light through a narrow opening. Pilot rays are not used again, so that the
/// mean is unbiased.
fn allocate_rays(gather: &RayGatherer, chosen: &[SampledTexel], budget: u32) -> Vec<u32> {
    let pilot = |chosen: &SampledTexel| {
        let reflectance = gather.mesh.texels[chosen.texel].reflectance.as_dvec3();
        let variance = gather.gather_texel(chosen.texel, PILOT_RAYS, 0).variance;
        (chosen.area * variance * reflectance.length_squared()).powf(2.0 / 3.0)
    };
    let weights: Vec<f64> = chosen.par_iter().map(pilot).collect();
    let all = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let alike = 1.0 / weights.len() as f64;
    let share = |weight: &f64| 0.5 * (alike + weight / all);
    let samples = |weight: &f64| (share(weight) * f64::from(budget)) as u32;
    weights.iter().map(|weight| samples(weight).max(1)).collect()
}

impl RegatheredTexel {
    fn new(
        gather: &RayGatherer,
        field: &RadiosityField,
        groups: &TexelGroups,
        &SampledTexel {
            texel,
            area,
            probability: share,
        }: &SampledTexel,
        samples: u32,
    ) -> Self {
        let mesh = gather.mesh;
        let claimed = claimed_reflection(mesh, field, texel);
        let found = gather.gather_texel(texel, samples, 1);
        let reflectance = mesh.texels[texel].reflectance.as_dvec3();
        let ray = 0.5 / f64::from(samples);
        let [a, b] = [0, 1].map(|half| found.irradiance[half] - found.zero_mean[half]);
        let mut met: Vec<(usize, f64)> = Vec::new();
        for texel in found.hit_texels {
            let group = groups.group_of(texel);
            match met.iter_mut().find(|(known, _)| *known == group) {
                Some((_, sum)) => *sum += ray,
                None => met.push((group, ray)),
            }
        }
        Self {
            texel,
            face: mesh.texels[texel].face,
            area,
            probability: share,
            claimed,
            partly_covered: gather.light.is_partly_covered(texel),
            residuals: found.irradiance.map(|h| reflectance * h - claimed),
            within_texels: found.within_texels.map(|h| reflectance * h),
            propagated: 0.5 * reflectance * (a + b) - claimed,
            group_shares: met,
        }
    }
}

/// Σ A l·l', but at least a share of the claimed light's square: a smaller value is noise.
fn light_squares(sampled: &[RegatheredTexel], errors: &[[DVec3; 2]]) -> DVec3 {
    let (mut light, mut claimed) = (DVec3::ZERO, DVec3::ZERO);
    for (sample, e) in sampled.iter().zip(errors) {
        light += sample.area * (sample.claimed + e[0]) * (sample.claimed + e[1]);
        claimed += sample.area * sample.claimed * sample.claimed;
    }
    light.max(MIN_LIGHT_SHARE * claimed)
}

fn represented_area(sampled: &[RegatheredTexel]) -> f64 {
    sampled
        .iter()
        .map(|sample| sample.area)
        .sum::<f64>()
        .max(f64::MIN_POSITIVE)
}

fn weighted_mean(sampled: &[RegatheredTexel], value: impl Fn(usize) -> DVec3) -> DVec3 {
    let parts = sampled.iter().enumerate().map(|(k, sample)| sample.area * value(k));
    parts.sum::<DVec3>() / represented_area(sampled)
}

/// A mean square relative to the light's, and its standard error, for each channel.
struct MeanSquare {
    mean: DVec3,
    standard_error: DVec3,
}

impl MeanSquare {
    /// Computes the mean of e·e', where e and e' are the two halves. Its variance is that of the sampling of texels
    /// and that of their rays:
    ///
    /// ```text
    /// Σ A² ((1 − π)(e·e' − m)² + π(e² − e'²)²/4)
    /// ```
    /// π is the inclusion probability, m the mean (Horvitz & Thompson 1952). The second term is the variance of
    /// e·e' for normal e and e' of equal distribution.
    fn from_errors(sampled: &[RegatheredTexel], errors: impl Fn(usize) -> [DVec3; 2], light: DVec3) -> Self {
        let square = |k: usize| {
            let [a, b] = errors(k);
            a * b
        };
        let mean = weighted_mean(sampled, square);
        let mut variance = DVec3::ZERO;
        for (k, sample) in sampled.iter().enumerate() {
            let [a, b] = errors(k);
            let drawn = (a * b - mean).powf(2.0);
            let rays = 0.25 * (a * a - b * b).powf(2.0);
            variance += sample.area * sample.area * ((1.0 - sample.probability) * drawn + sample.probability * rays);
        }
        Self {
            mean: divide_or_zero(mean * represented_area(sampled), light),
            standard_error: divide_or_zero(variance.map(f64::sqrt), light),
        }
    }
}

/// Returns a/b, with 0/0 = 0.
fn divide_or_zero(a: DVec3, b: DVec3) -> DVec3 {
    let part = |a: f64, b: f64| if a == 0.0 { 0.0 } else { a / b };
    DVec3::new(part(a.x, b.x), part(a.y, b.y), part(a.z, b.z))
}

/// Attributes the error to causes: gathers from the solution's patches with rays, then with exact form factors
/// too. Each change is one cause's part.
fn attribute_causes(
    settings: &Settings,
    mesh: &Mesh,
    field: &RadiosityField,
    rays: &Rays,
    sampled: &[RegatheredTexel],
    light: DVec3,
) -> Vec<ErrorPart> {
    let mut variants = Vec::new();
    if settings.transport.visibility != Visibility::Rays {
        variants.push((ErrorCause::Visibility, settings.transport.form_factor));
    }
    if settings.transport.form_factor != FormFactor::Polygon {
        variants.push((ErrorCause::FormFactor, FormFactor::Polygon));
    }
    let cost = mesh.patches.len() as u64 * u64::from(mesh.samples) * variants.len() as u64;
    let max_texels = (ATTRIBUTION_RAYS / cost.max(1)).clamp(ATTRIBUTION_TEXELS[0], ATTRIBUTION_TEXELS[1]) as usize;
    let step = sampled.len().div_ceil(max_texels).max(1);
    let is_used = |k: usize| variants.is_empty() || k.is_multiple_of(step);
    let used = (0..sampled.len()).filter(|k| is_used(*k)).collect::<Vec<_>>();
    let mut before: Vec<DVec3> = used.iter().map(|k| sampled[*k].claimed).collect();
    let used_area = used.iter().map(|k| sampled[*k].area).sum::<f64>();
    let light = light * (used_area / represented_area(sampled));
    let mut parts = Vec::new();
    for (cause, form_factor) in variants {
        let own = PatchGatherer::new(mesh, field, form_factor);
        let found: Vec<DVec3> = used
            .par_iter()
            .map(|k| {
                let texel = &mesh.texels[sampled[*k].texel];
                let received = own.gather_texel(rays, sampled[*k].texel) + texel.sky.as_dvec3();
                texel.reflectance.as_dvec3() * received
            })
            .collect();
        let square = |n: usize| (found[n] - before[n]).powf(2.0);
        parts.push(error_part(cause, sampled, &used, square, light));
        before = found;
    }
    let square = |n: usize| {
        let sample = &sampled[used[n]];
        let [a, b] = [0, 1].map(|half| sample.claimed + sample.residuals[half] - sample.within_texels[half]);
        (a - before[n]) * (b - before[n])
    };
    parts.push(error_part(ErrorCause::Patches, sampled, &used, square, light));
    let square = |n: usize| {
        let [a, b] = sampled[used[n]].within_texels;
        a * b
    };
    parts.push(error_part(ErrorCause::Texels, sampled, &used, square, light));
    parts
}

/// Makes a cause's part of the error, with the most affected faces.
fn error_part(
    cause: ErrorCause,
    sampled: &[RegatheredTexel],
    used: &[usize],
    square: impl Fn(usize) -> DVec3,
    light: DVec3,
) -> ErrorPart {
    let mut sum = DVec3::ZERO;
    let mut faces = vec![0.0; sampled.iter().map(|sample| sample.face + 1).max().unwrap_or(0) as usize];
    for (n, k) in used.iter().enumerate() {
        let sample = &sampled[*k];
        let own = sample.area * square(n);
        sum += own;
        faces[sample.face as usize] += own.element_sum();
    }
    ErrorPart {
        cause,
        error: divide_or_zero(sum, light).max_element().max(0.0).sqrt(),
        faces: largest_faces(&faces),
    }
}
