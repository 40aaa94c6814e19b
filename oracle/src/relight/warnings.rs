//! What may put a relit room more than 2 % off.

use super::stage::Stage;
use crate::solve::check::{self, Estimate};
use crate::solve::solved::Solved;
use crate::solve::warnings;
use common::Result;
use common::energy::Energy;
use common::solution::{Code, Warning};

/// Beyond this share of the emitted power a broken balance is worth a warning.
const UNBALANCED: f64 = 0.02;

/// How far the answer may be off. Where E had to be told from a picture it makes up for whatever
/// the links get wrong, and the look would find that.
pub fn estimate(stage: &Stage, solved: &Solved) -> Result<Option<Estimate>> {
    let values = stage.captured.values.as_ref();
    if values.is_some_and(|values| values.emission.is_none()) || stage.reflectance.is_some() {
        return Ok(None);
    }
    let Solved {
        settings,
        mesh,
        run,
        ..
    } = solved;
    check::estimate(&stage.scene, settings, mesh, &run.field).map(Some)
}

/// The warnings of a relight; `paper`: by Table 2.
pub fn of(stage: &Stage, done: &Solved, paper: bool, estimate: Option<&Estimate>) -> Vec<Warning> {
    let mut warnings = warnings::of(&stage.scene, &done.mesh, &done.run, estimate);
    let energy = Energy::new(&done.mesh, &done.run.field, &done.run.shots);
    if energy.imbalance > UNBALANCED && paper {
        warnings.push(Warning {
            code: Code::Energy,
            faces: Vec::new(),
            message: format!(
                "Table 2 makes up or loses {:.1} % of the emitted power: use --method signed",
                100.0 * energy.imbalance
            ),
        });
    }
    warnings
}
