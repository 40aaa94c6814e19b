//! What a solve does about its error by itself: options that the user did not give are changed, and
//! it is solved again, where that is cheap.

use super::Given;
use super::check::{Cause, Estimate};
use common::constants::LINK_BYTES;
use common::energy::Energy;
use common::mesh::Mesh;
use common::settings::{Iteration, Settings, Visibility};
use common::shooting::Run;
use gpu::Gpu;

/// An estimate beyond this is mended: half of what is warned about.
pub const MEND: f64 = 0.01;
/// (cell, texel, sample) triples of a solve that is thought cheap: a second on two cores.
const TRIPLES: u64 = 1 << 28;
/// The same by the rays of a software GPU.
const SOFTWARE_TRIPLES: u64 = 1 << 25;
/// The last change helped if it left no more than this of the estimate.
const HELPED: f64 = 0.8;
/// Samples that are taken without being asked for.
const SAMPLES: u32 = 256;
/// Closure that scaling mends, as a share of the emitted power.
const CLOSURE: f64 = 0.01;

/// What was solved, to be mended.
pub struct Solved<'a> {
    /// With which options.
    pub settings: &'a Settings,
    /// On which texels.
    pub mesh: &'a Mesh,
    /// How.
    pub run: &'a Run,
}

/// Whether a change had to help by itself: finer cells and more samples had to. Rays and scaling alone
/// need not, what they leave is mended by what follows.
pub fn had_to_help(from: &Settings, to: &Settings) -> bool {
    (from.cells, from.samples) != (to.cells, to.samples)
}

/// What to solve with instead, and why; none where nothing is to be mended, or nothing can be.
/// `before` is the estimate before a change that had to help: what does not is not done again.
pub fn mend(
    given: Given,
    gpu: Option<&Gpu>,
    solved: &Solved,
    estimate: &Estimate,
    before: Option<f64>,
) -> Option<(Settings, String)> {
    let sound = estimate.error <= MEND && !solved.run.stagnated;
    if sound || before.is_some_and(|b| estimate.error > HELPED * b) {
        return None;
    }
    let error = 100.0 * estimate.error;
    let (change, what) = change(given, solved, estimate)?;
    // A software GPU draws an item buffer in the time of ten thousand rays.
    let software = gpu.is_some_and(|gpu| gpu.line.software);
    let drawn = software && change.visibility != Visibility::Rays;
    if drawn && given.visibility {
        return None;
    }
    let settings = Settings {
        visibility: if drawn {
            Visibility::Rays
        } else {
            change.visibility
        },
        ..change
    };
    let by = if drawn { ", by rays" } else { "" };
    let most = if software { SOFTWARE_TRIPLES } else { TRIPLES };
    let cheap = cost(solved.mesh, &settings) <= most;
    cheap.then(|| {
        (
            settings,
            format!("mended: about {error:.1} % off, so {what}{by}"),
        )
    })
}

/// The change that takes away most.
fn change(given: Given, solved: &Solved, estimate: &Estimate) -> Option<(Settings, String)> {
    let settings = solved.settings;
    let part = |cause| {
        let found = estimate.parts.iter().find(|part| part.cause == cause);
        found.map_or(0.0, |part| part.error)
    };
    let rays = settings.visibility == Visibility::Rays || given.visibility;
    if !rays && part(Cause::Visibility) > part(Cause::Cells) {
        let by_rays = Settings {
            visibility: Visibility::Rays,
            ..settings.clone()
        };
        return Some((by_rays, "rays took the item buffer's place".into()));
    }
    let energy = Energy::new(solved.mesh, &solved.run.field, &solved.run.shots);
    let closed = given.form_factor || settings.conserve;
    // Rows that make up light may have no limit at all.
    let open = energy.share(energy.closure).abs() > CLOSURE || solved.run.stagnated;
    if open && !closed {
        // Scaled rows are not reciprocal, and conjugate directions need that: at ρ ≥ 0.999 they fail.
        let iteration = match settings.iteration {
            Iteration::Cg => Iteration::Chebyshev,
            other => other,
        };
        let conserved = Settings {
            conserve: true,
            iteration,
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
            (4 * settings.samples).min(SAMPLES.max(settings.samples))
        },
        ..settings.clone()
    };
    (finer != *settings).then(|| {
        let what = format!("{0}×{0} cells and {1} samples", finer.cells, finer.samples);
        (finer, what)
    })
}

/// Triples of a solve; all there are where the links would not be kept.
fn cost(mesh: &Mesh, settings: &Settings) -> u64 {
    let (faces, texels) = (mesh.faces.len() as u64, mesh.texels.len() as u64);
    let cells = faces * u64::from(settings.cells.min(settings.texels)).pow(2);
    let links = cells.saturating_mul(texels);
    if links.saturating_mul(4) > LINK_BYTES {
        return u64::MAX;
    }
    links.saturating_mul(u64::from(settings.samples))
}
