//! What must hold on scenes that nobody tuned to.

use super::Findings;
use super::ratio::{HIGH, LOW, Ratios};
use crate::report::number::{number, percent};
use crate::stress::gates::{FALSE_ALARMS, Gate, gate, line};
use crate::stress::outcome::{self, Outcome, outcome as of_side};
use crate::stress::{RELATIVE, Row, Side};

/// The median of estimate over error lies within these.
pub const MEDIAN: [f64; 2] = [0.8, 1.5];
/// At most so many estimates are below [`LOW`] of the error.
pub const BELOW: f64 = 0.03;
/// At most so many are above [`HIGH`] of it.
pub const ABOVE: f64 = 0.05;

/// All of them.
pub fn of(findings: &Findings, ratios: &Ratios) -> Vec<Gate> {
    let count = |wanted: Outcome| each(findings, |side| of_side(RELATIVE, side) == wanted);
    let alarms = count(Outcome::FalseAlarm);
    let sides = findings
        .all
        .iter()
        .flat_map(|found| outcome::sides(&found.row))
        .count();
    let many = alarms.len() as f64 > FALSE_ALARMS * sides as f64;
    let ratio = |name, held: bool, found: String| {
        gate(name, (!held).then_some(found).into_iter().collect())
    };
    let held = |share: f64, most: f64| ratios.answers == 0 || share <= most;
    let [low, high] = MEDIAN;
    let within = ratios.answers == 0 || (low..=high).contains(&ratios.median);
    vec![
        gate(
            "nothing panics, hangs or is no number",
            each(findings, Side::broke),
        ),
        gate("right to 2 %, or warned about", count(Outcome::Missed)),
        gate(
            "false alarms in at most 5 % of the answers",
            if many { alarms } else { Vec::new() },
        ),
        ratio(
            "estimate over error: median within 0.8 and 1.5",
            within,
            number(ratios.median),
        ),
        ratio(
            "estimate below half of the error: at most 3 %",
            held(ratios.below, BELOW),
            percent(ratios.below),
        ),
        ratio(
            "estimate above three times the error: at most 5 %",
            held(ratios.above, ABOVE),
            percent(ratios.above),
        ),
    ]
}

fn each(findings: &Findings, bad: impl Fn(&Side) -> bool) -> Vec<String> {
    let rows = findings.all.iter().map(|found| &found.row);
    let sides =
        rows.flat_map(|row: &Row| outcome::sides(row).map(move |(half, side)| (row, half, side)));
    let bad = sides.filter(|(_, _, side)| bad(side));
    bad.map(|(row, half, side)| line(row, side, half.solver()))
        .collect()
}

/// The limits as the page shows them, of [`Ratios`].
pub fn limits() -> String {
    format!(
        "median {}…{}, below {} in at most {}, above {} in at most {}",
        number(MEDIAN[0]),
        number(MEDIAN[1]),
        number(LOW),
        percent(BELOW),
        number(HIGH),
        percent(ABOVE)
    )
}
