//! What may put an answer more than 2 % off, with the option that mends it.

use super::check::{Cause, Estimate, Evidence, LIMIT, NAMED, Part};
use super::gap::light_in_gaps;
use super::left::{reflections, rounding};
use super::light::could_reflect;
use common::energy::Energy;
use common::mesh::{Cell, Mesh, Texel};
use common::precision::{Loss, losses};
use common::scene::Scene;
use common::shooting::Run;
use common::solution::{Code, Warning};
use glam::Vec3;

/// Beyond this share of the emitted power an effect is worth a warning.
const SHARE: f64 = 0.02;
/// Light shot into gaps was to fall on the few texels around: it is four times as much of the RMS as
/// of the power (a block just above a floor: 0.6 % of the power, 2.6 % RMS).
const IN_GAPS: f64 = 0.25 * SHARE;

/// The warnings of a solve.
pub fn of(scene: &Scene, mesh: &Mesh, run: &Run, estimate: Option<&Estimate>) -> Vec<Warning> {
    let mut warnings: Vec<Warning> = estimate.and_then(off).into_iter().collect();
    warnings.extend(imprecise(scene, mesh, run));
    let closure = closure_in_doubt(mesh, run, estimate);
    if closure.abs() > SHARE {
        warnings.push(Warning {
            code: Code::Closure,
            faces: worst_closure(mesh, run),
            message: format!(
                "the form factors {} {:.1} % of the emitted power: use --form-factor polygon, more --cells or --conserve",
                if closure > 0.0 { "lost" } else { "made up" },
                100.0 * closure.abs()
            ),
        });
    }
    warnings.extend(added_up(mesh, run));
    // To an error, what goes round in a gap does so among parts as small as it needs.
    if !estimate.is_some_and(moved) {
        warnings.extend(narrow(mesh, run));
    }
    warnings.extend(covered(mesh));
    warnings.extend(unlit(mesh, run));
    if run.unshot_fraction() > SHARE {
        warnings.push(Warning {
            code: Code::Unshot,
            faces: Vec::new(),
            message: format!(
                "{:.1} % of the emitted power is unshot: {}",
                100.0 * run.unshot_fraction(),
                if run.stagnated {
                    "conjugate gradients make no more progress: use --conserve, or no option of shooting"
                } else {
                    "lower --epsilon or raise --max-shots"
                }
            ),
        });
    }
    if !mesh.overlaps.is_empty() {
        let mut faces: Vec<u32> = mesh.overlaps.concat();
        faces.sort_unstable();
        faces.dedup();
        faces.truncate(NAMED);
        warnings.push(Warning {
            code: Code::Overlap,
            faces,
            message: format!(
                "{} pairs of fronts lie on each other: only the first of each is lit; remove the other",
                mesh.overlaps.len()
            ),
        });
    }
    warnings
}

/// Whether it comes from two answers.
fn moved(estimate: &Estimate) -> bool {
    matches!(estimate.evidence, Evidence::Moved { .. })
}

/// The share of the emitted power that the form factors lost, or made up where it is negative; 0
/// where the estimate, which counts what later bounces make of it, says that this does not matter: the
/// open share is told by few rays, of whole faces by one point's. But two answers that differ by little know
/// nothing of what both lose, and where nothing escapes no ray is in doubt.
pub fn closure_in_doubt(mesh: &Mesh, run: &Run, estimate: Option<&Estimate>) -> f64 {
    let energy = Energy::new(mesh, &run.field, &run.shots);
    let known = estimate.is_some_and(moved) && energy.escaped == [0.0; 3];
    if !known && estimate.is_some_and(|e| e.upper <= 0.5 * LIMIT) {
        return 0.0;
    }
    energy.share(energy.closure)
}

/// The estimate, by what explains most of it.
fn off(estimate: &Estimate) -> Option<Warning> {
    if estimate.upper <= LIMIT {
        return None;
    }
    if moved(estimate) {
        return refined(estimate);
    }
    let worst = |a: &&Part, b: &&Part| a.error.total_cmp(&b.error);
    let part = estimate.parts.iter().max_by(worst)?;
    let (code, why) = match part.cause {
        Cause::Visibility => (
            Code::Visibility,
            "the item buffer is too coarse: use --visibility rays",
        ),
        Cause::FormFactor => (
            Code::FormFactor,
            "the disc form factor is too crude: use --form-factor polygon",
        ),
        Cause::Cells => (
            Code::Cells,
            "light or shadow varies within cells: use more --cells and --samples, or no option of shooting",
        ),
        Cause::Texels => (
            Code::Texels,
            "light or shadow varies within texels: use more --texels",
        ),
        // They have warnings of their own; the others are of solves to an error.
        _ => return None,
    };
    Some(Warning {
        code,
        faces: part.faces.clone(),
        message: format!("may be {:.1} % off: {why}", 100.0 * estimate.upper),
    })
}

/// An answer to an error of which the refinement leaves most.
fn refined(estimate: &Estimate) -> Option<Warning> {
    // The rest has warnings of its own.
    let (of, rest): (Vec<&Part>, Vec<&Part>) =
        (estimate.parts.iter()).partition(|part| part.cause.of_refinement());
    let square = |part: &&Part| part.error * part.error;
    let most = rest.iter().map(square).fold(0.0, f64::max);
    (of.iter().map(square).sum::<f64>() > most).then(|| Warning {
        code: Code::Texels,
        faces: of[0].faces.clone(),
        message: format!(
            "may be {:.1} % off: the last refinement still changed so much",
            100.0 * estimate.upper
        ),
    })
}

/// Rounding that white walls add up.
fn added_up(mesh: &Mesh, run: &Run) -> Option<Warning> {
    let error = rounding(mesh, run);
    (error > SHARE).then(|| Warning {
        code: Code::Precision,
        faces: Vec::new(),
        message: format!(
            "light is reflected {:.0} times before it is gone, and rounding adds up to {:.0} %: lower the reflectances",
            reflections(mesh, run),
            100.0 * error
        ),
    })
}

/// Gaps that texels are too coarse for.
fn narrow(mesh: &Mesh, run: &Run) -> Option<Warning> {
    let (lost, mut faces) = light_in_gaps(mesh, run);
    faces.truncate(NAMED);
    (lost > IN_GAPS).then(|| Warning {
        code: Code::Gap,
        faces,
        message: format!(
            "{:.1} % of the reflected light is shot into gaps narrower than a tenth of a texel, which are dark in truth: use more --texels",
            100.0 * lost
        ),
    })
}

/// Lamps of which no sample is free: then nothing at all is shot.
fn covered(mesh: &Mesh) -> Option<Warning> {
    let shines = |texel: &Texel| texel.emission != Vec3::ZERO;
    let emits = |cell: &&Cell| mesh.texels[cell.texels()].iter().any(shines);
    let mut lamps = mesh.cells.iter().filter(emits).peekable();
    let first = lamps.peek()?.face;
    let mut faces = vec![first];
    for cell in lamps {
        if cell.open > 0.0 {
            return None;
        }
        if faces.len() < NAMED && !faces.contains(&cell.face) {
            faces.push(cell.face);
        }
    }
    Some(Warning {
        code: Code::Covered,
        faces,
        message: format!(
            "every lamp lies under other faces at all of its {} samples per cell: move it, or use more --samples",
            mesh.samples
        ),
    })
}

/// Light of which nothing is reflected, where some could be: no sample may have met the chink that it
/// comes through, nor any of the rays that looked.
fn unlit(mesh: &Mesh, run: &Run) -> Option<Warning> {
    let mut texels = mesh.texels.iter().zip(&run.field.radiosity);
    let lit = texels.any(|(texel, b)| b.truncate() != texel.emission);
    (!lit && run.converged && could_reflect(mesh)).then(|| Warning {
        code: Code::Unlit,
        faces: Vec::new(),
        message: "no light was found on any face that reflects: it may come through a chink that no sample meets: use more --cells and --samples"
            .into(),
    })
}

/// Faces that rounding has bent, where they matter: each weighs by the light that leaves it.
fn imprecise(scene: &Scene, mesh: &Mesh, run: &Run) -> Option<Warning> {
    let mut losses = losses(scene, mesh, SHARE);
    let mut light = vec![0.0f64; mesh.faces.len()];
    for (texel, b) in mesh.texels.iter().zip(&run.field.radiosity) {
        light[texel.face as usize] += f64::from(texel.area * b.truncate().abs().element_sum());
    }
    let all: f64 = light.iter().sum();
    let part = |loss: &Loss| loss.error.min(1.0) * light[loss.face as usize];
    if losses.iter().map(part).sum::<f64>() <= SHARE * all {
        return None;
    }
    losses.sort_by(|a, b| part(b).total_cmp(&part(a)));
    let count = losses.len();
    let of_file = losses.first().is_some_and(|l| l.of_file > 0.5 * l.error);
    let why = if of_file {
        "the file's rounding: keep vertices near their origin and move the node"
    } else {
        "f32's rounding over the scene's extent: make them wider, or the scene smaller"
    };
    losses.truncate(NAMED);
    Some(Warning {
        code: Code::Precision,
        faces: losses.into_iter().map(|loss| loss.face).collect(),
        message: format!("{count} faces may have lost their shape to {why}"),
    })
}

/// The faces whose shots missed closure by most power.
fn worst_closure(mesh: &Mesh, run: &Run) -> Vec<u32> {
    let mut lost = vec![0.0f64; mesh.faces.len()];
    for shot in &run.shots {
        let power: f32 = shot.power.iter().map(|p| p.abs()).sum();
        let defect = 1.0 - shot.form_factor_sum - shot.escaped;
        lost[mesh.cells[shot.cell as usize].face as usize] += f64::from((power * defect).abs());
    }
    let mut order: Vec<u32> = (0..lost.len() as u32)
        .filter(|k| lost[*k as usize] > 0.0)
        .collect();
    order.sort_by(|a, b| lost[*b as usize].total_cmp(&lost[*a as usize]));
    order.truncate(NAMED);
    order
}
