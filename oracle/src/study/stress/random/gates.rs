//! What must hold on scenes that nobody tuned to.

use super::Findings;
use super::ratio::{HIGH, LOW, Ratios};
use crate::show::number::{number, percent};
use crate::study::stress::gates::{FALSE_ALARMS, Gate, broken, gate};
use crate::study::stress::outcome::{self, Outcome, outcome as of_side};
use crate::study::stress::{RELATIVE, Side};

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
            "nothing panics, hangs or is not a number",
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
    broken(rows, |_, _, side| bad(side)).collect()
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

#[cfg(test)]
mod tests {
    use super::super::super::fixture::{row, side};
    use super::super::{Findings, Found};
    use super::*;

    /// Error, estimate and a warning's code, empty for none.
    fn broken(answers: &[(f64, f64, &str)]) -> Vec<&'static str> {
        let found = |(seed, (error, estimate, code)): (usize, &(f64, f64, &str))| Found {
            seed: seed as u64,
            told: String::new(),
            texels: 6,
            row: row(
                seed as f64,
                Side {
                    estimate: Some(*estimate),
                    ..side(Some(*error), code)
                },
                None,
            ),
        };
        let findings = Findings {
            all: answers.iter().enumerate().map(found).collect(),
            worst: Vec::new(),
        };
        let gates = of(&findings, &findings.ratios());
        let broken = gates.into_iter().filter(|gate| !gate.held);
        broken.map(|gate| gate.name).collect()
    }

    #[test]
    fn each_gate_can_break() {
        let good = [(0.01, 0.011, ""); 40];
        let with = |more: &[(f64, f64, &str)]| broken(&[&good[..], more].concat());
        assert!(with(&[]).is_empty() && broken(&[]).is_empty());
        assert!(with(&[(0.03, 0.03, "cells")]).is_empty());
        assert!(with(&[(0.01, 0.004, ""), (0.01, 0.031, "")]).is_empty());
        for (more, name) in [
            (&[(f64::NAN, 0.01, "cells")][..], "nothing panics"),
            (&[(0.021, 0.021, "")], "right to 2 %"),
            (&[(0.01, 0.01, "cells"); 3], "false alarms"),
            (&[(0.01, 0.02, ""); 41], "estimate over error"),
            (&[(0.01, 0.004, ""); 2], "estimate below half"),
            (&[(0.01, 0.031, ""); 3], "estimate above three"),
        ] {
            let found = with(more);
            assert!(
                found.iter().any(|gate| gate.starts_with(name)),
                "{name}: {found:?}"
            );
            assert!(found.len() == 1 || name == "nothing panics", "{found:?}");
        }
    }
}
