//! The failure atlas: families of scenes that are each built to break one method, over decades of
//! one parameter. It shows the value at which each method breaks and whether the program warns.
//!
//! The result compared is the mean reflected radiosity B − E of every texel; for leaks it is the
//! light behind a wall over the emitted power.
//!
//! [`cases`] builds the scenes ([`trial`]) and [`random`] draws others, [`truth`] and [`direct_light`]
//! provide their solutions, [`methods`] lists the methods, [`run`] runs them and [`accuracy`] compares;
//! [`summary`] evaluates the rows, [`page`] shows them.

pub mod accuracy;
pub mod cases;
mod chart;
pub mod direct_light;
#[cfg(test)]
mod fixture;
pub mod methods;
pub mod page;
pub mod random;
pub mod run;
mod specimen;
pub mod summary;
pub mod trial;
pub mod truth;

use crate::report::format::{format_number, format_percent, format_scientific};
use cases::Case;
use common::mesh::Mesh;
use common::scene::Scene;
use common::shooting::RadiosityField;
use glam::DVec3;
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
    /// Safe, without a warning.
    Quiet,
    /// A safe leak, whose warning may concern the light elsewhere.
    Uncounted,
}

/// Processor of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Processor {
    /// CPU.
    Cpu,
    /// GPU.
    Gpu,
}

impl Processor {
    /// Both, in the order of the page.
    pub const BOTH: [Self; 2] = [Self::Cpu, Self::Gpu];

    /// Returns the name on the page.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu => "CPU",
            Self::Gpu => "GPU",
        }
    }
}

/// One solver's result in a row.
#[derive(Clone, Debug, Default, Serialize)]
pub struct SolverSide {
    /// Error against the truth; none without an answer.
    pub error: Option<f64>,
    /// Standard error of the error, if the truth is traced.
    pub noise: f64,
    /// Bias; none without an answer, or for a leak.
    pub bias: Option<f64>,
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
        !self.warnings.is_empty() || self.is_refused()
    }

    /// Returns whether the solve panicked, hung, returned NaN or gave neither answer nor message.
    pub fn is_broken(&self) -> bool {
        match (&self.message, self.error) {
            (Some(message), _) => BROKEN_MESSAGES.iter().any(|start| message.starts_with(start)),
            (None, error) => !error.is_some_and(f64::is_finite),
        }
    }

    /// Returns whether the solve was refused with a reason.
    pub fn is_refused(&self) -> bool {
        self.error.is_none() && !self.is_broken()
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
                (true, _) if measure == ErrorMeasure::Leak => WarningOutcome::Uncounted,
                (true, true) => WarningOutcome::FalseAlarm,
                (true, false) => WarningOutcome::Quiet,
            },
            ..self
        }
    }

    /// Formats its error.
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
        }
    }

    /// Returns the result on a processor.
    pub fn side_on(&self, processor: Processor) -> Option<&SolverSide> {
        match processor {
            Processor::Cpu => Some(&self.cpu),
            Processor::Gpu => self.gpu.as_ref(),
        }
    }

    /// Iterates over its results.
    pub fn sides(&self) -> impl Iterator<Item = (Processor, &SolverSide)> {
        let both = Processor::BOTH.into_iter();
        both.filter_map(|processor| Some((processor, self.side_on(processor)?)))
    }
}

/// The texels of one face of one answer, shown as a picture.
#[derive(Clone, Debug)]
pub struct Plate {
    /// "truth", or method and solver.
    pub label: String,
    /// B − E of each texel, W/m²; a triangle has N² texels in the order of its face.
    pub values: Vec<DVec3>,
}

/// The scene of a case at one value, with the answers on one face.
pub struct Specimen {
    /// Value of the parameter.
    pub value: f64,
    /// Description of a random scene.
    pub description: Option<String>,
    /// The scene.
    pub scene: Scene,
    /// Mesh of the shown solution.
    pub mesh: Mesh,
    /// The shown solution.
    pub field: RadiosityField,
    /// Face that the plates are of.
    pub face: u32,
    /// Texels per side of the plates.
    pub texels: u32,
    /// Plates, the truth first.
    pub plates: Vec<Plate>,
}

/// Results of one case.
pub struct CaseStudy {
    /// The case.
    pub case: Case,
    /// Rows by value, easy to hard, and by method.
    pub rows: Vec<AtlasRow>,
    /// The most visible failures, worst first.
    pub specimens: Vec<Specimen>,
}

impl CaseStudy {
    /// Iterates over all results.
    pub fn sides(&self) -> impl Iterator<Item = (&AtlasRow, Processor, &SolverSide)> {
        let rows = self.rows.iter();
        rows.flat_map(|row| row.sides().map(move |(processor, side)| (row, processor, side)))
    }

    /// Returns whether a row is of the method that the program runs without options, the first of the case.
    pub fn is_default(&self, row: &AtlasRow) -> bool {
        self.case
            .methods
            .first()
            .is_some_and(|method| method.name == row.method)
    }

    /// Returns the values that were run, easy to hard.
    pub fn swept_values(&self) -> Vec<f64> {
        let mut values: Vec<f64> = self.rows.iter().map(|row| row.value).collect();
        values.dedup();
        values
    }
}

/// Formats a value of a parameter in all its digits, which are few; as a power of ten where that is shorter.
fn format_value(x: f64) -> String {
    let (plain, power) = (x.to_string(), format_scientific(&format!("{x:e}")));
    let power = power.strip_prefix("1·").unwrap_or(&power);
    match plain.len() <= power.chars().count().max(5) {
        true => plain,
        false => power.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::fixture::{make_row, make_side, make_study};
    use super::*;

    #[test]
    fn refusal_counts_as_warning_and_panic_does_not() {
        let outcome = |message: Option<&str>, error| {
            let side = SolverSide {
                message: message.map(str::to_owned),
                error,
                ..SolverSide::default()
            };
            let side = side.judged_by(ErrorMeasure::RelativeRms);
            (side.outcome, side.is_broken())
        };
        let refused = outcome(Some("face 3 has no area: remove it"), None);
        assert_eq!(refused, (WarningOutcome::Caught, false));
        for broken in [
            outcome(Some("panic: index out of bounds"), None),
            outcome(None, None),
            outcome(None, Some(f64::NAN)),
        ] {
            assert_eq!(broken, (WarningOutcome::Missed, true));
        }
    }

    #[test]
    fn warning_in_a_leak_case_is_no_false_alarm() {
        let outcome = |measure| make_side(Some(0.0), "thin").judged_by(measure).outcome;
        assert_eq!(outcome(ErrorMeasure::RelativeRms), WarningOutcome::FalseAlarm);
        assert_eq!(outcome(ErrorMeasure::Leak), WarningOutcome::Uncounted);
    }

    #[test]
    fn error_equal_to_a_limit_gets_the_better_verdict() {
        let verdicts =
            [0.02, 0.021, 0.1, 0.11, f64::INFINITY].map(|error| ErrorMeasure::RelativeRms.verdict_on(Some(error)));
        use Verdict::{Degrades, Fails, Safe};
        assert_eq!(verdicts, [Safe, Degrades, Degrades, Fails, Fails]);
        let texts = [ErrorMeasure::RelativeRms, ErrorMeasure::Leak].map(|measure| measure.format_error(1e-4));
        assert_eq!(texts, ["0.01\u{202f}%", "1.00·10⁻⁴"]);
    }

    #[test]
    fn values_keep_their_digits() {
        let values = [0.0, 1e-5, 5e-7, 0.3, 0.9996, 0.99999, 1000.0, 1e6, 881_001.0].map(format_value);
        let texts = [
            "0",
            "10⁻⁵",
            "5·10⁻⁷",
            "0.3",
            "0.9996",
            "0.99999",
            "1000",
            "10⁶",
            "881001",
        ];
        assert_eq!(values, texts);
        let rows = [1.0, 1.0, 0.1].map(|value| make_row(value, make_side(None, ""), None));
        assert_eq!(make_study(rows.into()).swept_values(), [1.0, 0.1]);
    }
}
