//! Cases of the failure atlas: scenes that are each built to break one method, and their exact answers.

use crate::request::name_settings;
use common::scene::Scene;
use common::{Error, Result};
use glam::DVec3;
use oracle::diff::reflected::ReflectedField;
use oracle::solve::solved::Solved;
use radiosity::studies::stress::cases::{ALL_CASES, Case};
use radiosity::studies::stress::methods::MethodSolver;
use radiosity::studies::stress::trial::Trial;
use radiosity::studies::stress::{Verdict, format_value};
use serde::Serialize;
use serde_json::Value;

/// A case as the page lists it.
#[derive(Debug, Serialize)]
pub struct ListedCase {
    /// Name.
    pub name: &'static str,
    /// Weakness that it is built to expose.
    pub weakness: &'static str,
    /// Parameter with its unit.
    pub parameter: &'static str,
    /// Source of the truth.
    pub truth: &'static str,
    /// Values of the parameter, easy to hard.
    pub values: Vec<ListedValue>,
    /// Name of a method that fails in the middle of the values, where one does.
    pub failing_method: &'static str,
    /// Methods whose settings a request can have, in the atlas's order.
    pub methods: Vec<ListedMethod>,
}

/// A value of a case's parameter.
#[derive(Debug, Serialize)]
pub struct ListedValue {
    /// The value.
    pub value: f64,
    /// All its digits.
    pub text: String,
}

/// A method of the failure atlas.
#[derive(Debug, Serialize)]
pub struct ListedMethod {
    /// Name.
    pub name: &'static str,
    /// Its settings, by their names in a request.
    pub settings: Value,
}

/// A case whose scene is open.
pub struct OpenedCase {
    case: &'static Case,
    value: f64,
    /// Texels per side of a face in the failure atlas.
    pub texels: u32,
}

/// The solve of a case beside its exact answer.
#[derive(Debug, Serialize)]
pub struct ExactComparison {
    /// Mean of B − E over the judged texels and the channels, W/m².
    pub found: f64,
    /// The same of the exact answer.
    pub exact: f64,
    /// Error in the case's measure, formatted.
    pub error: String,
    /// Name of the measure.
    pub measure: &'static str,
    /// Verdict of the failure atlas on the error.
    pub verdict: Verdict,
}

/// Lists the cases that are solved, with the values at which something shines.
pub fn list_cases() -> Vec<ListedCase> {
    ALL_CASES
        .iter()
        .map(list_case)
        .filter(|case| !case.values.is_empty())
        .collect()
}

fn list_case(case: &Case) -> ListedCase {
    let values = case.values.iter().copied();
    let solved = values.filter(|value| (case.build)(*value).is_ok_and(|trial| is_solved(&trial)));
    let listed = solved.map(|value| ListedValue {
        value,
        text: format_value(value),
    });
    ListedCase {
        name: case.name,
        weakness: case.weakness,
        parameter: case.parameter,
        truth: case.truth,
        values: listed.collect(),
        failing_method: case.failing_method.name,
        methods: list_methods(case),
    }
}

/// Returns whether a trial is the solve of a whole scene with a lamp.
fn is_solved(trial: &Trial) -> bool {
    let shines = trial.scene.faces.iter().any(|face| face.emission.max_element() > 0.0);
    trial.room == 0 && shines
}

/// Lists the methods of progressive refinement. The page shoots from one patch at a time, so methods that differ by their
/// iteration are one.
fn list_methods(case: &Case) -> Vec<ListedMethod> {
    let mut methods: Vec<ListedMethod> = Vec::new();
    for method in case.methods {
        let settings = method.settings_on(1, false);
        let named = name_settings(&settings);
        let has_controls = method.solver == MethodSolver::Shooting && !settings.transport.conserve;
        if has_controls && methods.iter().all(|other| other.settings != named) {
            methods.push(ListedMethod {
                name: method.name,
                settings: named,
            });
        }
    }
    methods
}

impl OpenedCase {
    /// Builds the scene of a case at a value of its parameter.
    ///
    /// Errors: [`Error::Usage`] of an unknown name; those of the case's builder.
    pub fn build(name: &str, value: f64) -> Result<(Self, Scene)> {
        let case = ALL_CASES.iter().find(|case| case.name == name);
        let case = case.ok_or_else(|| Error::Usage(format!("there is no case {name:?}")))?;
        let Trial { mut scene, texels, .. } = (case.build)(value)?;
        scene.name = format!("{name}, {} = {}", case.parameter, format_value(value));
        Ok((Self { case, value, texels }, scene))
    }

    /// Compares a solve of its scene with the exact answer; none if the case has none.
    ///
    /// Errors: those of the case's builder; [`Error::Usage`] of a solve that cannot be compared.
    pub fn compare_with_exact(&self, solved: &Solved) -> Result<Option<ExactComparison>> {
        let trial = Trial {
            texels: solved.settings.meshing.texels,
            ..(self.case.build)(self.value)?
        };
        let Some(exact) = trial.exact_answer() else {
            return Ok(None);
        };
        let found = ReflectedField::from_field(&trial.scene, &solved.mesh, &solved.run.field).values;
        let compared = trial.error_and_noise(&found, &exact);
        let (error, _) = compared.map_err(|reason| Error::Usage(format!("{}: {reason}", self.case.name)))?;
        let areas = trial.judged_areas();
        Ok(Some(ExactComparison {
            found: mean_light(&areas, &found),
            exact: mean_light(&areas, &exact),
            error: self.case.measure.format_error(error),
            measure: self.case.measure.name(),
            verdict: self.case.measure.verdict_on(Some(error)),
        }))
    }
}

/// Returns the mean over areas and channels.
fn mean_light(areas: &[f64], values: &[DVec3]) -> f64 {
    let light: f64 = areas
        .iter()
        .zip(values)
        .map(|(area, value)| area * value.element_sum())
        .sum();
    light / (3.0 * areas.iter().sum::<f64>())
}
