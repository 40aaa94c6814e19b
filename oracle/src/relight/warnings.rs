//! What may put a relit room more than 2 % off.

use super::work::Done;
use crate::answer::warnings;
use common::energy::Energy;
use common::solution::Warning;

/// Beyond this share of the emitted power a broken balance is worth a warning.
const UNBALANCED: f64 = 0.02;

/// The warnings of a relight; `paper`: by Table 2.
pub fn of(done: &Done, paper: bool) -> Vec<Warning> {
    let mut warnings = warnings::of(&done.mesh, &done.run);
    let energy = Energy::new(&done.mesh, &done.run.field, &done.run.shots);
    if energy.imbalance > UNBALANCED && paper {
        warnings.push(Warning {
            code: "energy".into(),
            faces: Vec::new(),
            message: format!(
                "Table 2 makes up or loses {:.1} % of the emitted power: use --method signed",
                100.0 * energy.imbalance
            ),
        });
    }
    warnings
}
