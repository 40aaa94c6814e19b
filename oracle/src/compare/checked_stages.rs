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

#[cfg(test)]
mod tests {
    use super::*;

    fn refuse(stage: &'static str) -> Error {
        Error::Stage {
            stage,
            message: "an index beyond its list".into(),
        }
    }

    fn check(name: &str, agree: bool) -> StageCheck {
        StageCheck {
            agree,
            worst: 0.0,
            ..StageCheck::without_result(name, "")
        }
    }

    /// A refused result fails its stage, once; a stage that differs keeps its values.
    #[test]
    fn refused_result_fails_its_stage() {
        let mut stages = CheckedStages {
            checks: vec![check("select", true), check("link", false)],
            ..CheckedStages::default()
        };
        for stage in ["select", "link", "deposit", "select"] {
            stages.take_refusal(refuse(stage)).unwrap();
        }
        let found: Vec<_> = stages.checks.iter().map(|c| (&*c.name, c.worst.is_nan())).collect();
        assert_eq!(found, [("link", false), ("select", true), ("deposit", true)]);
        assert!(stages.checks.iter().all(|check| !check.agree));
        let refused = stages.criteria().pop().unwrap();
        assert!(refused.value > refused.bound && refused.reason == refuse("select").to_string());
    }

    #[test]
    fn error_without_a_stage_is_a_verdict_only_beside_a_difference() {
        let fault = || Error::Fault("device lost".into());
        assert!(CheckedStages::default().take_refusal(fault()).is_err());
        for (agree, interrupted) in [(true, false), (false, false), (false, true)] {
            let mut stages = CheckedStages {
                checks: vec![check("link", agree)],
                ..CheckedStages::default()
            };
            let error = if interrupted { Error::Interrupted } else { fault() };
            assert_eq!(stages.take_refusal(error).is_ok(), !agree && !interrupted);
        }
    }

    #[test]
    fn unreached_stages_are_named() {
        let mut stages = CheckedStages::default();
        assert_eq!(stages.describe_unreached(), None);
        stages.unreached = vec!["rays", "lookup"];
        assert!(stages.describe_unreached().unwrap().ends_with("rays, lookup"));
    }
}
