//! Sabotage: mutants of the shaders, each a small mistake, which the comparison has to find. A mutant that survives is a
//! check that is missing.
//!
//! [`selection`] lists the mutants and draws some of them, [`run`] judges them in processes of their own ([`judge`] on
//! this side, [`worker`] on the other), [`store`] keeps each verdict as it comes, [`score`] counts, [`page`] shows.

pub mod equivalent;
pub mod judge;
pub mod page;
pub mod run;
pub mod score;
pub mod selection;
pub mod store;
pub mod worker;

use gpu::shader_mutants::Mutation;
use serde::{Deserialize, Serialize};

/// A mutant of a shader.
#[derive(Clone, Debug)]
pub struct Mutant {
    /// Name of the shader.
    pub shader: &'static str,
    /// Path of its file.
    pub file: String,
    /// Change of its text.
    pub mutation: Mutation,
    /// Number of the line, from 1.
    pub line: usize,
    /// The line without indentation.
    pub line_text: String,
    /// The text that changes.
    pub original: String,
    /// Name that does not depend on the other mutants.
    pub key: String,
}

/// End of a mutant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MutantVerdict {
    /// A criterion of a comparison does not hold.
    Killed,
    /// All criteria of all comparisons hold.
    Survived,
    /// It does the same as the original.
    Equivalent,
    /// It does not compile.
    Invalid,
    /// No comparison runs its shader.
    NotRun,
}

/// A judged mutant.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct JudgedMutant {
    /// Name that does not depend on the other mutants.
    pub key: String,
    /// Name of the shader.
    pub shader: String,
    /// Path of its file.
    pub file: String,
    /// Number of the line, from 1.
    pub line: usize,
    /// The line without indentation.
    pub line_text: String,
    /// Kind of the mutation.
    pub operator: String,
    /// The text that changes.
    pub original: String,
    /// Its new text.
    pub mutated: String,
    /// End.
    pub verdict: MutantVerdict,
    /// The first criterion that does not hold, or the reason.
    pub reason: String,
    /// Whether that criterion is one of a stage under which faults of the shader are shown.
    pub own_stage: bool,
    /// Whether the first divergence leads to such a stage; none where a comparison ended before one could be sought.
    pub divergence_leads_here: Option<bool>,
    /// Seconds that the judgement took.
    pub seconds: f64,
}

impl JudgedMutant {
    /// Returns file, line and change.
    pub fn describe(&self) -> String {
        let one_line = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let mutated = match one_line(&self.mutated) {
            text if text.is_empty() => "nothing".to_owned(),
            text => text,
        };
        let (original, line) = (one_line(&self.original), one_line(&self.line_text));
        format!("{}:{}: {original} → {mutated} in: {line}", self.file, self.line)
    }
}
