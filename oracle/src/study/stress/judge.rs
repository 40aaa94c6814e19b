//! How far an answer is from the truth.
//!
//! ```text
//! relative RMS = √(ΣA(a − b)² / ΣA b²), worst channel      leak = ΣA|a| / ΣA E
//! ```
//! a, b: B − E of the answer and of the truth over the texels that are judged. Of a traced truth its own
//! noise is taken off.

use super::trial::{Trial, Truth};
use crate::judge::compare::difference::{channels, worst};
use crate::judge::comparison::Difference;
use crate::judge::path_tracer::debiased;
use common::texel::{count, outline};
use glam::DVec3;

/// The error and, where the truth is traced, its standard error; or why there is none.
pub fn error(trial: &Trial, answer: &[DVec3], truth: &[DVec3]) -> Result<(f64, f64), String> {
    if answer.len() != truth.len() {
        return Err(format!(
            "{} texels instead of {}",
            answer.len(),
            truth.len()
        ));
    }
    if !answer.iter().chain(truth).all(|v| v.is_finite()) {
        return Err("some texels are not finite".into());
    }
    let lit = |values: &[DVec3]| values.iter().any(|v| *v != DVec3::ZERO);
    // A number known beforehand may be met exactly; another answer may not.
    let known = matches!(trial.truth, Truth::Constant(_));
    if lit(truth) && !known && answer == truth {
        return Err("the truth itself, bit for bit".into());
    }
    if matches!(trial.truth, Truth::Dark) {
        return Ok((leak(trial, answer), 0.0));
    }
    if let Truth::Traced(_, error) = &trial.truth {
        let [rms, noise] = debiased(&areas(trial), answer, truth, error);
        let known = rms.is_finite() && noise.is_finite();
        return known
            .then_some((rms, noise))
            .ok_or_else(|| "the truth is all noise".into());
    }
    let worst = worst_of(trial, answer, truth).relative_rms;
    if worst.is_finite() {
        Ok((worst, 0.0))
    } else {
        Err("lit where the truth is black all over".into())
    }
}

/// ΣA(a − b)/ΣA b, the worst channel; none of leaks, nor where the truth is black.
pub fn bias(trial: &Trial, answer: &[DVec3], truth: &[DVec3]) -> Option<f64> {
    let worst = worst_of(trial, answer, truth).bias;
    (worst.is_finite() && !matches!(trial.truth, Truth::Dark)).then_some(worst)
}

/// The worst channel over the texels that are judged.
fn worst_of(trial: &Trial, answer: &[DVec3], truth: &[DVec3]) -> Difference {
    let all = areas(trial).into_iter().zip(answer).zip(truth);
    let judged = all.filter(|((area, _), _)| *area > 0.0);
    worst(channels(judged.map(|((area, a), b)| (area, *a, *b))))
}

/// The area of each texel, 0 where it is not judged.
pub fn areas(trial: &Trial) -> Vec<f64> {
    let resolution = [trial.texels; 2];
    let of = |(k, face)| {
        let judged = trial.judges(k);
        (0..count(resolution)).map(move |t| {
            if judged {
                outline(face, resolution, t).area()
            } else {
                0.0
            }
        })
    };
    trial.scene.faces.iter().enumerate().flat_map(of).collect()
}

fn leak(trial: &Trial, answer: &[DVec3]) -> f64 {
    let behind = areas(trial).into_iter().zip(answer);
    let behind: f64 = behind.map(|(a, v)| a * v.abs().element_sum()).sum();
    let faces = trial.scene.faces.iter();
    let emitted: f64 = faces
        .map(|f| f.area() * f.emission.as_dvec3().element_sum())
        .sum();
    if behind == 0.0 { 0.0 } else { behind / emitted }
}
