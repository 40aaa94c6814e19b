//! An estimate of an answer's error that needs no truth: what its own light brings to a few of its
//! texels, asked again in finer ways.
//!
//! ```text
//! H'_j = Σ_i w'_ji B_i      H" = H' + LEFT (H' − H°)
//! δ = ρ(H" − H)             error² ≈ mean δ² / mean (ρH")² + (β ΣAB/ΣAE)²
//! ```
//! B is the answer's radiosity, H the irradiance that it claims; w' are links by rays from cells of
//! half the size with four times the samples, H° is by rays from its own cells and samples, both with
//! form factors that leave nothing to mend. Before them an item buffer's answer is asked by rays with
//! its own form factor, so that causes can be told apart. β is the share of light that is made up or lost at every reflection,
//! as far as it stands out of its noise: in all it comes to β·ΣAB/ΣAE. The texels are the same each
//! time.

mod choose;
mod places;
mod way;

use choose::choose;
use common::Result;
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::settings::{Settings, Visibility};
use common::shooting::Field;
use cpu::rays::Rays;
use glam::DVec3;
use rayon::prelude::*;
use way::Way;

/// What halved cells and four times the samples leave of what they mend: their orders are 1.2 and
/// 0.7 (`converge`), so two fifths of the error remain, as much as half of what was mended.
const LEFT: f64 = 0.5;
/// Rays of all looks together, unless fewer than the least texels would be left.
const BUDGET: u64 = 1 << 20;
/// Texels that are looked at, at most: of n Gaussian errors the RMS is known to 1/√(2n).
const MOST: u64 = 256;
/// At least.
const LEAST: u64 = 16;
/// Points of finer cells: more are not made.
const POINTS: u64 = 1 << 20;
/// Faces that a part or a warning names.
pub const NAMED: usize = 8;

/// What explains a difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The item buffer: rays see something else.
    Visibility,
    /// The form factor: Lambert's polygon is another.
    FormFactor,
    /// Whole cells for what varies within them, and the noise of few samples.
    Cells,
}

/// One cause's part.
#[derive(Clone, Debug)]
pub struct Part {
    /// The cause.
    pub cause: Cause,
    /// Relative RMS of what it explains.
    pub error: f64,
    /// The faces that it concerns most, the worst first.
    pub faces: Vec<u32>,
}

/// What is found.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Relative RMS of B − E, of the worst channel.
    pub error: f64,
    /// The same with one standard error of its square on top: a few texels on the edges of shadows
    /// make most of it, and not all of them are looked at.
    pub upper: f64,
    /// Its causes.
    pub parts: Vec<Part>,
}

/// One texel, looked at.
struct Look {
    /// Its face.
    face: u32,
    /// The area that it stands for.
    area: f64,
    /// ρH as the answer claims it, as each way finds it, and as it would be in the limit.
    reflected: Vec<DVec3>,
}

/// Looks at `field` on `mesh`, the answer of `settings`; `remade` is the same texels with other
/// cells and samples. None where finer cells would be too many.
pub fn estimate(
    settings: &Settings,
    mesh: &Mesh,
    field: &Field,
    remade: impl FnOnce(&Settings) -> Result<Mesh>,
) -> Result<Option<Estimate>> {
    let Some(Ways { ways, causes }) = ways(settings, mesh, field, remade)? else {
        return Ok(None);
    };
    let rays = Rays::new(mesh);
    let cost: u64 = ways.iter().map(Way::rays).sum();
    let looks: Vec<Look> = choose(mesh, field, (BUDGET / cost.max(1)).clamp(LEAST, MOST))
        .into_par_iter()
        .map(|(k, area)| {
            let found = ways.iter().map(|way| way.gather(&rays, mesh, k));
            Look::new(mesh, field, k, area, found)
        })
        .collect();
    let last = ways.len() + 1;
    // Scaled rows close: none makes up or loses light.
    let drift = if settings.conserve {
        DVec3::ZERO
    } else {
        drift(&looks, last) * gain(mesh, field)
    };
    let total = |rms: DVec3| (rms * rms + drift * drift).max_element().sqrt();
    let mut from = 0;
    let part = |(cause, to)| {
        let part = Part {
            cause,
            error: relative_rms(&looks, from, to, 0.0).max_element(),
            faces: worst(&looks, from, to),
        };
        from = to;
        part
    };
    Ok(Some(Estimate {
        parts: causes.into_iter().map(part).collect(),
        error: total(relative_rms(&looks, 0, last, 0.0)),
        upper: total(relative_rms(&looks, 0, last, 1.0)),
    }))
}

impl Look {
    /// Texel `k` and what the ways found, the last one with the answer's own cells before it.
    fn new(
        mesh: &Mesh,
        field: &Field,
        k: usize,
        area: f64,
        found: impl Iterator<Item = DVec3>,
    ) -> Self {
        let texel = &mesh.texels[k];
        let reflectance = texel.reflectance.as_dvec3();
        let claimed = field.irradiance[k].truncate().as_dvec3();
        let mut reflected: Vec<DVec3> = std::iter::once(claimed)
            .chain(found)
            .map(|irradiance| reflectance * irradiance)
            .collect();
        if let [.., own, finer] = reflected[..] {
            reflected.push(finer + LEFT * (finer - own));
        }
        Self {
            face: texel.face,
            area,
            reflected,
        }
    }
}

/// The ways to gather, the last two with own and with finer cells; and what explains the differences,
/// each up to its place among [`Look::reflected`].
struct Ways {
    ways: Vec<Way>,
    causes: Vec<(Cause, usize)>,
}

fn ways(
    settings: &Settings,
    mesh: &Mesh,
    field: &Field,
    remade: impl FnOnce(&Settings) -> Result<Mesh>,
) -> Result<Option<Ways>> {
    let Some(finer) = finer(mesh, settings) else {
        return Ok(None);
    };
    let way = |own: Mesh, form_factor, exact| Way::new(own, (form_factor, exact), mesh, field);
    let (mut ways, mut causes) = (Vec::new(), Vec::new());
    if settings.visibility != Visibility::Rays {
        ways.push(way(mesh.clone(), settings.form_factor, false));
        causes.push((Cause::Visibility, ways.len()));
    }
    ways.push(way(mesh.clone(), FormFactor::Polygon, true));
    if settings.form_factor != FormFactor::Polygon {
        causes.push((Cause::FormFactor, ways.len()));
    }
    ways.push(way(remade(&finer)?, FormFactor::Polygon, true));
    causes.push((Cause::Cells, ways.len() + 1));
    Ok(Some(Ways { ways, causes }))
}

/// Cells of half the size and four times the samples, or what can be had of that.
fn finer(mesh: &Mesh, settings: &Settings) -> Option<Settings> {
    let (cells, samples) = (settings.cells.min(settings.texels), settings.samples);
    let half = (2 * cells).min(settings.texels);
    let points = |k: u32, samples: u32| {
        let finer = mesh.cells.len() as u64 * u64::from(k.div_ceil(cells)).pow(2);
        finer.min(mesh.texels.len() as u64) * u64::from(samples)
    };
    [(half, 4 * samples), (half, samples), (cells, 4 * samples)]
        .into_iter()
        .find(|(cells, samples)| points(*cells, *samples) <= POINTS)
        .map(|(cells, samples)| Settings {
            cells,
            samples,
            ..settings.clone()
        })
}

/// √(mean (b − a)² / mean l²) of the channels, l being the limit, with so many standard
/// errors of the first mean on top.
fn relative_rms(looks: &[Look], a: usize, b: usize, more: f64) -> DVec3 {
    let (mut change, mut square, mut light) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for look in looks {
        let delta = look.reflected[b] - look.reflected[a];
        let found = look.reflected.last().copied().unwrap_or_default();
        let part = look.area * delta * delta;
        change += part;
        square += part * part;
        light += look.area * found * found;
    }
    share(change + more * square.map(f64::sqrt), light).map(f64::sqrt)
}

/// Σ(b − a)/Σb of all ways together, less two standard errors.
fn drift(looks: &[Look], last: usize) -> DVec3 {
    let (mut change, mut square, mut light) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for look in looks {
        let delta = look.area * (look.reflected[last] - look.reflected[0]);
        change += delta;
        square += delta * delta;
        light += look.area * look.reflected[last];
    }
    let noise = square.map(f64::sqrt);
    share((change.abs() - 2.0 * noise).max(DVec3::ZERO), light)
}

/// ΣAB/ΣAE: how much of itself a watt becomes by reflections.
fn gain(mesh: &Mesh, field: &Field) -> DVec3 {
    let (mut all, mut emitted) = (DVec3::ZERO, DVec3::ZERO);
    for (texel, b) in mesh.texels.iter().zip(&field.radiosity) {
        let area = f64::from(texel.area);
        all += area * b.truncate().as_dvec3();
        emitted += area * texel.emission.as_dvec3();
    }
    share(all, emitted)
}

/// a/b; 0/0 is 0.
fn share(a: DVec3, b: DVec3) -> DVec3 {
    let part = |a: f64, b: f64| if a == 0.0 { 0.0 } else { a / b };
    DVec3::new(part(a.x, b.x), part(a.y, b.y), part(a.z, b.z))
}

/// The faces with most of the difference.
fn worst(looks: &[Look], a: usize, b: usize) -> Vec<u32> {
    let mut faces: Vec<(u32, f64)> = Vec::new();
    for look in looks {
        let square = look.area * (look.reflected[b] - look.reflected[a]).length_squared();
        match faces.iter_mut().find(|(face, _)| *face == look.face) {
            Some((_, sum)) => *sum += square,
            None => faces.push((look.face, square)),
        }
    }
    faces.retain(|(_, sum)| *sum > 0.0);
    faces.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    faces.truncate(NAMED);
    faces.into_iter().map(|(face, _)| face).collect()
}
