//! `--quality reference`: cells are halved until the answer settles.
//!
//! Rung k solves with K = 4·2ᵏ cells a side (and at least as many texels), S samples each. What
//! the last halving moved, d_k, and the one before it give the order and with it what is left
//! (Richardson): e ≈ d_k / (d_{k−1}/d_k − 1). Nothing here knows the scene.

use common::Result;
use common::constants::LINK_BYTES;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::Settings;
use common::shooting::{Field, Run};
use common::texel::Cells;
use glam::{DVec3, Vec4};

/// What is left must be estimated below this: area-weighted relative RMS of B − E.
pub const TARGET: f64 = 0.01;
/// (cell, texel, sample) triples of one rung: ten minutes or so on two cores.
const MOST_TRIPLES: u64 = 1 << 33;

/// One solve of the ladder.
pub struct Rung {
    /// Its settings; `texels` is what it was computed with.
    pub settings: Settings,
    /// Its mesh.
    pub mesh: Mesh,
    /// Its run.
    pub run: Run,
}

/// How the ladder ended.
pub struct Refined {
    /// The last rung.
    pub rung: Rung,
    /// The texels that were asked for.
    pub answer: Mesh,
    /// Its values on them.
    pub field: Field,
    /// What remains, by Richardson; none after a single rung.
    pub left: Option<f64>,
    /// What was chosen and why, a line each.
    pub notes: Vec<String>,
}

/// Solves `scene` on finer and finer cells; `solve` is one rung, `stop` whether to end early.
pub fn refine(
    scene: &Scene,
    settings: &Settings,
    mut solve: impl FnMut(&Settings) -> Result<Rung>,
    stop: impl Fn() -> bool,
) -> Result<Refined> {
    let answer = Mesh::uniform(scene, settings.texels, 1)?;
    let mut notes = Vec::new();
    let mut rung = solve(&at(settings, settings.cells))?;
    let mut field = average(scene, &rung, &answer);
    let mut moved: Option<f64> = None;
    let mut left = None;
    while !stop() && rung.run.converged {
        let cells = rung.settings.cells * 2;
        let finer = at(settings, cells);
        if let Some(reason) = too_much(scene, &finer) {
            notes.push(format!("reference: {cells}×{cells} cells {reason}"));
            break;
        }
        let next = solve(&finer)?;
        if stop() {
            break;
        }
        let next_field = average(scene, &next, &answer);
        let change = distance(&answer, &field, &next_field);
        let estimate = remainder(moved, change);
        notes.push(format!(
            "reference: {cells}×{cells} cells moved the answer by {:.2} %, {} left (bound {} %)",
            100.0 * change,
            estimate.map_or("not yet known what is".into(), |e| format!(
                "about {:.2} %",
                100.0 * e
            )),
            100.0 * TARGET,
        ));
        (rung, field, moved, left) = (next, next_field, Some(change), estimate);
        if left.is_some_and(|left| left <= TARGET) {
            break;
        }
    }
    Ok(Refined {
        rung,
        answer,
        field,
        left,
        notes,
    })
}

/// The settings with K×K cells: texels are never larger than cells.
fn at(settings: &Settings, cells: u32) -> Settings {
    Settings {
        cells,
        texels: settings.texels * cells.div_ceil(settings.texels),
        ..settings.clone()
    }
}

/// Why a rung is not tried.
fn too_much(scene: &Scene, settings: &Settings) -> Option<String> {
    let faces = scene.faces.len() as u64;
    let texels = faces * u64::from(settings.texels).pow(2);
    let cells = faces * u64::from(settings.cells.min(settings.texels)).pow(2);
    let triples = cells
        .saturating_mul(texels)
        .saturating_mul(u64::from(settings.samples));
    let bytes = cells.saturating_mul(texels).saturating_mul(4);
    if bytes > LINK_BYTES {
        return Some(format!(
            "would need {} MiB of links, {} are kept",
            bytes >> 20,
            LINK_BYTES >> 20
        ));
    }
    (triples > MOST_TRIPLES).then(|| format!("would need {:.1e} samples", triples as f64))
}

/// What is left after a change that followed `before`; not known where the changes do not fall.
fn remainder(before: Option<f64>, change: f64) -> Option<f64> {
    let ratio = before? / change;
    if change == 0.0 {
        return Some(0.0);
    }
    // Beyond second order the estimate would flatter: cells are constant.
    (ratio > 1.0).then(|| change / (ratio.min(4.0) - 1.0))
}

/// The field on the texels of `answer`: means over area.
fn average(scene: &Scene, rung: &Rung, answer: &Mesh) -> Field {
    let fine = &rung.mesh;
    let mut first = vec![0u32; answer.faces.len() + 1];
    for (k, face) in answer.faces.iter().enumerate() {
        first[k + 1] = first[k] + face.resolution[0] * face.resolution[1];
    }
    let count = answer.texels.len();
    let mut sums = vec![([DVec3::ZERO; 3], 0.0f64); count];
    for (k, texel) in fine.texels.iter().enumerate() {
        let face = texel.face as usize;
        let [side, _] = answer.faces[face].resolution;
        let cells = Cells::new(scene.faces[face].shape, fine.faces[face].resolution, side);
        let sum = &mut sums[(first[face] + cells.of_texel(texel.index)) as usize];
        let area = f64::from(texel.area);
        let field = &rung.run.field;
        for (part, values) in
            sum.0
                .iter_mut()
                .zip([&field.radiosity, &field.residual, &field.irradiance])
        {
            *part += values[k].truncate().as_dvec3() * area;
        }
        sum.1 += area;
    }
    let part = |part: usize| -> Vec<Vec4> {
        let mean = |texel: &common::mesh::Texel| {
            let (values, area) = &sums[(first[texel.face as usize] + texel.index) as usize];
            if *area > 0.0 {
                (values[part] / *area).as_vec3().extend(0.0)
            } else {
                Vec4::ZERO
            }
        };
        answer.texels.iter().map(mean).collect()
    };
    Field {
        origin: rung.run.field.origin.clone(),
        radiosity: part(0),
        residual: part(1),
        irradiance: part(2),
    }
}

/// √(ΣA(a − b)²/ΣA b²) of B − E, the worst channel.
fn distance(mesh: &Mesh, a: &Field, b: &Field) -> f64 {
    let (mut square, mut scale) = (DVec3::ZERO, DVec3::ZERO);
    for (k, texel) in mesh.texels.iter().enumerate() {
        let area = f64::from(texel.area);
        let (x, y) = (a.radiosity[k].truncate(), b.radiosity[k].truncate());
        square += (x - y).as_dvec3().powf(2.0) * area;
        scale += (y - texel.emission).as_dvec3().powf(2.0) * area;
    }
    let worst = |c: usize| {
        if square[c] == 0.0 {
            0.0
        } else {
            (square[c] / scale[c]).sqrt()
        }
    };
    worst(0).max(worst(1)).max(worst(2))
}
