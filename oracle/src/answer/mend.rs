//! What a solve does about its error by itself: options that the user did not give are changed, and
//! it is solved again, where that is cheap.

use super::check::{Cause, Estimate};
use super::{Given, Question};
use crate::refine::Rung;
use common::constants::LINK_BYTES;
use common::energy::Energy;
use common::settings::{Settings, Visibility};

/// An estimate beyond this is mended: half of what is warned about.
pub const MEND: f64 = 0.01;
/// (cell, texel, sample) triples of a solve that is thought cheap: a second on two cores.
const TRIPLES: u64 = 1 << 28;
/// The same by the rays of a software GPU.
const SOFTWARE_TRIPLES: u64 = 1 << 25;
/// Closure that scaling mends, as a share of the emitted power.
const CLOSURE: f64 = 0.01;

/// What to solve with instead, and why; none where nothing is to be mended, or nothing can be.
pub fn mend(question: &Question, rung: &Rung, estimate: &Estimate) -> Option<(Settings, String)> {
    if estimate.error <= MEND {
        return None;
    }
    let error = 100.0 * estimate.error;
    let (settings, what) = change(question.given, rung, estimate)?;
    let software = question.gpu.is_some_and(|gpu| gpu.line.software);
    let most = if software { SOFTWARE_TRIPLES } else { TRIPLES };
    (cost(rung, &settings) <= most).then(|| {
        (
            settings,
            format!("mended: about {error:.1} % off, so {what}"),
        )
    })
}

/// The change that takes away most.
fn change(given: Given, rung: &Rung, estimate: &Estimate) -> Option<(Settings, String)> {
    let settings = &rung.settings;
    let part = |cause| {
        let found = estimate.parts.iter().find(|part| part.cause == cause);
        found.map_or(0.0, |part| part.error)
    };
    if !given.visibility && part(Cause::Visibility) > part(Cause::Cells) {
        let by_rays = Settings {
            visibility: Visibility::Rays,
            ..settings.clone()
        };
        return Some((by_rays, "rays took the item buffer's place".into()));
    }
    let energy = Energy::new(&rung.mesh, &rung.run.field, &rung.run.shots);
    let closed = given.form_factor || settings.conserve;
    if energy.share(energy.closure).abs() > CLOSURE && !closed {
        let conserved = Settings {
            conserve: true,
            ..settings.clone()
        };
        return Some((
            conserved,
            "form factors were scaled to the exact closure".into(),
        ));
    }
    let cells = (2 * settings.cells).min(settings.texels);
    let finer = Settings {
        cells: if given.cells { settings.cells } else { cells },
        samples: if given.samples {
            settings.samples
        } else {
            4 * settings.samples
        },
        ..settings.clone()
    };
    (finer != *settings).then(|| {
        let what = format!("{0}×{0} cells and {1} samples", finer.cells, finer.samples);
        (finer, what)
    })
}

/// Triples of a solve; all there are where the links would not be kept.
fn cost(rung: &Rung, settings: &Settings) -> u64 {
    let (faces, texels) = (rung.mesh.faces.len() as u64, rung.mesh.texels.len() as u64);
    let cells = faces * u64::from(settings.cells.min(settings.texels)).pow(2);
    let links = cells.saturating_mul(texels);
    if links.saturating_mul(4) > LINK_BYTES {
        return u64::MAX;
    }
    links.saturating_mul(u64::from(settings.samples))
}
