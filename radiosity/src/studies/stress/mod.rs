//! The failure atlas: families of scenes that are each built to break one method, over decades of
//! one parameter. It shows the value at which each method breaks and whether the program warns.
//!
//! The result compared is the mean reflected radiosity B − E of every texel; for leaks it is the
//! light behind a wall over the emitted power.
//!
//! [`cases`] builds the scenes and [`random`] draws others, [`trial`] provides their
//! solutions and compares answers with them, [`methods`] lists the methods, [`run`] runs them;
//! [`summary`] evaluates the rows, [`page`] shows them.

pub mod cases;
pub mod methods;
#[cfg(not(target_arch = "wasm32"))]
pub mod page;
#[cfg(not(target_arch = "wasm32"))]
pub mod random;
#[cfg(not(target_arch = "wasm32"))]
pub mod run;
#[cfg(not(target_arch = "wasm32"))]
pub mod summary;
pub mod trial;

use crate::report::format::{format_number, format_percent};
use cases::Case;
use common::mesh::Mesh;
use common::scene::Scene;
use common::shooting::RadiosityField;
use oracle::solve::solver::SolverKind;
use serde::Serialize;

/// Start of the message of an answer that cannot be compared.
const NOT_COMPARABLE: &str = "not comparable";
/// Starts of the messages of solves that broke.
const BROKEN_MESSAGES: [&str; 4] = ["panic", "not a number", "took longer", NOT_COMPARABLE];
/// Half-width of the confidence interval of an error, standard errors of the traced truth.
const CONFIDENCE_SIGMAS: f64 = 2.0;

/// Measure of an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ErrorMeasure {
    /// RMS error of B − E over the RMS of the truth, worst channel.
    RelativeRms,
    /// Power reflected behind a wall over the emitted power.
    Leak,
}

impl ErrorMeasure {
    /// Returns its name on the page.
    pub fn name(self) -> &'static str {
        match self {
            Self::RelativeRms => "relative RMS",
            Self::Leak => "light behind the wall / emitted power",
        }
    }

    /// Returns the largest errors of a safe result, which needs no warning, and of a degraded one. A safe
    /// leak is a few roundings of the sum, one beyond the second limit is visible.
    pub fn limits(self) -> [f64; 2] {
        match self {
            Self::RelativeRms => [0.02, 0.1],
            Self::Leak => [1e-6, 1e-4],
        }
    }

    /// Returns the verdict on an error; NaN fails.
    pub fn verdict_on(self, error: Option<f64>) -> Verdict {
        let [safe, degraded] = self.limits();
        match error {
            Some(error) if error <= safe => Verdict::Safe,
            Some(error) if error <= degraded => Verdict::Degrades,
            _ => Verdict::Fails,
        }
    }

    /// Formats an error: a relative RMS in per cent, a leak as a number.
    pub fn format_error(self, error: f64) -> String {
        match self {
            Self::RelativeRms => format_percent(error),
            Self::Leak => format_number(error),
        }
    }
}

/// Verdict on a result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Error within the first limit.
    Safe,
    /// Error within the second limit.
    Degrades,
    /// Greater error, NaN, or no answer.
    #[default]
    Fails,
}

/// Combination of error and warning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum WarningOutcome {
    /// Beyond the limit, with a warning.
    Caught,
    /// Beyond the limit, without a warning.
    #[default]
    Missed,
    /// Safe, with a warning.
    FalseAlarm,
    /// Safe, without a warning, or a leak, whose warning may concern the light elsewhere.
    Quiet,
}

/// One solver's result in a row.
#[derive(Clone, Debug, Default, Serialize)]
pub struct SolverSide {
    /// Error against the truth; none without an answer.
    pub error: Option<f64>,
    /// Standard error of the error, if the truth is traced.
    pub noise: f64,
    /// Error estimate of the answer, if it has one.
    pub estimate: Option<f64>,
    /// Verdict on the error.
    pub verdict: Verdict,
    /// Verdict on the warnings.
    pub outcome: WarningOutcome,
    /// Codes of the warnings.
    pub warnings: Vec<String>,
    /// Notes of the solve, such as settings that it changed.
    pub notes: Vec<String>,
    /// Error message, if there is no answer.
    pub message: Option<String>,
    /// Wall-clock seconds.
    pub seconds: f64,
}

impl SolverSide {
    /// Returns whether the user learns of a problem: by a warning or by a refusal.
    pub fn is_warned(&self) -> bool {
        !self.warnings.is_empty() || self.error.is_none() && !self.is_broken()
    }

    /// Returns whether the solve panicked, hung, returned NaN or gave neither answer nor message.
    pub fn is_broken(&self) -> bool {
        match (&self.message, self.error) {
            (Some(message), _) => BROKEN_MESSAGES.iter().any(|start| message.starts_with(start)),
            (None, error) => !error.is_some_and(f64::is_finite),
        }
    }

    /// Sets both verdicts. Within the truth's noise the warning decides whether the error is beyond the limit.
    fn judged_by(self, measure: ErrorMeasure) -> Self {
        let warned = self.is_warned();
        let doubt = if warned { self.noise } else { -self.noise };
        let doubted = self.error.map(|error| error + CONFIDENCE_SIGMAS * doubt);
        let safe = measure.verdict_on(doubted) == Verdict::Safe;
        Self {
            verdict: measure.verdict_on(self.error),
            outcome: match (safe, warned) {
                (false, true) => WarningOutcome::Caught,
                (false, false) => WarningOutcome::Missed,
                (true, true) if measure != ErrorMeasure::Leak => WarningOutcome::FalseAlarm,
                (true, _) => WarningOutcome::Quiet,
            },
            ..self
        }
    }

    /// Formats its error.
    #[cfg(not(target_arch = "wasm32"))]
    fn format_error(&self, measure: ErrorMeasure) -> String {
        match self.error {
            Some(error) => measure.format_error(error),
            None if self.is_broken() => "nothing".into(),
            None => "refused".into(),
        }
    }
}

/// Results of one method at one value, on CPU and GPU.
#[derive(Clone, Debug, Serialize)]
pub struct AtlasRow {
    /// Name of the case.
    pub case: &'static str,
    /// Swept parameter.
    pub parameter: &'static str,
    /// Value of the parameter.
    pub value: f64,
    /// Name of the method.
    pub method: &'static str,
    /// The worse error of the two; none if either has no answer.
    pub error: Option<f64>,
    /// True if the worse result was warned about or refused.
    pub warned: bool,
    /// Verdict on the worse result.
    pub verdict: Verdict,
    /// Result on the CPU.
    pub cpu: SolverSide,
    /// Result on the GPU; none for the dense solver or without an adapter.
    pub gpu: Option<SolverSide>,
    /// Description of a random scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scene: Option<String>,
    /// Requested error of a random scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub requested_error: Option<f64>,
}

impl AtlasRow {
    /// Judges both solvers' results; the worse one sets error, warning and verdict.
    pub fn new(case: &Case, value: f64, method: &'static str, cpu: SolverSide, gpu: Option<SolverSide>) -> Self {
        let cpu = cpu.judged_by(case.measure);
        let gpu = gpu.map(|gpu| gpu.judged_by(case.measure));
        let rank = |side: &SolverSide| side.error.unwrap_or(f64::INFINITY);
        let worse = gpu.as_ref().filter(|gpu| rank(gpu) > rank(&cpu)).unwrap_or(&cpu);
        Self {
            case: case.name,
            parameter: case.parameter,
            value,
            method,
            error: worse.error,
            warned: worse.is_warned(),
            verdict: worse.verdict,
            cpu,
            gpu,
            scene: None,
            requested_error: None,
        }
    }

    /// Returns whether a result is certainly further off than `factor` times the error that was requested.
    pub fn exceeds_request(&self, side: &SolverSide, factor: f64) -> bool {
        let least = side.error.map(|error| error - CONFIDENCE_SIGMAS * side.noise);
        (least.zip(self.requested_error)).is_some_and(|(error, requested)| error > factor * requested)
    }

    /// Iterates over its results with their device, CPU or GPU.
    pub fn sides(&self) -> impl Iterator<Item = (SolverKind, &SolverSide)> {
        let gpu = self.gpu.iter().map(|gpu| (SolverKind::Gpu, gpu));
        [(SolverKind::Cpu, &self.cpu)].into_iter().chain(gpu)
    }
}

/// The scene of a case at one value, with its solution.
pub struct Specimen {
    /// Value of the parameter.
    pub value: f64,
    /// Error of the first method.
    pub error: f64,
    /// The scene.
    pub scene: Scene,
    /// Mesh of the solution.
    pub mesh: Mesh,
    /// The solution.
    pub field: RadiosityField,
}

/// Results of one case.
pub struct CaseStudy {
    /// The case.
    pub case: Case,
    /// Rows by value, easy to hard, and by method.
    pub rows: Vec<AtlasRow>,
    /// The scenes to show: the easiest of a case, the worst random ones.
    pub specimens: Vec<Specimen>,
}

impl CaseStudy {
    /// Iterates over all results.
    pub fn sides(&self) -> impl Iterator<Item = (&AtlasRow, SolverKind, &SolverSide)> {
        let rows = self.rows.iter();
        rows.flat_map(|row| row.sides().map(move |(device, side)| (row, device, side)))
    }

    /// Iterates over the results of one method on one device, by value.
    pub fn sides_of(&self, method: &str, device: SolverKind) -> impl Iterator<Item = (&AtlasRow, &SolverSide)> {
        let all = self.sides();
        let own = all.filter(move |(row, found, _)| row.method == method && *found == device);
        own.map(|(row, _, side)| (row, side))
    }

    /// Returns whether a row is of the method that the program runs without options, the first of the case.
    pub fn is_default(&self, row: &AtlasRow) -> bool {
        let default = self.case.methods.first();
        default.is_some_and(|method| method.name == row.method)
    }

    /// Returns the values that were run, easy to hard.
    pub fn swept_values(&self) -> Vec<f64> {
        let mut values: Vec<f64> = self.rows.iter().map(|row| row.value).collect();
        values.dedup();
        values
    }
}

/// Formats a value of a parameter in all its digits, which are few.
pub fn format_value(x: f64) -> String {
    let is_small = x != 0.0 && x.abs() < 1e-3;
    if is_small { format!("{x:e}") } else { x.to_string() }
}
