//! What the atlas must show; each gate names the rows that break it.

use super::breaks::side;
use super::methods::{DEFAULT, Method, of as methods};
use super::outcome::{Outcome, outcome};
use super::score::Score;
use super::trial::Suite;
use super::{LEAK, Row, Side, Study, TIGHT, Verdict};
use common::settings::Visibility;
use serde::Serialize;

/// At most so many sides of the default may be warned about for nothing.
pub const FALSE_ALARMS: f64 = 0.05;

/// One requirement.
#[derive(Clone, Debug, Serialize)]
pub struct Gate {
    /// What must hold.
    pub name: &'static str,
    /// Whether it does.
    pub held: bool,
    /// Where it does not.
    pub broken: Vec<String>,
}

/// All of them.
pub fn of(studies: &[Study], score: &Score) -> Vec<Gate> {
    let share = score.default.false_share();
    let alarms = || {
        let mut alarms = sides(studies, |study, row, side, _| {
            row.method == DEFAULT && outcome(study.about.measure, side) == Outcome::FalseAlarm
        });
        alarms.push(format!(
            "{} of {} sides",
            score.default.false_alarms,
            score.default.sides()
        ));
        alarms
    };
    vec![
        gate(
            "nothing panics, hangs or is not a number",
            sides(studies, |_, _, side, _| side.broke()),
        ),
        gate(
            "the default is right to 2 %, or warned about",
            sides(studies, |_, row, side, _| {
                row.method == DEFAULT && side.verdict != Verdict::Safe && !side.warned()
            }),
        ),
        gate(
            "false alarms in at most 5 % of the default's rows",
            if share > FALSE_ALARMS {
                alarms()
            } else {
                Vec::new()
            },
        ),
        gate(
            "no light through walls by rays",
            sides(studies, |study, row, side, solver| {
                study.about.measure == LEAK
                    && by_rays(row, solver)
                    && side.error.is_none_or(|error| error > TIGHT)
            }),
        ),
    ]
}

/// A gate and the rows that break it.
pub fn gate(name: &'static str, broken: Vec<String>) -> Gate {
    Gate {
        name,
        held: broken.is_empty(),
        broken,
    }
}

/// Whether the method asks rays.
fn by_rays(row: &Row, solver: &str) -> bool {
    let all = methods(Suite::All);
    let method: Option<&Method> = all.iter().find(|m| m.name == row.method);
    method.is_some_and(|m| m.settings(1, solver == "gpu").visibility == Visibility::Rays)
}

type Bad = fn(&Study, &Row, &Side, &str) -> bool;

/// The sides that break a gate, in words.
fn sides(studies: &[Study], bad: Bad) -> Vec<String> {
    let mut broken = Vec::new();
    for study in studies {
        for row in &study.rows {
            for solver in ["cpu", "gpu"] {
                if let Some(side) = side(row, solver).filter(|s| bad(study, row, s, solver)) {
                    broken.push(line(row, side, solver));
                }
            }
        }
    }
    broken
}

/// A side in words.
pub fn line(row: &Row, side: &Side, solver: &str) -> String {
    let found = match (&side.message, side.error) {
        (Some(message), _) => message.clone(),
        (None, Some(error)) => format!("{error:.3e}"),
        (None, None) => "no answer".into(),
    };
    format!(
        "{} {} {} {solver}: {found}",
        row.case, row.value, row.method
    )
}
