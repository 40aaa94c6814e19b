//! How far off an answer may be, and how that is known.

use serde::Serialize;
use serde_json::{Value, json};

/// Faces that a part or a warning names.
pub const NAMED: usize = 8;

/// What explains a difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// The item buffer: rays see something else.
    Visibility,
    /// The form factor: Lambert's polygon is another.
    FormFactor,
    /// Whole cells for what varies within them, and the noise of few samples.
    Cells,
    /// Whole texels for light that varies within them.
    Texels,
    /// What the last of several solves still changed, where nobody looked at what of.
    Refinement,
    /// Nodes whose light a slope does not tell.
    Sources,
    /// Light that neighbours tell, and no texel has received for itself.
    Receivers,
    /// What is sent on, and so wrong at many together.
    Propagation,
    /// What unshot light would still make.
    Iteration,
    /// What links made up or lost, bounce by bounce.
    Closure,
    /// Rounding that reflections add up.
    Rounding,
}

impl Cause {
    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Visibility => "visibility",
            Self::FormFactor => "form factor",
            Self::Cells => "cells",
            Self::Texels => "texels",
            Self::Refinement => "refinement",
            Self::Sources => "sources",
            Self::Receivers => "receivers",
            Self::Propagation => "propagation",
            Self::Iteration => "iteration",
            Self::Closure => "closure",
            Self::Rounding => "rounding",
        }
    }

    /// In a sentence.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Visibility => "who sees whom: item buffers, or few rays at the edges of shadows",
            Self::FormFactor => "discs in the place of Lambert's polygons",
            Self::Cells => "whole cells shoot what varies within them",
            Self::Texels => "light varies within texels",
            Self::Refinement => "what the last of several solves still changed",
            Self::Sources => "light that varies within what shines, beyond a mean and a slope",
            Self::Receivers => "texels that take their light from their neighbours'",
            Self::Propagation => "light that was sent on and is wrong at many texels together",
            Self::Iteration => "what unshot light would still make",
            Self::Closure => "what links made up or lost, bounce by bounce",
            Self::Rounding => "32-bit rounding that reflections add up",
        }
    }

    /// Whether it is what finer steps of a solve to an error would mend.
    pub fn of_refinement(self) -> bool {
        use Cause::{Propagation, Receivers, Refinement, Sources, Texels, Visibility};
        let all = [
            Refinement,
            Sources,
            Visibility,
            Receivers,
            Propagation,
            Texels,
        ];
        all.contains(&self)
    }
}

/// One cause's part.
#[derive(Clone, Debug, Serialize)]
pub struct Part {
    /// The cause.
    pub cause: Cause,
    /// Relative RMS of what it explains.
    pub error: f64,
    /// The faces that it concerns most, the worst first.
    pub faces: Vec<u32>,
}

/// What is found, each a relative RMS of B − E, of the worst channel.
#[derive(Clone, Debug, Serialize)]
pub struct Estimate {
    /// The error.
    pub error: f64,
    /// The same with what is in doubt on top.
    pub upper: f64,
    /// How it is known.
    #[serde(flatten)]
    pub evidence: Evidence,
    /// Its causes.
    #[serde(rename = "causes")]
    pub parts: Vec<Part>,
}

/// A face that is far off.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Worse {
    /// Its number.
    pub face: u32,
    /// How far, of the RMS of its own light.
    pub error: f64,
}

/// How an error is known.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Evidence {
    /// The light was gathered again. The upper error has two standard errors of the square on top: a few
    /// texels on the edges of shadows make most of it, and not all of them are looked at.
    Looked {
        /// What one bounce gets wrong.
        one_bounce: f64,
        /// What later bounces make of it.
        later_bounces: f64,
        /// What could not be told from no error.
        floor: f64,
        /// Texels that were looked at.
        looks: usize,
        /// Rays that were asked.
        rays: u64,
    },
    /// It was solved again, finer each time.
    Moved {
        /// What each step changed.
        changes: Vec<f64>,
        /// Faces that are more than ten times as far off as the whole, each of its own light.
        worse: Vec<Worse>,
    },
}

impl Estimate {
    /// The standard error, as that of a square.
    pub fn floor(&self) -> f64 {
        match self.evidence {
            Evidence::Looked { floor, .. } => floor,
            Evidence::Moved { .. } => 0.0,
        }
    }

    /// The error with two standard errors of its square taken off.
    pub fn least(&self) -> f64 {
        let square = self.error * self.error - 2.0 * self.floor().powi(2);
        square.max(0.0).sqrt()
    }

    /// The error with three standard errors of its square on top. An early look that finds little is
    /// held to more than the last: what it missed is in neither its error nor its standard error.
    pub fn most(&self) -> f64 {
        let square = self.error * self.error + 3.0 * self.floor().powi(2);
        square.sqrt()
    }

    /// What is to be said of faces that are far worse than the whole.
    pub fn worse(&self) -> Option<String> {
        let Evidence::Moved { worse, .. } = &self.evidence else {
            return None;
        };
        let each = |worse: &Worse| format!("{} ({:.0} %)", worse.face, 100.0 * worse.error);
        let all: Vec<String> = worse.iter().map(each).collect();
        (!all.is_empty()).then(|| {
            format!(
                "more than ten times as far off as the whole, each of its own light: face {}",
                all.join(", ")
            )
        })
    }

    /// As `result.json` has it.
    pub fn certificate(&self) -> Value {
        json!(self)
    }
}
