//! The failure atlas: families of scenes that are each built to break one method, over decades of
//! one parameter. It shows the value at which each method breaks and whether the program warns.
//!
//! The result compared is the mean reflected radiosity B − E of every texel; for leaks it is the
//! light behind a wall over the emitted power.
//!
//! [`cases`] builds the scenes ([`trial`]), [`truth`] and [`direct_light`] provide their solutions,
//! [`methods`] lists the methods, [`run`] and [`measure`] run them and [`accuracy`] compares; [`outcome`],
//! [`breaks`], [`score`] and [`gates`] evaluate the rows, [`page`] and [`json`] write them. [`random`]
//! does the same on random scenes.

pub mod accuracy;
pub mod breaks;
pub mod cases;
mod chart;
pub mod direct_light;
#[cfg(test)]
mod fixture;
pub mod gates;
mod groups;
pub mod json;
pub mod measure;
pub mod methods;
pub mod outcome;
pub mod page;
pub mod random;
pub mod run;
pub mod score;
mod section;
mod specimen;
mod table;
pub mod trial;
pub mod truth;
mod warnings;

use common::mesh::Mesh;
use common::scene::Scene;
use common::shooting::RadiosityField;
use glam::DVec3;
use serde::Serialize;

/// Largest relative RMS error that is safe; a greater one needs a warning.
pub const SAFE_ERROR: f64 = 0.02;
/// Largest relative RMS error of a degraded result; a greater one is a failure.
pub const DEGRADED_ERROR: f64 = 0.1;

/// [`CaseInfo::measure`]: RMS error of B − E over the RMS of the truth, worst channel.
pub const RELATIVE_RMS: &str = "relative RMS";
/// [`CaseInfo::measure`]: power reflected behind a wall over the emitted power.
pub const LEAK_MEASURE: &str = "light behind the wall / emitted power";
/// Largest leak that is safe: a few roundings of the sum.
pub const SAFE_LEAK: f64 = 1e-6;
/// Largest leak of a degraded result; a greater one is visible.
pub const DEGRADED_LEAK: f64 = 1e-4;

/// Start of the message of an answer that cannot be compared.
pub const NOT_COMPARABLE: &str = "not comparable";
/// Starts of the messages of solves that broke.
pub const BROKEN_MESSAGES: [&str; 4] = ["panic", "not a number", "took longer", NOT_COMPARABLE];

/// Description of a case.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct CaseInfo {
    /// Name on the command line.
    pub name: &'static str,
    /// Swept parameter with its unit.
    pub parameter: &'static str,
    /// Weakness that the case is built to expose.
    pub breaks: &'static str,
    /// Source of the truth.
    pub truth: &'static str,
    /// Measure of the error: [`RELATIVE_RMS`] or [`LEAK_MEASURE`].
    pub measure: &'static str,
}

/// Verdict on a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Error at most [`SAFE_ERROR`].
    Safe,
    /// Error at most [`DEGRADED_ERROR`].
    Degrades,
    /// Greater error, NaN, or no answer.
    Fails,
}

impl Verdict {
    /// Returns the verdict on an error by one of the two measures; NaN fails.
    pub fn of_error(measure: &str, error: Option<f64>) -> Self {
        let [safe, degraded] = error_limits(measure);
        match error {
            Some(error) if error <= safe => Self::Safe,
            Some(error) if error <= degraded => Self::Degrades,
            _ => Self::Fails,
        }
    }
}

/// Returns the largest errors of a safe and of a degraded result.
pub fn error_limits(measure: &str) -> [f64; 2] {
    if measure == LEAK_MEASURE {
        [SAFE_LEAK, DEGRADED_LEAK]
    } else {
        [SAFE_ERROR, DEGRADED_ERROR]
    }
}

/// One solver's result in a row.
#[derive(Clone, Debug, Serialize)]
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
}

/// The texels of one face of one answer, shown as a picture.
#[derive(Clone, Debug)]
pub struct Plate {
    /// "truth", or method and solver.
    pub label: String,
    /// Texels W×H; a triangle has N² texels in the order of its face.
    pub resolution: [u32; 2],
    /// B − E of each texel, W/m².
    pub values: Vec<DVec3>,
}

/// The scene of a case at one value, with the answers on one face.
pub struct Specimen {
    /// Value of the parameter.
    pub value: f64,
    /// The scene.
    pub scene: Scene,
    /// Mesh of the shown solution.
    pub mesh: Mesh,
    /// The shown solution.
    pub field: RadiosityField,
    /// Face that the plates are of.
    pub face: u32,
    /// Plates, the truth first.
    pub plates: Vec<Plate>,
}

/// Results of one case.
pub struct CaseStudy {
    /// Description of the case.
    pub info: CaseInfo,
    /// Rows by value, easy to hard, and by method.
    pub rows: Vec<AtlasRow>,
    /// The most visible failure.
    pub specimen: Option<Specimen>,
}
