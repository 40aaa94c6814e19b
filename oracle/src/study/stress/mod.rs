//! The failure atlas: scenes that are each built to break one method, over decades of one
//! parameter; where each method breaks, and whether the program notices.
//!
//! The question is the same as everywhere: the mean reflected radiosity B − E of every texel
//! (leaks: the light that is where none may be, over what is emitted).

pub mod breaks;
pub mod cases;
mod chart;
pub mod direct;
#[cfg(test)]
mod fixture;
pub mod gates;
mod groups;
mod indicators;
pub mod json;
pub mod judge;
pub mod measure;
pub mod methods;
pub mod outcome;
pub mod page;
mod plates;
pub mod random;
pub mod run;
pub mod score;
mod section;
mod specimen;
mod table;
pub mod trial;
pub mod truth;

use common::mesh::Mesh;
use common::scene::Scene;
use common::shooting::Field;
use glam::DVec3;
use serde::Serialize;

/// Up to here a method is safe; a greater error must be warned about.
pub const SAFE: f64 = 0.02;
/// Up to here it degrades, beyond it fails.
pub const DEGRADED: f64 = 0.1;

/// [`About::measure`]: root of the mean square error of B − E over that of the truth, worst channel.
pub const RELATIVE: &str = "relative RMS";
/// [`About::measure`]: power reflected where no light may be, over what is emitted.
pub const LEAK: &str = "light behind the wall / emitted power";
/// So much light may get through a wall: a few roundings of the sum.
pub const TIGHT: f64 = 1e-6;
/// More than that through a wall is a failure: it can be seen.
pub const OPEN: f64 = 1e-4;

/// How the message of an answer begins that cannot be judged.
pub const UNJUDGED: &str = "not comparable";
/// How the messages of those begin that did not end as they should.
pub const BROKEN: [&str; 4] = ["panic", "not a number", "took longer", UNJUDGED];

/// What is known of a case before anything is solved.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct About {
    /// Its name on the command line.
    pub name: &'static str,
    /// What is swept, with its unit.
    pub parameter: &'static str,
    /// What it is built to break, in a line.
    pub breaks: &'static str,
    /// Where the truth comes from.
    pub truth: &'static str,
    /// What the error is: "relative RMS" or "light behind the wall / emitted power".
    pub measure: &'static str,
}

/// How a method did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// At most [`SAFE`] off.
    Safe,
    /// At most [`DEGRADED`] off.
    Degrades,
    /// Worse, not a number, or no answer.
    Fails,
}

impl Verdict {
    /// Of an error by one of the two measures; what is no number fails.
    pub fn of(measure: &str, error: Option<f64>) -> Self {
        let [safe, degraded] = limits(measure);
        match error {
            Some(error) if error <= safe => Self::Safe,
            Some(error) if error <= degraded => Self::Degrades,
            _ => Self::Fails,
        }
    }
}

/// Up to where a method is safe, and from where on it fails.
pub fn limits(measure: &str) -> [f64; 2] {
    if measure == LEAK {
        [TIGHT, OPEN]
    } else {
        [SAFE, DEGRADED]
    }
}

/// One solver's part in a row.
#[derive(Clone, Debug, Serialize)]
pub struct Side {
    /// Against the truth; none where there is no answer.
    pub error: Option<f64>,
    /// Its standard error, where the truth is traced.
    pub noise: f64,
    /// Its bias; none where there is no answer, or another measure.
    pub bias: Option<f64>,
    /// What the answer says of its own error; none where that was not looked at.
    pub estimate: Option<f64>,
    /// Of that error, by the limits of the case's measure.
    pub verdict: Verdict,
    /// Codes of the warnings.
    pub warnings: Vec<String>,
    /// What the program changed by itself, a line each.
    pub notes: Vec<String>,
    /// Why there is no answer: the one line that a user would read.
    pub message: Option<String>,
    /// Wall-clock seconds.
    pub seconds: f64,
}

impl Side {
    /// Whether a user is told that something is wrong: a warning, or no answer but a reason.
    pub fn warned(&self) -> bool {
        !self.warnings.is_empty() || self.refused()
    }

    /// Whether it ended in a panic, in what is no number, not at all or without a word: never what
    /// is meant.
    pub fn broke(&self) -> bool {
        match (&self.message, self.error) {
            (Some(message), _) => BROKEN.iter().any(|start| message.starts_with(start)),
            (None, error) => !error.is_some_and(f64::is_finite),
        }
    }

    /// Neither an answer nor broken: a reason why there is none.
    pub fn refused(&self) -> bool {
        self.error.is_none() && !self.broke()
    }
}

/// One method at one value, CPU and GPU side by side.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The case.
    pub case: &'static str,
    /// What is swept.
    pub parameter: &'static str,
    /// Its value.
    pub value: f64,
    /// The method.
    pub method: &'static str,
    /// The worse error of the two; none where one has no answer.
    pub error: Option<f64>,
    /// Whether the side that is worse was warned about, or refused.
    pub warned: bool,
    /// Of the worse side.
    pub verdict: Verdict,
    /// On the CPU.
    pub cpu: Side,
    /// On the GPU; none for the matrix, or without an adapter.
    pub gpu: Option<Side>,
}

/// One face of one answer, to be looked at.
#[derive(Clone, Debug)]
pub struct Plate {
    /// "truth", or the method and its solver.
    pub label: String,
    /// Texels W×H; a triangle's N² texels in the order of its face.
    pub resolution: [u32; 2],
    /// B − E, W/m².
    pub values: Vec<DVec3>,
}

/// A case as it was seen at one value.
pub struct Specimen {
    /// The value.
    pub value: f64,
    /// The scene.
    pub scene: Scene,
    /// Its texels.
    pub mesh: Mesh,
    /// An answer on them.
    pub field: Field,
    /// The face whose plates are shown.
    pub face: u32,
    /// The truth first.
    pub plates: Vec<Plate>,
}

/// One case, run.
pub struct Study {
    /// What it is.
    pub about: About,
    /// Values in order of severity, and in each the methods in one order.
    pub rows: Vec<Row>,
    /// Where most methods have just broken.
    pub specimen: Option<Specimen>,
}
