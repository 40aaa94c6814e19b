//! `--quality reference`: cells are halved until the answer settles.
//!
//! Rung k solves with K = 4·2ᵏ cells a side (and at least as many texels), S samples each. What
//! the last halving changed, d_k, and the one before it give the order of convergence, and with it what
//! is left (Richardson): e ≈ d_k / (d_{k−1}/d_k − 1). Nothing here depends on the scene.

use super::solved::Solved;
use crate::judge::compare::difference::difference;
use crate::judge::diff::reflected::offsets;
use crate::judge::resample::{average, pieces};
use crate::plan::Counts;
use common::constants::LINK_BYTES;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::Settings;
use common::shooting::Field;
use common::{Error, Result};
use glam::{DVec3, Vec4};

/// What is left must be estimated below this: area-weighted relative RMS of B − E.
pub const TARGET: f64 = 0.01;
/// (cell, texel, sample) triples of one rung: ten minutes or so on two cores.
const MOST_TRIPLES: u64 = 1 << 33;

/// How the ladder ended.
pub struct Refined {
    /// The last rung.
    pub rung: Solved,
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
    mut solve: impl FnMut(&Settings) -> Result<Solved>,
    stop: impl Fn() -> bool,
) -> Result<Refined> {
    let answer = Mesh::uniform(scene, settings.meshing.texels, 1)?;
    let mut notes = Vec::new();
    let mut rung = solve(&at(settings, settings.meshing.cells))?;
    let mut field = averaged(scene, &rung, &answer);
    let mut moved: Option<f64> = None;
    let mut left = None;
    while !stop() && rung.run.converged {
        let cells = rung.settings.meshing.cells * 2;
        let finer = at(settings, cells);
        if let Some(reason) = too_much(scene, &finer) {
            notes.push(format!("reference: {cells}×{cells} cells {reason}"));
            break;
        }
        let next = match solve(&finer) {
            Err(Error::Interrupted) => break,
            next => next?,
        };
        if stop() {
            break;
        }
        let next_field = averaged(scene, &next, &answer);
        let change = difference(&answer, &field, &next_field).relative_rms;
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
    let mut finer = *settings;
    finer.meshing.cells = cells;
    finer.meshing.texels *= cells.div_ceil(settings.meshing.texels);
    finer
}

/// Why a rung is not tried.
fn too_much(scene: &Scene, settings: &Settings) -> Option<String> {
    let counts = Counts::new(scene, &settings.meshing);
    let triples = counts.links().saturating_mul(counts.samples);
    let bytes = counts.links().saturating_mul(4);
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

/// The field on the texels of `answer`, which has whole faces as cells: means over area.
fn averaged(scene: &Scene, rung: &Solved, answer: &Mesh) -> Field {
    let (fine, field) = (&rung.mesh, &rung.run.field);
    let resolutions: Vec<[u32; 2]> = fine.faces.iter().map(|f| f.resolution).collect();
    let first = offsets(&resolutions);
    let order = fine.in_face_order();
    let part = |values: &[Vec4]| -> Vec<Vec4> {
        let of = |k: &usize| values[*k].truncate().as_dvec3();
        let ordered: Vec<DVec3> = order.iter().map(of).collect();
        let of_face = |(k, face): (usize, &Face)| {
            let to = answer.faces[k].resolution;
            let shared = pieces(face, resolutions[k], to);
            average(&ordered[first[k]..first[k + 1]], &shared, to)
        };
        let means = scene.faces.iter().enumerate().flat_map(of_face);
        means.map(|v| v.as_vec3().extend(0.0)).collect()
    };
    let cells = rung.settings.meshing.cells;
    Field {
        // Two rungs are two results: their comparison refuses one of the same origin.
        origin: format!("{}, {cells}×{cells} cells", field.origin),
        radiosity: part(&field.radiosity),
        residual: part(&field.residual),
        irradiance: part(&field.irradiance),
    }
}
