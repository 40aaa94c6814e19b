//! Warnings about results that may be more than 2 % off, each with the option that helps. Every answer of
//! [`super::solve_request`] carries them.

use super::error_estimate::{certain_closure, mean_reflections, rounding_error};
use super::plausibility::could_reflect;
use super::regather::estimate::{MAX_NAMED_FACES, largest_faces};
use super::regather::{ErrorCause, ErrorEstimate, ErrorPart, EstimateBasis, WARNING_LIMIT};
use common::energy::EnergyBalance;
use common::mesh::{Mesh, Patch, Texel};
use common::precision::{ShapeLoss, find_shape_losses};
use common::scene::Scene;
use common::shooting::SolveRun;
use common::solution::{Warning, WarningCode};
use glam::Vec3;

/// Share of the emitted power above which an effect causes a warning.
const WARNING_SHARE: f64 = 0.02;

/// Collects the warnings of a solve.
pub fn collect_warnings(scene: &Scene, mesh: &Mesh, run: &SolveRun, estimate: Option<&ErrorEstimate>) -> Vec<Warning> {
    let mut warnings: Vec<Warning> = estimate.and_then(warn_of_estimate).into_iter().collect();
    warnings.extend(warn_of_bent_faces(scene, mesh, run));
    let warned = warnings.iter().any(|warning| warning.code == WarningCode::Closure);
    let closure = unexplained_closure(mesh, run, estimate);
    if closure.abs() > WARNING_SHARE && !warned {
        let advice = match estimate.is_some_and(is_from_steps) {
            true => "ask for a smaller --error",
            false => "use --form-factor polygon, more --patches or --conserve",
        };
        warnings.push(Warning {
            code: WarningCode::Closure,
            faces: worst_closure(mesh, run),
            message: format!(
                "the form factors {} {:.1} % of the emitted power: {advice}",
                if closure > 0.0 { "lose" } else { "add" },
                100.0 * closure.abs()
            ),
        });
    }
    warnings.extend(warn_of_rounding(mesh, run));
    warnings.extend(warn_of_covered_lamps(mesh).or_else(|| warn_of_no_light(mesh, run)));
    warnings.extend(warn_of_unshot(mesh, run, estimate));
    if !mesh.overlaps.is_empty() {
        let mut faces: Vec<u32> = mesh.overlaps.concat();
        faces.sort_unstable();
        faces.dedup();
        faces.truncate(MAX_NAMED_FACES);
        warnings.push(Warning {
            code: WarningCode::Overlap,
            faces,
            message: format!(
                "{} pairs of fronts lie on each other: only one of each is lit, a lamp or else the first in the file",
                mesh.overlaps.len()
            ),
        });
    }
    warnings
}

/// True if the estimate comes from successive steps.
fn is_from_steps(estimate: &ErrorEstimate) -> bool {
    matches!(estimate.evidence, EstimateBasis::SuccessiveSteps { .. })
}

/// Share of the emitted power that the form factors lose (negative: add), as far as the error estimate does not explain
/// it. An estimate from successive steps does not see light that both steps lose, so a defect beyond the noise of the
/// escaped power counts. Any other estimate includes later bounces and, if it is small, explains the defect: the open
/// share of a patch comes from the few rays of one point.
pub fn unexplained_closure(mesh: &Mesh, run: &SolveRun, estimate: Option<&ErrorEstimate>) -> f64 {
    let energy = EnergyBalance::new(mesh, &run.field, &run.shots);
    match estimate {
        Some(estimate) if is_from_steps(estimate) => certain_closure(&energy, mesh, run),
        Some(estimate) if estimate.upper <= 0.5 * WARNING_LIMIT => 0.0,
        _ => energy.share_of_emitted(energy.closure),
    }
}

/// Warns of a large estimate, with advice against its largest cause.
fn warn_of_estimate(estimate: &ErrorEstimate) -> Option<Warning> {
    if estimate.upper <= WARNING_LIMIT {
        return None;
    }
    let worst = |a: &&ErrorPart, b: &&ErrorPart| a.error.total_cmp(&b.error);
    let part = estimate.parts.iter().max_by(worst)?;
    let (code, why) = match part.cause {
        ErrorCause::Visibility => (
            WarningCode::Visibility,
            "the item buffer is too coarse: use --visibility rays",
        ),
        ErrorCause::FormFactor => (
            WarningCode::Closure,
            "the disc form factor is too crude: use --form-factor polygon",
        ),
        ErrorCause::Patches => (
            WarningCode::Patches,
            "light or shadow varies within patches: use more --patches and --samples, or `solve` in place of `shoot`",
        ),
        ErrorCause::Texels => (
            WarningCode::Texels,
            "light or shadow varies within texels: use more --texels",
        ),
        ErrorCause::Refinement => (
            WarningCode::Texels,
            "the last refinement still changed the result by about this much",
        ),
        ErrorCause::Closure => (
            WarningCode::Closure,
            "links lose or add light: ask for a smaller --error",
        ),
        // The other causes have warnings of their own.
        _ => return None,
    };
    Some(Warning {
        code,
        faces: part.faces.clone(),
        message: format!("may be {:.1} % off: {why}", 100.0 * estimate.upper),
    })
}

/// Warns of unshot light: of more than 2 % of the emitted power, and of any that an iteration over links left.
fn warn_of_unshot(mesh: &Mesh, run: &SolveRun, estimate: Option<&ErrorEstimate>) -> Option<Warning> {
    let unshot = 100.0 * run.unshot_fraction();
    let message = if !run.converged && estimate.is_some_and(is_from_steps) {
        let brightest = mesh.texels.iter().map(|texel| texel.reflectance.max_element());
        format!(
            "after {} bounces {unshot:.2} % of the emitted power is unshot, since surfaces reflect up to {:.2} % of their light: lower the reflectances",
            run.passes,
            100.0 * brightest.fold(0.0, f32::max)
        )
    } else if run.unshot_fraction() > WARNING_SHARE {
        format!(
            "{unshot:.1} % of the emitted power is unshot: {}",
            if run.stagnated {
                "conjugate gradients make no more progress: use --conserve, or `solve` in place of `shoot`"
            } else {
                "lower --epsilon or raise --max-shots"
            }
        )
    } else {
        return None;
    };
    Some(Warning {
        code: WarningCode::Unshot,
        faces: Vec::new(),
        message,
    })
}

/// Warns of rounding errors that accumulate between white walls.
fn warn_of_rounding(mesh: &Mesh, run: &SolveRun) -> Option<Warning> {
    let error = rounding_error(mesh, run);
    (error > WARNING_SHARE).then(|| Warning {
        code: WarningCode::Precision,
        faces: Vec::new(),
        message: format!(
            "light is reflected {:.0} times before it is absorbed, and rounding adds up to {:.0} %: lower the reflectances",
            mean_reflections(mesh, run),
            100.0 * error
        ),
    })
}

/// Warns if all samples of all lamps are covered: then nothing is shot.
fn warn_of_covered_lamps(mesh: &Mesh) -> Option<Warning> {
    let shines = |texel: &Texel| texel.emission != Vec3::ZERO;
    let emits = |patch: &&Patch| mesh.texels[patch.texels()].iter().any(shines);
    let mut lamps = mesh.patches.iter().filter(emits).peekable();
    let first = lamps.peek()?.face;
    let mut faces = vec![first];
    for patch in lamps {
        if patch.open_share > 0.0 {
            return None;
        }
        if faces.len() < MAX_NAMED_FACES && !faces.contains(&patch.face) {
            faces.push(patch.face);
        }
    }
    Some(Warning {
        code: WarningCode::Unlit,
        faces,
        message: format!(
            "every lamp lies under other faces at all of its {} samples per patch: move it, or use more --samples",
            mesh.samples
        ),
    })
}

/// Warns if no light is reflected although some lamp faces a reflecting surface: samples and rays may have missed
/// a narrow opening.
fn warn_of_no_light(mesh: &Mesh, run: &SolveRun) -> Option<Warning> {
    let mut texels = mesh.texels.iter().zip(&run.field.radiosity);
    let lit = texels.any(|(texel, b)| b.truncate() != texel.emission);
    (!lit && run.converged && could_reflect(mesh)).then(|| Warning {
        code: WarningCode::Unlit,
        faces: Vec::new(),
        message: "no light was found on any face that reflects: it may come through an opening that no sample meets: use more --patches and --samples"
            .into(),
    })
}

/// Warns of faces bent by rounding, each weighted by the light that leaves it.
fn warn_of_bent_faces(scene: &Scene, mesh: &Mesh, run: &SolveRun) -> Option<Warning> {
    let mut losses = find_shape_losses(scene, mesh, WARNING_SHARE);
    let mut light = vec![0.0f64; mesh.faces.len()];
    for (texel, b) in mesh.texels.iter().zip(&run.field.radiosity) {
        light[texel.face as usize] += f64::from(texel.area * b.truncate().abs().element_sum());
    }
    let all: f64 = light.iter().sum();
    let part = |loss: &ShapeLoss| loss.error.min(1.0) * light[loss.face as usize];
    if losses.iter().map(part).sum::<f64>() <= WARNING_SHARE * all {
        return None;
    }
    losses.sort_by(|a, b| part(b).total_cmp(&part(a)));
    let count = losses.len();
    let of_file = losses.first().is_some_and(|l| l.file_part > 0.5 * l.error);
    let why = if of_file {
        "the file's rounding: keep vertices near their origin and move the node"
    } else {
        "f32's rounding over the scene's extent: make them wider, or the scene smaller"
    };
    losses.truncate(MAX_NAMED_FACES);
    Some(Warning {
        code: WarningCode::Precision,
        faces: losses.into_iter().map(|loss| loss.face).collect(),
        message: format!("{count} faces may have lost their shape to {why}"),
    })
}

/// Returns the faces whose shots missed closure by most power.
fn worst_closure(mesh: &Mesh, run: &SolveRun) -> Vec<u32> {
    let mut lost = vec![0.0f64; mesh.faces.len()];
    for shot in &run.shots {
        let power: f32 = shot.power.iter().map(|p| p.abs()).sum();
        let defect = 1.0 - shot.form_factor_sum - shot.escaped;
        lost[mesh.patches[shot.patch as usize].face as usize] += f64::from((power * defect).abs());
    }
    largest_faces(&lost)
}
