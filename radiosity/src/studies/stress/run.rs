//! Runs a case: every value, every method, CPU and GPU.

use super::accuracy;
use super::cases::Case;
use super::methods::{AtlasMethod, MethodSolver};
use super::trial::Trial;
use super::truth::TruthCache;
use super::{AtlasRow, CaseStudy, NOT_COMPARABLE, Plate, Processor, SolverSide, Specimen};
use common::Result;
use common::mesh::Mesh;
use common::shooting::RadiosityField;
use common::texel::texel_count;
use glam::DVec3;
use gpu::Gpu;
use oracle::diff::reflected::ReflectedField;
use oracle::relight::stage::RelightStage;
use oracle::relight::task::RelightTask;
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::solved::Solved;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::{SolveAnswer, SolveRequest, solve_request};
use std::any::Any;
use std::cell::Cell;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// An answer with the name of its method and processor.
type LabelledAnswer = (String, TrialAnswer);

/// Time limit of a solve, seconds: ten times the longest solve, so that load on the machine does not
/// change a verdict.
const MAX_SOLVE_SECONDS: f64 = 200.0;
/// Multiple of the failing limit beyond which errors look alike.
const MAX_VISIBLE_FAILURE: f64 = 10.0;

/// GPU and interruption of a run.
pub struct AtlasRun<'a> {
    /// The GPU, if there is one.
    pub gpu: Option<&'a Gpu>,
    /// Returns true when the run is to stop.
    pub stop: &'a dyn Fn() -> bool,
}

/// A solution, kept for the pictures.
pub struct TrialAnswer {
    mesh: Mesh,
    field: RadiosityField,
    /// B − E of each texel in face order, W/m².
    values: Vec<DVec3>,
}

impl AtlasRun<'_> {
    /// Runs a case. After a stop, rows of later values are missing. Errors: a scene or a truth fails.
    pub fn run_case(&self, case: &Case, watch: &ProgressMonitor) -> Result<CaseStudy> {
        self.run_values(case, case.values, case.build, 1, watch)
    }

    /// Runs a case at these values of scenes from `build`, and keeps at most `max_specimens`.
    pub fn run_values(
        &self,
        case: &Case,
        values: &[f64],
        build: impl Fn(f64) -> Result<Trial>,
        max_specimens: usize,
        watch: &ProgressMonitor,
    ) -> Result<CaseStudy> {
        let (mut rows, mut specimens) = (Vec::new(), Vec::new());
        let mut truths = TruthCache::default();
        for (done, value) in values.iter().enumerate() {
            // The methods poll `stop` themselves.
            let _ = watch.report_count(case.parameter, done as u64, values.len() as u64);
            if (self.stop)() {
                break;
            }
            let trial = build(*value)?;
            let truth = truths.truth_of(&trial)?;
            let Some((found, answers)) = self.run_methods(case, *value, &trial, &truth) else {
                break;
            };
            let visible = failure_visibility(case, &found);
            specimens.extend(make_specimen(trial, *value, &truth, answers).map(|specimen| (visible, specimen)));
            specimens.sort_by(|(a, _), (b, _)| b.total_cmp(a));
            specimens.truncate(max_specimens);
            rows.extend(found);
        }
        Ok(CaseStudy {
            case: *case,
            rows,
            specimens: specimens.into_iter().map(|(_, specimen)| specimen).collect(),
        })
    }

    /// Runs all methods on one trial and returns rows and labelled answers; none after a stop.
    fn run_methods(
        &self,
        case: &Case,
        value: f64,
        trial: &Trial,
        truth: &[DVec3],
    ) -> Option<(Vec<AtlasRow>, Vec<LabelledAnswer>)> {
        let (mut rows, mut answers) = (Vec::new(), Vec::new());
        for method in case.methods {
            let mut run = |processor: Processor, gpu| {
                let (side, answer) = run_method(trial, method, gpu, truth, self.stop)?;
                answers.extend(answer.map(|answer| (format!("{} {}", method.name, processor.name()), answer)));
                Some(side)
            };
            let cpu = run(Processor::Cpu, None)?;
            let gpu = match self.gpu.filter(|_| method.solver != MethodSolver::Dense) {
                None => None,
                gpu => Some(run(Processor::Gpu, gpu)?),
            };
            rows.push(AtlasRow {
                scene: trial.description.clone(),
                ..AtlasRow::new(case, value, method.name, cpu, gpu)
            });
        }
        Some((rows, answers))
    }
}

/// Returns how visible the failures are at one value: the sum of all errors in units of the failing limit.
/// The default's, of the first row, weighs as much as all others together; a refusal has no picture.
fn failure_visibility(case: &Case, rows: &[AtlasRow]) -> f64 {
    let [_, fails] = case.measure.limits();
    let beyond = |side: &SolverSide| match side.error {
        Some(error) if error.is_nan() => MAX_VISIBLE_FAILURE,
        Some(error) => (error / fails).min(MAX_VISIBLE_FAILURE),
        None => 0.0,
    };
    let weight = |k: usize| if k == 0 { rows.len() as f64 } else { 1.0 };
    let visible = |(k, row): (usize, &AtlasRow)| weight(k) * row.sides().map(|(_, side)| beyond(side)).sum::<f64>();
    rows.iter().enumerate().map(visible).sum()
}

/// Makes the specimen of the judged face with the greatest error of the first answer, the default's, and of
/// all others, together of equal weight.
fn make_specimen(trial: Trial, value: f64, truth: &[DVec3], answers: Vec<(String, TrialAnswer)>) -> Option<Specimen> {
    let per_face = texel_count([trial.texels; 2]) as usize;
    let part = |values: &[DVec3], face: usize| -> Vec<DVec3> {
        let range = face * per_face..(face + 1) * per_face;
        values.get(range).unwrap_or_default().to_vec()
    };
    let rank = |face: usize| -> f64 {
        let squared_error = |(k, (_, answer)): (usize, &(String, TrialAnswer))| -> f64 {
            let pairs = part(&answer.values, face).into_iter().zip(part(truth, face));
            let sum: f64 = pairs.map(|(a, b)| (a - b).length_squared()).sum();
            if k == 0 { sum * answers.len() as f64 } else { sum }
        };
        trial.scene.faces[face].area() * answers.iter().enumerate().map(squared_error).sum::<f64>()
    };
    let face = trial.judged.clone().max_by(|a, b| rank(*a).total_cmp(&rank(*b)))?;
    let plate = |label: &str, values: &[DVec3]| Plate {
        label: label.to_owned(),
        values: part(values, face),
    };
    let shown = answers.iter().map(|(label, answer)| plate(label, &answer.values));
    let plates = [plate("truth", truth)].into_iter().chain(shown).collect();
    let (_, shown) = answers.into_iter().next()?;
    Some(Specimen {
        value,
        description: trial.description,
        scene: trial.scene,
        mesh: shown.mesh,
        field: shown.field,
        face: face as u32,
        texels: trial.texels,
        plates,
    })
}

/// Runs a method on a trial and returns its part of the row, unjudged, with the solution, if there is one;
/// none if `stop` returned true.
pub fn run_method(
    trial: &Trial,
    method: &AtlasMethod,
    gpu: Option<&Gpu>,
    truth: &[DVec3],
    stop: &dyn Fn() -> bool,
) -> Option<(SolverSide, Option<TrialAnswer>)> {
    let start = Instant::now();
    let late = Cell::new(false);
    let progress = |_: &str, _| {
        late.set(late.get() || start.elapsed().as_secs_f64() > MAX_SOLVE_SECONDS);
        match late.get() || stop() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    };
    let watch = ProgressMonitor::new(&progress);
    let solved = catch_panic(|| solve_trial(trial, method, gpu, &watch));
    let mut side = SolverSide {
        seconds: start.elapsed().as_secs_f64(),
        ..SolverSide::default()
    };
    if stop() {
        return None;
    }
    let answer = match solved {
        _ if late.get() => Err(format!("took longer than {MAX_SOLVE_SECONDS} s")),
        other => other,
    };
    let answer = match answer {
        Ok(answer) => answer,
        Err(message) => {
            side.message = Some(message);
            return Some((side, None));
        }
    };
    side.warnings = answer.warnings.iter().map(|w| w.code.as_str().into()).collect();
    side.notes = answer.notes;
    side.estimate = answer.estimate.map(|estimate| estimate.error);
    let Solved { mesh, run, .. } = answer.solved;
    let values = ReflectedField::from_field(&trial.scene, &mesh, &run.field).values;
    match accuracy::error_and_noise(trial, &values, truth) {
        Ok((error, noise)) => {
            (side.error, side.noise) = (Some(error), noise);
            side.bias = accuracy::worst_bias(trial, &values, truth);
        }
        Err(message) => side.message = Some(format!("{NOT_COMPARABLE}: {message}")),
    }
    let field = run.field;
    Some((side, Some(TrialAnswer { mesh, field, values })))
}

/// Solves and returns a panic as an error, so that the atlas continues.
fn catch_panic(solve: impl FnOnce() -> Result<SolveAnswer>) -> std::result::Result<SolveAnswer, String> {
    match catch_unwind(AssertUnwindSafe(solve)) {
        Ok(result) => result.map_err(|error| error.to_string()),
        Err(payload) => Err(format!("panic: {}", panic_text(payload.as_ref()))),
    }
}

fn panic_text(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| payload.downcast_ref::<&str>().copied())
        .unwrap_or("without a message")
}

fn solve_trial(trial: &Trial, method: &AtlasMethod, gpu: Option<&Gpu>, watch: &ProgressMonitor) -> Result<SolveAnswer> {
    let settings = &method.settings_on(trial.texels, gpu.is_some());
    let texels = Some(trial.texels);
    let solver = match method.solver {
        MethodSolver::ToError(error) => SolverChoice::to_error(gpu, ErrorTarget { error, texels }),
        MethodSolver::Shooting => SolverChoice::shooting_on(gpu),
        MethodSolver::Dense => SolverChoice::Dense,
    };
    if trial.room == 0 {
        let task = &trial.scene;
        return solve_request(&SolveRequest { task, settings, solver }, watch);
    }
    let stage = &RelightStage::new(&trial.scene, trial.room, trial.texels);
    let method = method.relighting;
    let task = &RelightTask { stage, method };
    solve_request(&SolveRequest { task, settings, solver }, watch)
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{TEST_CASE, make_row, make_side};
    use super::*;

    fn visibility_of(default: Option<f64>, other: Option<f64>) -> f64 {
        let rows = [default, other, other].map(|error| make_row(1.0, make_side(error, ""), None));
        failure_visibility(&TEST_CASE, &rows)
    }

    #[test]
    fn most_visible_failure_ranks_first() {
        let of = |default, other| visibility_of(Some(default), Some(other));
        // Half of the methods break early, but the visible failure comes later.
        assert!(of(0.01, 0.5) > of(0.01, 0.03));
        assert!(of(0.05, 0.5) > of(0.01, 0.5));
        assert!(of(0.3, 0.01) > of(0.01, 0.3));
        // NaN ranks like the greatest error.
        assert_eq!(of(0.01, f64::NAN), of(0.01, 1e9));
        assert_eq!(visibility_of(None, None), 0.0);
    }
}
