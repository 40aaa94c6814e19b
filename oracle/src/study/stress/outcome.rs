//! What became of one side of a row, and how the atlas names it.

use super::{LEAK, Row, Side, Study, Verdict};
use crate::show::number::{number, percent, power};
use serde::Serialize;

/// A solver's half of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Half {
    /// The CPU's.
    Cpu,
    /// The GPU's.
    Gpu,
}

impl Half {
    /// In the order of the page.
    pub const BOTH: [Self; 2] = [Self::Cpu, Self::Gpu];

    /// On the page.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu => "CPU",
            Self::Gpu => "GPU",
        }
    }

    /// In `stress.json`.
    pub fn solver(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            Self::Gpu => "gpu",
        }
    }

    /// The half of a row.
    pub fn of(self, row: &Row) -> Option<&Side> {
        match self {
            Self::Cpu => Some(&row.cpu),
            Self::Gpu => row.gpu.as_ref(),
        }
    }
}

/// An error and a warning: which of them there were.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Beyond the limit, and said so.
    Caught,
    /// Beyond the limit in silence.
    Missed,
    /// Warned about, but safe.
    FalseAlarm,
    /// Safe in silence.
    Quiet,
}

/// The sides that a row has.
pub fn sides(row: &Row) -> impl Iterator<Item = (Half, &Side)> {
    let both = Half::BOTH.into_iter();
    both.filter_map(move |half| Some((half, half.of(row)?)))
}

/// Standard errors of a traced truth that leave doubt about a verdict.
const DOUBT: f64 = 2.0;

/// Error against warning. A leak is all that is judged where one is: a warning may well be about the
/// rest.
pub fn outcome(measure: &str, side: &Side) -> Outcome {
    match (beyond(measure, side), side.warned()) {
        (true, true) => Outcome::Caught,
        (true, false) => Outcome::Missed,
        (false, true) if measure != LEAK => Outcome::FalseAlarm,
        (false, _) => Outcome::Quiet,
    }
}

/// Whether a side is beyond the limit; where the truth's own noise leaves doubt, the warning is right.
pub fn beyond(measure: &str, side: &Side) -> bool {
    let doubt = if side.warned() { DOUBT } else { -DOUBT };
    let doubted = side.error.map(|error| error + doubt * side.noise);
    match side.noise > 0.0 {
        true => Verdict::of(measure, doubted) != Verdict::Safe,
        false => side.verdict != Verdict::Safe,
    }
}

/// The values of a sweep, in order of severity.
pub fn values(study: &Study) -> Vec<f64> {
    let mut values: Vec<f64> = Vec::new();
    for row in &study.rows {
        if !values.iter().any(|v| v.to_bits() == row.value.to_bits()) {
            values.push(row.value);
        }
    }
    values
}

/// A swept value in three digits: 10⁻⁵ where others have 1.00·10⁻⁵; just below 1 in as many as tell
/// it from 1.
pub fn value(x: f64) -> String {
    below_one(x).unwrap_or_else(|| digits(format!("{x:.2e}"), x))
}

/// The same in two digits, where there is little room.
pub fn value_short(x: f64) -> String {
    let rounded = format!("{x:.1e}");
    if x >= 1e4 {
        return trimmed(&power(&rounded));
    }
    below_one(x).unwrap_or_else(|| digits(rounded, x))
}

fn below_one(x: f64) -> Option<String> {
    let left = 1.0 - x;
    (left > 1e-12 && left < 0.1).then(|| {
        let digits = 1 - left.log10().floor() as i32;
        let text = format!("{x:.*}", usize::try_from(digits).unwrap_or_default());
        text.trim_end_matches('0').into()
    })
}

fn digits(rounded: String, x: f64) -> String {
    trimmed(&number(rounded.parse().unwrap_or(x)))
}

fn trimmed(text: &str) -> String {
    let text = text
        .replace(".00·", "·")
        .replace(".0·", "·")
        .replace("0·", "·");
    match text.strip_prefix("1·") {
        Some(power) => power.into(),
        None => text,
    }
}

/// An amount of a measure: a share in per cent, or what leaks as it is.
pub fn amount(measure: &str, error: f64) -> String {
    if measure == LEAK {
        value(error)
    } else {
        percent(error)
    }
}

/// An error as the tables show it.
pub fn error(side: &Side, measure: &str) -> String {
    match side.error {
        Some(error) => amount(measure, error),
        None if side.broke() => "nothing".into(),
        None => "refused".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::side;
    use super::super::{DEGRADED, RELATIVE, SAFE};
    use super::*;

    #[test]
    fn a_refusal_is_a_warning_and_a_panic_is_none() {
        let says = |text: &str| Side {
            message: Some(text.into()),
            ..side(None, "")
        };
        let refusal = says("face 3 has no area: remove it");
        assert_eq!(outcome(RELATIVE, &refusal), Outcome::Caught);
        assert!(!refusal.broke());
        let panic = says("panic: index out of bounds");
        assert_eq!(outcome(RELATIVE, &panic), Outcome::Missed);
        assert!(panic.broke());
        let mut silent = side(None, "");
        silent.message = None;
        assert!(silent.broke() && silent.verdict == Verdict::Fails);
        assert!(side(Some(f64::NAN), "thin").broke());
    }

    #[test]
    fn a_warning_beside_a_tight_wall_is_no_false_alarm() {
        let warned = side(Some(0.0), "thin");
        assert_eq!(outcome(RELATIVE, &warned), Outcome::FalseAlarm);
        assert_eq!(outcome(LEAK, &warned), Outcome::Quiet);
    }

    #[test]
    fn limits_belong_to_the_better_verdict() {
        let of = |error: f64| side(Some(error), "").verdict;
        assert_eq!(
            [of(SAFE), of(0.021), of(DEGRADED), of(0.11)],
            [
                Verdict::Safe,
                Verdict::Degrades,
                Verdict::Degrades,
                Verdict::Fails
            ]
        );
        assert_eq!(of(f64::INFINITY), Verdict::Fails);
        let told = [RELATIVE, LEAK].map(|measure| amount(measure, 1e-4));
        assert_eq!(told, ["0.01\u{202f}%", "10⁻⁴"]);
    }

    #[test]
    fn values_are_short() {
        assert_eq!(
            [1e-5, 5e-7, 1.0 / 6.0, 1e6, 2.5e-9].map(value),
            ["10⁻⁵", "5·10⁻⁷", "0.167", "10⁶", "2.5·10⁻⁹"]
        );
        assert_eq!(
            [0.99, 0.99999, 0.975].map(value),
            ["0.99", "0.99999", "0.975"]
        );
        assert_eq!(
            [0.01852, 1.85e-6, 9000.0, 1e4, 2.5e5].map(value_short),
            ["0.019", "1.9·10⁻⁶", "9000", "10⁴", "2.5·10⁵"]
        );
    }
}
