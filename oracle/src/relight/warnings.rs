//! Error estimate and warnings of a relight.

use super::stage::RelightStage;
use crate::solve::regather::{self, ErrorEstimate};
use crate::solve::solved::Solved;
use crate::solve::warnings;
use common::Result;
use common::energy::EnergyBalance;
use common::solution::{Warning, WarningCode};

/// Share of the emitted power above which a broken energy balance causes a warning.
const MAX_IMBALANCE: f64 = 0.02;

/// Estimates the error by re-gathering. Returns `None` if E was recovered from a picture: then E compensates any
/// error of the links, and re-gathering would report that as an error.
pub fn estimate_error(stage: &RelightStage, solved: &Solved) -> Result<Option<ErrorEstimate>> {
    let values = stage.captured.values.as_ref();
    if values.is_some_and(|values| values.emission.is_none()) || stage.reflectance.is_some() {
        return Ok(None);
    }
    let Solved {
        settings, mesh, run, ..
    } = solved;
    regather::estimate_by_regathering(&stage.scene, settings, mesh, &run.field).map(Some)
}

/// Collects the warnings of a relight; `paper` is true for the paper's Table 2.
pub fn collect_warnings(
    stage: &RelightStage,
    done: &Solved,
    paper: bool,
    estimate: Option<&ErrorEstimate>,
) -> Vec<Warning> {
    let mut warnings = warnings::collect_warnings(&stage.scene, &done.mesh, &done.run, estimate);
    let energy = EnergyBalance::new(&done.mesh, &done.run.field, &done.run.shots);
    if energy.imbalance > MAX_IMBALANCE && paper {
        warnings.push(Warning {
            code: WarningCode::Energy,
            faces: Vec::new(),
            message: format!(
                "Table 2 adds or loses {:.1} % of the emitted power: use --method signed",
                100.0 * energy.imbalance
            ),
        });
    }
    warnings
}
