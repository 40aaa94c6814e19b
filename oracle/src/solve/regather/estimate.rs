//! Error estimates: the error, its basis and its causes. Every kind of solve reports one; warnings and pages name its
//! causes.

use common::scene::Scene;
use serde::Serialize;
use serde_json::{Value, json};

/// Largest number of faces that an estimate or a warning names.
pub const MAX_NAMED_FACES: usize = 8;

/// Returns the faces in descending order of `squares`.
pub fn descending_order(squares: &[f64]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..squares.len() as u32).collect();
    order.sort_by(|a, b| squares[*b as usize].total_cmp(&squares[*a as usize]));
    order
}

/// Returns the faces with the largest values above 0, at most [`MAX_NAMED_FACES`].
pub fn largest_faces(values: &[f64]) -> Vec<u32> {
    let mut order = descending_order(values);
    order.retain(|f| values[*f as usize] > 0.0);
    order.truncate(MAX_NAMED_FACES);
    order
}

/// A cause of error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ErrorCause {
    /// Visibility of the item buffer instead of rays.
    Visibility,
    /// The disc form factor instead of Lambert's polygon.
    FormFactor,
    /// Variation of light within patches, and the noise of few samples.
    #[serde(rename = "cells")]
    Patches,
    /// Variation of light within texels.
    Texels,
    /// Change of the last refinement step.
    Refinement,
    /// Noise of the rays that gather light.
    Noise,
    /// Unshot light.
    Iteration,
    /// Closure defect of the links, accumulated over bounces.
    Closure,
    /// Rounding accumulated over reflections.
    Rounding,
}

impl ErrorCause {
    /// Short name of the cause.
    pub fn name(self) -> &'static str {
        match self {
            Self::Visibility => "visibility",
            Self::FormFactor => "form factor",
            Self::Patches => "patches",
            Self::Texels => "texels",
            Self::Refinement => "refinement",
            Self::Noise => "noise",
            Self::Iteration => "iteration",
            Self::Closure => "closure",
            Self::Rounding => "rounding",
        }
    }

    /// Explanation of the cause in one phrase.
    pub fn describe_cause(self) -> &'static str {
        match self {
            Self::Visibility => "visibility of an item buffer instead of rays",
            Self::FormFactor => "disc form factors instead of Lambert's polygons",
            Self::Patches => "light varies within patches",
            Self::Texels => "light varies within texels",
            Self::Refinement => "change of the last refinement step",
            Self::Noise => "noise of the rays that gather light",
            Self::Iteration => "unshot light",
            Self::Closure => "links add or lose light at each bounce",
            Self::Rounding => "32-bit rounding, accumulated over reflections",
        }
    }
}

/// The part of the error with one cause.
#[derive(Clone, Debug, Serialize)]
pub struct ErrorPart {
    /// The cause.
    pub cause: ErrorCause,
    /// Relative RMS error from this cause.
    pub error: f64,
    /// The most affected faces, the worst first.
    pub faces: Vec<u32>,
}

/// An error estimate. All errors are relative to the RMS of B − E, in the worst channel.
#[derive(Clone, Debug, Serialize)]
pub struct ErrorEstimate {
    /// The estimated error.
    pub error: f64,
    /// Upper bound: of a sample the error with two standard errors of its square on top; of steps the error if it was alike
    /// in the last two.
    pub upper: f64,
    /// Method of the estimate.
    #[serde(flatten)]
    pub evidence: EstimateBasis,
    /// Parts of the error by cause.
    #[serde(rename = "causes")]
    pub parts: Vec<ErrorPart>,
}

/// A face with a large relative error.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FaceError {
    /// Number of the face.
    pub face: u32,
    /// Error relative to the RMS of the face's own light.
    pub error: f64,
}

/// Method of an estimate, with its details.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum EstimateBasis {
    /// A sample of texels was gathered again. The upper bound is wide because a few texels at shadow edges make
    /// most of the error, and not all of them are in the sample.
    Regathered {
        /// Error of one bounce.
        one_bounce: f64,
        /// Error from the propagation through later bounces.
        later_bounces: f64,
        /// Standard error of the squared error, as a root; no smaller error is reported.
        floor: f64,
        /// Number of texels gathered again.
        looks: usize,
        /// Number of rays.
        rays: u64,
    },
    /// The scene was solved in successive steps, each finer than the one before.
    SuccessiveSteps {
        /// Change of each step from the one before; by rays, if its texels are merged two by two.
        changes: Vec<f64>,
        /// Faces whose error, relative to their own light, is more than ten times that of the scene.
        worse: Vec<FaceError>,
    },
}

impl ErrorEstimate {
    /// Root of the standard error of the squared error; 0 for successive steps.
    pub fn standard_error(&self) -> f64 {
        match self.evidence {
            EstimateBasis::Regathered { floor, .. } => floor,
            EstimateBasis::SuccessiveSteps { .. } => 0.0,
        }
    }

    /// Lower bound: the error with two standard errors of its square subtracted.
    pub fn lower_bound(&self) -> f64 {
        let square = self.error * self.error - 2.0 * self.standard_error().powi(2);
        square.max(0.0).sqrt()
    }

    /// Cautious upper bound: the error with three standard errors of its square added. A small early sample
    /// needs more than two: texels that it missed are in neither its error nor its standard error.
    pub fn upper_bound(&self) -> f64 {
        let square = self.error * self.error + 3.0 * self.standard_error().powi(2);
        square.sqrt()
    }

    /// Returns a note that lists the faces of `scene` with errors far above the scene's, as its file numbers them.
    pub fn describe_worst_faces(&self, scene: &Scene) -> Option<String> {
        let EstimateBasis::SuccessiveSteps { worse, .. } = &self.evidence else {
            return None;
        };
        let each = |worse: &FaceError| {
            // Of a face that receives hardly any light only so much is known.
            let error = match worse.error {
                ..1.0 => format!("{:.0} %", 100.0 * worse.error),
                _ => "over 100 %".into(),
            };
            format!("{} {error}", scene.face_label(worse.face as usize))
        };
        let all: Vec<String> = worse.iter().map(each).collect();
        (!all.is_empty()).then(|| {
            format!(
                "errors of more than ten times that of the scene, relative to the face's own light: {}",
                all.join(", ")
            )
        })
    }

    /// Converts the estimate for `result.json`.
    pub fn to_json(&self) -> Value {
        json!(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::Face;
    use glam::{DVec3, Vec3};

    #[test]
    fn note_names_faces_as_the_file_does() {
        let face = |name| Face::triangle(name, [DVec3::ZERO, DVec3::X, DVec3::Y], Vec3::ZERO, Vec3::ZERO);
        let mut scene = Scene {
            faces: ["floor", "wall", "back"].map(face).into(),
            ..Scene::default()
        };
        scene.faces[2].input_face = Some(0);
        let worse = [(1, 0.34), (2, 25.0)].map(|(face, error)| FaceError { face, error });
        let estimate = ErrorEstimate {
            error: 0.01,
            upper: 0.01,
            evidence: EstimateBasis::SuccessiveSteps {
                changes: vec![0.01],
                worse: worse.into(),
            },
            parts: Vec::new(),
        };
        let note = estimate.describe_worst_faces(&scene).unwrap_or_default();
        assert!(
            note.ends_with(": face 2 (wall) 34 %, face 1 (back) over 100 %"),
            "{note}"
        );
    }
}
