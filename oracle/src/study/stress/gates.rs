//! What the atlas must show; each gate names the rows that break it.

use super::methods::{DEFAULT, Method, of as methods};
use super::outcome::{self, Half, Outcome, outcome};
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
    let default = &score.default;
    let mut alarms = Vec::new();
    if default.false_share() > FALSE_ALARMS {
        alarms = sides(studies, |study, row, _, side| {
            row.method == DEFAULT && outcome(study.about.measure, side) == Outcome::FalseAlarm
        });
        alarms.push(format!(
            "{} of {} sides",
            default.false_alarms,
            default.sides()
        ));
    }
    vec![
        gate(
            "nothing panics, hangs or is not a number",
            sides(studies, |_, _, _, side| side.broke()),
        ),
        gate(
            "the default is right to 2 %, or warned about",
            sides(studies, |_, row, _, side| {
                row.method == DEFAULT && side.verdict != Verdict::Safe && !side.warned()
            }),
        ),
        gate("false alarms in at most 5 % of the default's rows", alarms),
        gate(
            "no light through walls by rays",
            sides(studies, |study, row, half, side| {
                study.about.measure == LEAK
                    && by_rays(row, half)
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
fn by_rays(row: &Row, half: Half) -> bool {
    let all = methods(Suite::All);
    let method: Option<&Method> = all.iter().find(|m| m.name == row.method);
    method
        .is_some_and(|m| m.settings(1, half == Half::Gpu).transport.visibility == Visibility::Rays)
}

type Bad = fn(&Study, &Row, Half, &Side) -> bool;

/// The sides that break a gate, in words.
fn sides(studies: &[Study], bad: Bad) -> Vec<String> {
    let each = studies.iter().flat_map(|study| {
        let broken = broken(&study.rows, move |row, half, side| {
            bad(study, row, half, side)
        });
        broken.collect::<Vec<_>>()
    });
    each.collect()
}

/// The sides of these rows that are bad, in words.
pub fn broken<'a>(
    rows: impl IntoIterator<Item = &'a Row>,
    bad: impl Fn(&Row, Half, &Side) -> bool,
) -> impl Iterator<Item = String> {
    let all = rows
        .into_iter()
        .flat_map(|row| outcome::sides(row).map(move |(half, side)| (row, half, side)));
    all.filter(move |(row, half, side)| bad(row, *half, side))
        .map(|(row, half, side)| line(row, half, side))
}

/// A side in words.
fn line(row: &Row, half: Half, side: &Side) -> String {
    let found = match (&side.message, side.error) {
        (Some(message), _) => message.clone(),
        (None, Some(error)) => format!("{error:.3e}"),
        (None, None) => "no answer".into(),
    };
    let solver = half.solver();
    format!(
        "{} {} {} {solver}: {found}",
        row.case, row.value, row.method
    )
}
