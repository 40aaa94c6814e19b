//! Counts of verdicts, in all, by shader and by operator.

use super::{JudgedMutant, MutantVerdict};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Numbers of mutants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Score {
    /// Judged.
    pub mutants: usize,
    /// Killed.
    pub killed: usize,
    /// Survived.
    pub survived: usize,
    /// Equivalent to the original.
    pub equivalent: usize,
    /// Without a module.
    pub invalid: usize,
    /// Of shaders that no comparison runs.
    pub not_run: usize,
    /// Killed by a stage under which faults of the shader are shown.
    pub stage_named: usize,
    /// Killed by a comparison of which the first divergence was sought.
    pub diverged: usize,
    /// Those of them whose first divergence leads to such a stage.
    pub divergence_right: usize,
}

impl Score {
    /// Counts verdicts.
    pub fn new<'j>(judged: impl IntoIterator<Item = &'j JudgedMutant>) -> Self {
        let mut score = Self::default();
        for mutant in judged {
            score.mutants += 1;
            score.stage_named += usize::from(mutant.own_stage);
            score.diverged += usize::from(mutant.divergence_leads_here.is_some());
            score.divergence_right += usize::from(mutant.divergence_leads_here == Some(true));
            *match mutant.verdict {
                MutantVerdict::Killed => &mut score.killed,
                MutantVerdict::Survived => &mut score.survived,
                MutantVerdict::Equivalent => &mut score.equivalent,
                MutantVerdict::Invalid => &mut score.invalid,
                MutantVerdict::NotRun => &mut score.not_run,
            } += 1;
        }
        score
    }

    /// Counts verdicts by a name, such as the shader's.
    pub fn by_name<'j>(judged: &'j [JudgedMutant], name: impl Fn(&'j JudgedMutant) -> &'j str) -> Vec<(&'j str, Self)> {
        let mut groups: BTreeMap<&str, Vec<&JudgedMutant>> = BTreeMap::new();
        for mutant in judged {
            groups.entry(name(mutant)).or_default().push(mutant);
        }
        groups
            .into_iter()
            .map(|(name, group)| (name, Self::new(group)))
            .collect()
    }

    /// Returns the share of killed mutants among those that differ from the original and compile; none without any.
    pub fn killed_share(&self) -> Option<f64> {
        let all = self.mutants - self.equivalent - self.invalid;
        (all > 0).then(|| self.killed as f64 / all as f64)
    }

    /// Returns whether a mutant survives or is not run.
    pub fn has_gap(&self) -> bool {
        self.survived + self.not_run > 0
    }

    /// Returns the numbers in words.
    pub fn describe(&self) -> String {
        format!(
            "{} mutants: {} killed, {} of them by a stage of their own; first divergence right in {} of {}; {} survived, \
             {} equivalent, {} invalid, {} not run",
            self.mutants,
            self.killed,
            self.stage_named,
            self.divergence_right,
            self.diverged,
            self.survived,
            self.equivalent,
            self.invalid,
            self.not_run
        )
    }

    /// Returns the numbers as JSON.
    pub fn to_json(self) -> Value {
        json!({
            "mutants": self.mutants, "killed": self.killed, "survived": self.survived,
            "equivalent": self.equivalent, "invalid": self.invalid, "not_run": self.not_run,
            "score": self.killed_share(), "stage_named": self.stage_named,
            "diverged": self.diverged, "divergence_right": self.divergence_right,
        })
    }
}

/// Returns all results as JSON; `existing` is the number of mutants that could have been drawn.
pub fn summarise_verdicts(judged: &[JudgedMutant], existing: usize) -> Value {
    let named = |groups: Vec<(&str, Score)>| -> Value {
        let entries = groups
            .into_iter()
            .map(|(name, score)| (name.to_owned(), score.to_json()));
        Value::Object(entries.collect())
    };
    let mut summary = Score::new(judged).to_json();
    summary["existing"] = existing.into();
    summary["by_shader"] = named(Score::by_name(judged, |mutant| &mutant.shader));
    summary["by_operator"] = named(Score::by_name(judged, |mutant| &mutant.operator));
    summary["rows"] = json!(judged);
    summary
}
