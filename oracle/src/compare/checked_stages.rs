//! The checks of the stages of a comparison, and why the GPU is not asked further.

use super::comparison::{Criterion, StageCheck};
use super::criteria::stage_criteria;
use common::{Error, Result};

/// Checks of the stages of a solver.
#[derive(Clone, Debug, Default)]
pub struct CheckedStages {
    /// Checks of the stages that were reached.
    pub checks: Vec<StageCheck>,
    /// Names of the others.
    pub unreached: Vec<&'static str>,
    /// Why the solver is not asked further: the host has refused a result.
    pub refusal: Option<String>,
}

impl CheckedStages {
    /// Returns a note on stages that were not reached, if there are any.
    pub fn describe_unreached(&self) -> Option<String> {
        let names = self.unreached.join(", ");
        (!names.is_empty()).then(|| format!("stages that this scene does not reach: {names}"))
    }

    /// Returns a criterion for each check, and one for a refused result.
    pub fn criteria(&self) -> Vec<Criterion> {
        let name = "results of the GPU that are refused";
        let refused = (self.refusal.as_ref()).map(|reason| Criterion::at_most(name, 1.0, 0.0, reason));
        let mut criteria = stage_criteria(&self.checks);
        criteria.extend(refused);
        criteria
    }

    /// Takes the error of work on the GPU into the verdict.
    ///
    /// Errors: the error, if it names no stage and no stage differs, or if the work was interrupted.
    pub fn take_refusal(&mut self, error: Error) -> Result<()> {
        match &error {
            Error::Interrupted => return Err(error),
            Error::Stage { stage, message } => {
                let of_stage = |check: &StageCheck| check.name == *stage;
                if !self.checks.iter().any(|check| of_stage(check) && !check.agree) {
                    self.checks.retain(|check| !of_stage(check));
                    self.checks.push(StageCheck::without_result(stage, message));
                }
            }
            _ if self.checks.iter().all(|check| check.agree) => return Err(error),
            _ => {}
        }
        self.refusal.get_or_insert(error.to_string());
        Ok(())
    }
}
