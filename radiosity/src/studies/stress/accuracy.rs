//! Error of an answer against the truth.
//!
//! ```text
//! relative RMS = √(ΣA(a − b)² / ΣA b²), worst channel      leak = ΣA|a| / ΣA E
//! ```
//! a, b: B − E of the answer and of the truth over the judged texels. The noise of a traced truth is
//! subtracted.

use super::trial::{Trial, TrialTruth};
use common::texel::{texel_count, texel_outline};
use glam::DVec3;
use oracle::diff::difference::{Difference, channel_differences, worst_channel};
use oracle::path_tracer::debiased_rms;

/// Returns the error and its standard error, which is 0 unless the truth is traced. Errors: the
/// answer cannot be compared.
pub fn error_and_noise(trial: &Trial, answer: &[DVec3], truth: &[DVec3]) -> Result<(f64, f64), String> {
    if answer.len() != truth.len() {
        return Err(format!("{} texels instead of {}", answer.len(), truth.len()));
    }
    if !answer.iter().chain(truth).all(|v| v.is_finite()) {
        return Err("some texels are not finite".into());
    }
    let lit = truth.iter().any(|v| *v != DVec3::ZERO);
    // Only a constant truth may be met exactly; otherwise the answer is the truth itself.
    if lit && !matches!(trial.truth, TrialTruth::Constant(_)) && answer == truth {
        return Err("the truth itself, bit for bit".into());
    }
    let (error, noise) = match &trial.truth {
        TrialTruth::Dark => (leaked_share(trial, answer), 0.0),
        TrialTruth::Traced(_, error) => debiased_rms(&judged_areas(trial), answer, truth, error).into(),
        _ => (worst_difference(trial, answer, truth).relative_rms, 0.0),
    };
    match (error.is_finite() && noise.is_finite(), &trial.truth) {
        (true, _) => Ok((error, noise)),
        (false, TrialTruth::Traced(..)) => Err("the truth is all noise".into()),
        (false, _) => Err("lit, but the truth is all black".into()),
    }
}

/// Returns ΣA(a − b)/ΣA b of the worst channel; none for leaks or a black truth.
pub fn worst_bias(trial: &Trial, answer: &[DVec3], truth: &[DVec3]) -> Option<f64> {
    let worst = worst_difference(trial, answer, truth).bias;
    (worst.is_finite() && !matches!(trial.truth, TrialTruth::Dark)).then_some(worst)
}

/// Compares the judged texels; worst channel.
fn worst_difference(trial: &Trial, answer: &[DVec3], truth: &[DVec3]) -> Difference {
    let all = judged_areas(trial).into_iter().zip(answer).zip(truth);
    let judged = all.filter(|((area, _), _)| *area > 0.0);
    worst_channel(channel_differences(judged.map(|((area, a), b)| (area, *a, *b))))
}

/// Returns the area of each texel, 0 if it is not judged.
fn judged_areas(trial: &Trial) -> Vec<f64> {
    let resolution = [trial.texels; 2];
    let texels = |(k, face)| {
        let judged = trial.judged.contains(&k);
        let area = move |t| {
            if judged {
                texel_outline(face, resolution, t).area()
            } else {
                0.0
            }
        };
        (0..texel_count(resolution)).map(area)
    };
    trial.scene.faces.iter().enumerate().flat_map(texels).collect()
}

fn leaked_share(trial: &Trial, answer: &[DVec3]) -> f64 {
    let behind = judged_areas(trial).into_iter().zip(answer);
    let behind: f64 = behind.map(|(a, v)| a * v.abs().element_sum()).sum();
    let faces = trial.scene.faces.iter();
    let emitted: f64 = faces.map(|f| f.area() * f.emission.as_dvec3().element_sum()).sum();
    if behind == 0.0 { 0.0 } else { behind / emitted }
}
