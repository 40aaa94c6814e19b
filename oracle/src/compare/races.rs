//! Checks that lanes of a workgroup do not race, on a device whose shaders count that
//! ([`Gpu::for_checks`](gpu::Gpu::for_checks)).

use crate::compare::comparison::{DifferingValue, StageCheck, StageDifference};
use common::Result;
use gpu::Gpu;
use stage_check::races::RaceReport;

/// Awaits a check for each shader that has counted accesses.
///
/// Errors: the device fails.
pub async fn race_checks(gpu: &Gpu) -> Result<Vec<StageCheck>> {
    let counted = gpu
        .request_races()
        .await?
        .into_iter()
        .filter(|(_, report)| report.accesses > 0);
    let check = |(file, report): (&str, RaceReport)| {
        let first = report.first.as_ref().map(|race| DifferingValue {
            element: race.element_label(),
            gpu: race.describe_lanes(),
            twin: "never".into(),
        });
        let [races, accesses] = [report.races, report.accesses].map(u64::from);
        StageCheck {
            name: format!("{file}, races"),
            values: accesses,
            differing: races,
            worst: races as f64,
            bound: 0.0,
            reason: "accesses of an element by two lanes without a barrier between, one of them to write".into(),
            agree: races == 0,
            difference: first.map(|first| StageDifference {
                worst: first.clone(),
                first,
                beyond: races,
                values: accesses,
                pattern: "accesses by lanes of one workgroup".into(),
            }),
        }
    };
    Ok(counted.map(check).collect())
}
