//! Runs a case: every value, every method, CPU and GPU.

use super::measure::{TrialAnswer, TrialResult, run_method};
use super::methods::{self, AtlasMethod, DEFAULT_METHOD};
use super::outcome::solver_sides;
use super::trial::{Case, Trial};
use super::truth::TruthCache;
use super::{AtlasRow, CaseStudy, Plate, SolverSide, Specimen, Verdict, error_limits};
use common::Result;
use common::texel::texel_count;
use glam::DVec3;
use gpu::Gpu;
use oracle::solve::progress::ProgressMonitor;

/// Multiple of the failing limit beyond which errors look alike.
const MAX_VISIBLE_FAILURE: f64 = 10.0;

/// GPU and interruption of a run.
pub struct AtlasRun<'a> {
    /// The GPU, if there is one.
    pub gpu: Option<&'a Gpu>,
    /// Returns true when the run is to stop.
    pub stop: &'a dyn Fn() -> bool,
}

impl AtlasRun<'_> {
    /// Runs a case. After a stop, rows of later values are missing. Errors: a scene or a truth fails.
    pub fn run_case(&self, case: &Case, watch: &ProgressMonitor) -> Result<CaseStudy> {
        let mut study = CaseStudy {
            info: case.info,
            rows: Vec::new(),
            specimen: None,
        };
        let (mut worst, mut truths) = (f64::NEG_INFINITY, TruthCache::default());
        for (done, value) in case.values.iter().enumerate() {
            // The methods poll `stop` themselves.
            let _ = watch.report_count(case.info.parameter, done as u64, case.values.len() as u64);
            let Some((rows, specimen)) = self.run_value(case, *value, &mut truths)? else {
                break;
            };
            let here = failure_visibility(case.info.measure, &rows);
            if specimen.is_some() && here > worst {
                (study.specimen, worst) = (specimen, here);
            }
            study.rows.extend(rows);
        }
        Ok(study)
    }

    /// Runs all methods at one value; none after a stop.
    fn run_value(
        &self,
        case: &Case,
        value: f64,
        truths: &mut TruthCache,
    ) -> Result<Option<(Vec<AtlasRow>, Option<Specimen>)>> {
        let trial = (case.build)(value)?;
        let empty = trial.scene.faces.is_empty();
        let truth = if empty { Vec::new() } else { truths.truth_of(&trial)? };
        Ok(self.run_trial(case, value, trial, &truth))
    }

    /// Runs all methods on one trial with a known truth; none after a stop.
    pub fn run_trial(
        &self,
        case: &Case,
        value: f64,
        trial: Trial,
        truth: &[DVec3],
    ) -> Option<(Vec<AtlasRow>, Option<Specimen>)> {
        let mut rows = Vec::new();
        let mut gallery = Gallery::default();
        for method in methods::methods_of(trial.suite) {
            let cpu = run_method(&trial, &method, None, truth, self.stop)?;
            let gpu = match self.gpu.filter(|_| method.runs_on_gpu()) {
                None => None,
                gpu => Some(run_method(&trial, &method, gpu, truth, self.stop)?),
            };
            let sides = (cpu.side.clone(), gpu.as_ref().map(|t| t.side.clone()));
            rows.push(make_row(case, value, &method, sides));
            gallery.keep_answer(&method, "CPU", cpu);
            if let Some(gpu) = gpu {
                gallery.keep_answer(&method, "GPU", gpu);
            }
        }
        let is_safe = |row: &AtlasRow| row.method != DEFAULT_METHOD || row.verdict == Verdict::Safe;
        let safe = rows.iter().all(is_safe);
        let specimen = gallery.make_specimen(trial, value, truth, safe);
        Some((rows, specimen))
    }
}

/// Returns how visible the failures are at one value: the sum of ln(error / safe limit) over the
/// answers. The default's weighs as much as all others together; a refusal has no picture. The value
/// with the greatest sum becomes the specimen.
fn failure_visibility(measure: &str, rows: &[AtlasRow]) -> f64 {
    let [safe, fails] = error_limits(measure);
    let beyond = |side: &SolverSide| match side.error {
        Some(error) if error.is_finite() => (error / safe).clamp(1.0, MAX_VISIBLE_FAILURE * fails / safe).ln(),
        Some(_) => (MAX_VISIBLE_FAILURE * fails / safe).ln(),
        None => 0.0,
    };
    let row_visibility = |row: &AtlasRow| solver_sides(row).map(|(_, side)| beyond(side)).sum::<f64>();
    let weight = |row: &AtlasRow| {
        if row.method == DEFAULT_METHOD {
            rows.len() as f64
        } else {
            1.0
        }
    };
    rows.iter().map(|row| weight(row) * row_visibility(row)).sum()
}

/// Makes a row from both solvers' results; the worse one sets error, warning and verdict.
pub fn make_row(
    case: &Case,
    value: f64,
    method: &AtlasMethod,
    (cpu, gpu): (SolverSide, Option<SolverSide>),
) -> AtlasRow {
    let judged = |side: SolverSide| SolverSide {
        verdict: Verdict::of_error(case.info.measure, side.error),
        ..side
    };
    let (cpu, gpu) = (judged(cpu), gpu.map(judged));
    let rank = |side: &SolverSide| side.error.unwrap_or(f64::INFINITY);
    let worse = gpu.as_ref().filter(|g| rank(g) > rank(&cpu)).unwrap_or(&cpu);
    AtlasRow {
        case: case.info.name,
        parameter: case.info.parameter,
        value,
        method: method.name,
        error: worse.error,
        warned: worse.is_warned(),
        verdict: worse.verdict,
        cpu,
        gpu,
    }
}

/// The answers at one value, by method and solver.
#[derive(Default)]
struct Gallery {
    answers: Vec<(String, TrialAnswer)>,
}

impl Gallery {
    fn keep_answer(&mut self, method: &AtlasMethod, solver: &str, tried: TrialResult) {
        if let Some(answer) = tried.answer {
            self.answers.push((format!("{} {solver}", method.name), answer));
        }
    }

    /// Makes the specimen of the face with the greatest error: the default's error, or that of all
    /// answers together if the default is safe.
    fn make_specimen(self, trial: Trial, value: f64, truth: &[DVec3], safe: bool) -> Option<Specimen> {
        let shown = self
            .answers
            .iter()
            .find(|(label, _)| label.starts_with(DEFAULT_METHOD))
            .or(self.answers.first())?;
        let per_face = texel_count([trial.texels; 2]) as usize;
        let part = |values: &[DVec3], face: usize| -> Vec<DVec3> {
            let range = face * per_face..(face + 1) * per_face;
            values.get(range).unwrap_or_default().to_vec()
        };
        let squared_error = |seen: &TrialAnswer, face: usize| -> f64 {
            let pairs = part(&seen.values, face).into_iter();
            let error = pairs.zip(part(truth, face));
            let square: f64 = error.map(|(a, b)| (a - b).length_squared()).sum();
            square * trial.scene.faces[face].area()
        };
        let judged: Vec<usize> = (0..trial.scene.faces.len()).filter(|k| trial.is_judged(*k)).collect();
        let rank: Vec<f64> = if safe {
            let all = |k: &usize| self.answers.iter().map(|(_, seen)| squared_error(seen, *k)).sum();
            judged.iter().map(all).collect()
        } else {
            judged.iter().map(|k| squared_error(&shown.1, *k)).collect()
        };
        let worst = (0..judged.len()).max_by(|a, b| rank[*a].total_cmp(&rank[*b]))?;
        let face = judged[worst];
        let plate = |label: &str, values: &[DVec3]| Plate {
            label: label.to_owned(),
            resolution: [trial.texels; 2],
            values: part(values, face),
        };
        let mut plates = vec![plate("truth", truth)];
        plates.extend(self.answers.iter().map(|(l, seen)| plate(l, &seen.values)));
        let (mesh, field) = (shown.1.mesh.clone(), shown.1.field.clone());
        Some(Specimen {
            value,
            scene: trial.scene,
            mesh,
            field,
            face: face as u32,
            plates,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{make_row, make_side};
    use super::super::{LEAK_MEASURE, RELATIVE_RMS};
    use super::*;

    fn failure_of(default: f64, other: f64) -> f64 {
        let mut rows = vec![make_row(1.0, make_side(Some(default), ""), None); 3];
        for (row, error) in rows[1..].iter_mut().zip([other; 2]) {
            row.method = "matrix";
            row.cpu = make_side(Some(error), "");
        }
        failure_visibility(RELATIVE_RMS, &rows)
    }

    #[test]
    fn most_visible_failure_ranks_first() {
        // Half of the methods break early, but the visible failure comes later.
        assert!(failure_of(0.01, 0.5) > failure_of(0.01, 0.03));
        assert!(failure_of(0.05, 0.5) > failure_of(0.01, 0.5));
        assert!(failure_of(0.3, 0.01) > failure_of(0.01, 0.3));
        assert_eq!(failure_of(0.01, 0.02), 0.0);
        // NaN ranks like the greatest error.
        assert_eq!(failure_of(0.01, f64::NAN), failure_of(0.01, 1e9));
        let refused = [make_row(1.0, make_side(None, ""), None)];
        assert_eq!(failure_visibility(RELATIVE_RMS, &refused), 0.0);
        let tight = [make_row(1.0, make_side(Some(0.0), ""), None)];
        assert_eq!(failure_visibility(LEAK_MEASURE, &tight), 0.0);
    }
}
