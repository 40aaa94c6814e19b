//! An estimate of an answer's error that needs no truth, and shares nothing with the solver that
//! could hide what it gets wrong: the answer's own light is gathered again on a draw of its texels by
//! rays alone, without cells, form factors or samples of its own.
//!
//! ```text
//! r_j = ρ(H'_j − H_j)      e_j = r_j + x_g(j)      x = ρF(r̄ + x)
//! error² = Σ A e·e' / Σ A l·l'       l = ρH + e
//! ```
//! H is the irradiance that the answer claims, H' what is gathered: `gather`. r is all that one
//! bounce gets wrong, including what is unshot and what changes within the texels that it comes from;
//! x is what later bounces make of its means over groups of faces: `later`. e and e' come from
//! independent rays and x from independent texels, so that the product's mean is e², without noise. No
//! error below the standard error of that mean is reported.

mod choose;
pub mod estimate;
mod gather;
mod later;
mod light;
mod own;
mod slope;

use choose::{Chosen, choose};
use common::Result;
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::Scene;
use common::settings::{Quality, Settings, Visibility};
use common::shooting::Field;
pub use estimate::{Cause, Estimate, Evidence, NAMED, Part, Worse};
use gather::Gather;
use glam::DVec3;
use later::Groups;
use light::{Light, reflected};
use own::Own;
use rayon::prelude::*;

/// An error beyond this is warned about.
pub const LIMIT: f64 = 0.02;
/// Texels that are looked at, unless these leave it undecided on which side of [`LIMIT`] the error is.
const LOOKS: u32 = 1 << 10;
/// Rays of each kind and half that all looks share; with those that they lead to, five times as many.
/// At reference quality four times as many: its errors are smaller, and its solves longer.
const BUDGET: u32 = 1 << 17;
/// Rays to each of them: two halves of two kinds, and four more from where each ends.
const RAYS: u64 = 2 * 2 * 5;
/// Rays of each kind and half that tell how many are worth their while.
const PILOT: u32 = 16;
/// Rays that tell causes apart, unless that left too few looks.
const BLAMING: u64 = 1 << 20;
/// Looks that tell causes apart, at least and at most.
const BLAMED: [u64; 2] = [16, 256];
/// Of the light that is claimed, what is taken to be there at least.
const LEAST: f64 = 1e-4;

/// One texel, looked at.
pub struct Look {
    /// It.
    texel: usize,
    /// Its face.
    face: u32,
    /// The area that it stands for.
    area: f64,
    /// How likely it was to be looked at.
    share: f64,
    /// ρH as the answer claims it.
    claimed: DVec3,
    /// r, twice.
    missed: [DVec3; 2],
    /// What of it comes of light that varies within texels.
    within: [DVec3; 2],
    /// What of r later bounces carry on.
    carried: DVec3,
    /// Whether a body stands on it: then others know what it misses.
    cut: bool,
    /// The share of its rays that met fronts of each group.
    met: Vec<(usize, f64)>,
}

/// Looks at `field` on `mesh`, the answer of `settings` for `scene`: at a few texels, which is enough where
/// the error is far beyond [`LIMIT`], then at more, and at four times as many with as many times the
/// rays where these cannot tell on which side of it the error is.
pub fn estimate(
    scene: &Scene,
    settings: &Settings,
    mesh: &Mesh,
    field: &Field,
) -> Result<Estimate> {
    let rays = Rays::new(mesh);
    let light = Light::new(scene, mesh, field, &rays);
    let gather = Gather {
        mesh,
        light: &light,
        rays: &rays,
    };
    let finer = settings.quality == Quality::Reference;
    let budget = if finer { 4 * BUDGET } else { BUDGET };
    let found = estimated(scene, settings, &gather, field, [LOOKS / 4, budget / 4])?;
    if found.least() > 2.0 * LIMIT {
        return Ok(found);
    }
    let found = estimated(scene, settings, &gather, field, [LOOKS, budget])?;
    if found.most() <= LIMIT || found.least() > LIMIT {
        return Ok(found);
    }
    estimated(scene, settings, &gather, field, [4 * LOOKS, 4 * budget])
}

fn estimated(
    scene: &Scene,
    settings: &Settings,
    gather: &Gather,
    field: &Field,
    [looks, budget]: [u32; 2],
) -> Result<Estimate> {
    let mesh = gather.mesh;
    let groups = Groups::new(scene, mesh, looks as usize);
    let chosen = choose(mesh, field, u64::from(looks));
    let samples = shared(gather, &chosen, budget);
    let looks: Vec<Look> = (chosen.into_par_iter().zip(&samples))
        .map(|(chosen, samples)| Look::new(gather, field, &groups, &chosen, *samples))
        .collect();
    let later = groups.later(&looks)?;
    let errors: Vec<[DVec3; 2]> = looks
        .iter()
        .map(|look| {
            let x = [&later[0], &later[1]].map(|x| x[groups.of(look.texel)]);
            [0, 1].map(|half| look.missed[half] + x[half])
        })
        .collect();
    let light = bright(&looks, &errors);
    let found = Moment::of(&looks, |k| errors[k], light);
    let one = Moment::of(&looks, |k| looks[k].missed, light);
    let x = |k: usize| {
        let look = &looks[k];
        [0, 1].map(|half| errors[k][half] - look.missed[half])
    };
    let coherent = Moment::of(&looks, x, light);
    // What all texels have of it in common is not as many draws as there are looks.
    let common = mean(&looks, |k| x(k)[0] - x(k)[1]).powf(2.0) * area(&looks);
    let doubt = found.doubt + 0.5 * share(common, light);
    let square = found.mean.max(doubt);
    Ok(Estimate {
        error: square.max_element().sqrt(),
        upper: (found.mean.max(DVec3::ZERO) + 2.0 * doubt)
            .max_element()
            .sqrt(),
        evidence: Evidence::Looked {
            one_bounce: one.mean.max_element().max(0.0).sqrt(),
            later_bounces: coherent.mean.max_element().max(0.0).sqrt(),
            floor: doubt.max_element().sqrt(),
            rays: samples.iter().map(|n| RAYS * u64::from(*n + PILOT)).sum(),
            looks: looks.len(),
        },
        parts: blame(settings, mesh, field, gather.rays, &looks, light),
    })
}

/// The rays of each look. Its part of the mean's variance is (A v/n)², v the variance of a ray; of so
/// many rays in all the least is left by n as (A v)^⅔. Half of them go that way, half to all alike:
/// what comes through a chink no pilot may find. The pilot's rays are not used again: the mean stays
/// fair.
fn shared(gather: &Gather, chosen: &[Chosen], budget: u32) -> Vec<u32> {
    let pilot = |chosen: &Chosen| {
        let reflectance = gather.mesh.texels[chosen.texel].reflectance.as_dvec3();
        let variance = gather.at(chosen.texel, PILOT, 0).variance;
        (chosen.area * variance * reflectance.length_squared()).powf(2.0 / 3.0)
    };
    let weights: Vec<f64> = chosen.par_iter().map(pilot).collect();
    let all = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let alike = 1.0 / weights.len() as f64;
    let share = |weight: &f64| 0.5 * (alike + weight / all);
    let samples = |weight: &f64| (share(weight) * f64::from(budget)) as u32;
    weights
        .iter()
        .map(|weight| samples(weight).max(1))
        .collect()
}

impl Look {
    fn new(
        gather: &Gather,
        field: &Field,
        groups: &Groups,
        &Chosen { texel, area, share }: &Chosen,
        samples: u32,
    ) -> Self {
        let mesh = gather.mesh;
        let claimed = reflected(mesh, field, texel);
        let found = gather.at(texel, samples, 1);
        let reflectance = mesh.texels[texel].reflectance.as_dvec3();
        let ray = 0.5 / f64::from(samples);
        let [a, b] = [0, 1].map(|half| found.irradiance[half] - found.even[half]);
        let mut met: Vec<(usize, f64)> = Vec::new();
        for texel in found.met {
            let group = groups.of(texel);
            match met.iter_mut().find(|(known, _)| *known == group) {
                Some((_, sum)) => *sum += ray,
                None => met.push((group, ray)),
            }
        }
        Self {
            texel,
            face: mesh.texels[texel].face,
            area,
            share,
            claimed,
            cut: gather.light.cut(texel),
            missed: found.irradiance.map(|h| reflectance * h - claimed),
            within: found.within.map(|h| reflectance * h),
            carried: 0.5 * reflectance * (a + b) - claimed,
            met,
        }
    }
}

/// Σ A l·l', but no less than a share of what is claimed: what is told from noise alone is no light.
fn bright(looks: &[Look], errors: &[[DVec3; 2]]) -> DVec3 {
    let (mut light, mut claimed) = (DVec3::ZERO, DVec3::ZERO);
    for (look, e) in looks.iter().zip(errors) {
        light += look.area * (look.claimed + e[0]) * (look.claimed + e[1]);
        claimed += look.area * look.claimed * look.claimed;
    }
    light.max(LEAST * claimed)
}

fn area(looks: &[Look]) -> f64 {
    looks
        .iter()
        .map(|look| look.area)
        .sum::<f64>()
        .max(f64::MIN_POSITIVE)
}

fn mean(looks: &[Look], value: impl Fn(usize) -> DVec3) -> DVec3 {
    let parts = looks
        .iter()
        .enumerate()
        .map(|(k, look)| look.area * value(k));
    parts.sum::<DVec3>() / area(looks)
}

/// A mean square relative to the light's, and its standard error; of each channel.
struct Moment {
    mean: DVec3,
    doubt: DVec3,
}

impl Moment {
    /// Of e·e', e and e' two halves. Its variance is that of the draw of texels and that of their rays:
    ///
    /// ```text
    /// Σ A² ((1 − π)(e·e' − m)² + π(e² − e'²)²/4)
    /// ```
    /// π how likely each was to be drawn, m the mean (Horvitz & Thompson 1952; the second term is the
    /// variance of e·e' where e and e' are normal and alike).
    fn of(looks: &[Look], errors: impl Fn(usize) -> [DVec3; 2], light: DVec3) -> Self {
        let square = |k: usize| {
            let [a, b] = errors(k);
            a * b
        };
        let mean = mean(looks, square);
        let mut variance = DVec3::ZERO;
        for (k, look) in looks.iter().enumerate() {
            let [a, b] = errors(k);
            let drawn = (a * b - mean).powf(2.0);
            let rays = 0.25 * (a * a - b * b).powf(2.0);
            variance += look.area * look.area * ((1.0 - look.share) * drawn + look.share * rays);
        }
        Self {
            mean: share(mean * area(looks), light),
            doubt: share(variance.map(f64::sqrt), light),
        }
    }
}

/// a/b; 0/0 is 0.
fn share(a: DVec3, b: DVec3) -> DVec3 {
    let part = |a: f64, b: f64| if a == 0.0 { 0.0 } else { a / b };
    DVec3::new(part(a.x, b.x), part(a.y, b.y), part(a.z, b.z))
}

/// What each cause explains: the answer's cells are asked by rays, then with exact form factors.
fn blame(
    settings: &Settings,
    mesh: &Mesh,
    field: &Field,
    rays: &Rays,
    looks: &[Look],
    light: DVec3,
) -> Vec<Part> {
    let mut ways = Vec::new();
    if settings.transport.visibility != Visibility::Rays {
        ways.push((Cause::Visibility, settings.transport.form_factor));
    }
    if settings.transport.form_factor != FormFactor::Polygon {
        ways.push((Cause::FormFactor, FormFactor::Polygon));
    }
    let cost = mesh.cells.len() as u64 * u64::from(mesh.samples) * ways.len() as u64;
    let most = (BLAMING / cost.max(1)).clamp(BLAMED[0], BLAMED[1]) as usize;
    let step = looks.len().div_ceil(most).max(1);
    let some = |k: usize| ways.is_empty() || k.is_multiple_of(step);
    let asked = (0..looks.len()).filter(|k| some(*k)).collect::<Vec<_>>();
    let mut before: Vec<DVec3> = asked.iter().map(|k| looks[*k].claimed).collect();
    let of_asked = asked.iter().map(|k| looks[*k].area).sum::<f64>();
    let light = light * (of_asked / area(looks));
    let mut parts = Vec::new();
    for (cause, form_factor) in ways {
        let own = Own::new(mesh, field, form_factor);
        let found: Vec<DVec3> = asked
            .par_iter()
            .map(|k| {
                mesh.texels[looks[*k].texel].reflectance.as_dvec3()
                    * own.gather(rays, looks[*k].texel)
            })
            .collect();
        let square = |n: usize| (found[n] - before[n]).powf(2.0);
        parts.push(part(cause, looks, &asked, square, light));
        before = found;
    }
    let square = |n: usize| {
        let look = &looks[asked[n]];
        let [a, b] = [0, 1].map(|half| look.claimed + look.missed[half] - look.within[half]);
        (a - before[n]) * (b - before[n])
    };
    parts.push(part(Cause::Cells, looks, &asked, square, light));
    let square = |n: usize| {
        let [a, b] = looks[asked[n]].within;
        a * b
    };
    parts.push(part(Cause::Texels, looks, &asked, square, light));
    parts
}

/// A part, and the faces with most of it.
fn part(
    cause: Cause,
    looks: &[Look],
    asked: &[usize],
    square: impl Fn(usize) -> DVec3,
    light: DVec3,
) -> Part {
    let mut sum = DVec3::ZERO;
    let mut faces: Vec<(u32, f64)> = Vec::new();
    for (n, k) in asked.iter().enumerate() {
        let look = &looks[*k];
        let own = look.area * square(n);
        sum += own;
        match faces.iter_mut().find(|(face, _)| *face == look.face) {
            Some((_, sum)) => *sum += own.element_sum(),
            None => faces.push((look.face, own.element_sum())),
        }
    }
    faces.retain(|(_, sum)| *sum > 0.0);
    faces.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    faces.truncate(NAMED);
    Part {
        cause,
        error: share(sum, light).max_element().max(0.0).sqrt(),
        faces: faces.into_iter().map(|(face, _)| face).collect(),
    }
}
