//! Outcome of one solver's result in a row, and the text of values and errors.

use super::{AtlasRow, CaseStudy, LEAK_MEASURE, SolverSide, Verdict};
use crate::report::format::{format_number, format_percent, format_scientific};
use serde::Serialize;

/// Processor of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Processor {
    /// CPU.
    Cpu,
    /// GPU.
    Gpu,
}

impl Processor {
    /// Both, in the order of the page.
    pub const BOTH: [Self; 2] = [Self::Cpu, Self::Gpu];

    /// Returns the name on the page.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu => "CPU",
            Self::Gpu => "GPU",
        }
    }

    /// Returns the name in `stress.json`.
    pub fn json_name(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            Self::Gpu => "gpu",
        }
    }

    /// Returns its result in a row.
    pub fn side_of(self, row: &AtlasRow) -> Option<&SolverSide> {
        match self {
            Self::Cpu => Some(&row.cpu),
            Self::Gpu => row.gpu.as_ref(),
        }
    }
}

/// Combination of error and warning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WarningOutcome {
    /// Beyond the limit, with a warning.
    Caught,
    /// Beyond the limit, without a warning.
    Missed,
    /// Safe, with a warning.
    FalseAlarm,
    /// Safe, without a warning.
    Quiet,
}

/// Iterates over the results of a row.
pub fn solver_sides(row: &AtlasRow) -> impl Iterator<Item = (Processor, &SolverSide)> {
    let both = Processor::BOTH.into_iter();
    both.filter_map(move |processor| Some((processor, processor.side_of(row)?)))
}

/// Half-width of the confidence interval of an error, standard errors of the traced truth.
const CONFIDENCE_SIGMAS: f64 = 2.0;

/// Returns the outcome of a result. For a leak there are no false alarms, since the warning may
/// concern the light elsewhere.
pub fn warning_outcome(measure: &str, side: &SolverSide) -> WarningOutcome {
    match (is_beyond(measure, side), side.is_warned()) {
        (true, true) => WarningOutcome::Caught,
        (true, false) => WarningOutcome::Missed,
        (false, true) if measure != LEAK_MEASURE => WarningOutcome::FalseAlarm,
        (false, _) => WarningOutcome::Quiet,
    }
}

/// Returns whether the error is beyond the limit; within the truth's noise the warning decides.
pub fn is_beyond(measure: &str, side: &SolverSide) -> bool {
    let doubt = if side.is_warned() {
        CONFIDENCE_SIGMAS
    } else {
        -CONFIDENCE_SIGMAS
    };
    let doubted = side.error.map(|error| error + doubt * side.noise);
    match side.noise > 0.0 {
        true => Verdict::of_error(measure, doubted) != Verdict::Safe,
        false => side.verdict != Verdict::Safe,
    }
}

/// Returns the values of a sweep, easy to hard.
pub fn swept_values(study: &CaseStudy) -> Vec<f64> {
    let mut values: Vec<f64> = Vec::new();
    for row in &study.rows {
        if !values.iter().any(|v| v.to_bits() == row.value.to_bits()) {
            values.push(row.value);
        }
    }
    values
}

/// Formats a value in three digits, without trailing zeros; just below 1 in as many digits as differ
/// from 1.
pub fn format_value(x: f64) -> String {
    format_below_one(x).unwrap_or_else(|| format_digits(format!("{x:.2e}"), x))
}

/// Formats a value in two digits.
pub fn format_short_value(x: f64) -> String {
    let rounded = format!("{x:.1e}");
    if x >= 1e4 {
        return trim_zeros(&format_scientific(&rounded));
    }
    format_below_one(x).unwrap_or_else(|| format_digits(rounded, x))
}

fn format_below_one(x: f64) -> Option<String> {
    let remainder = 1.0 - x;
    (remainder > 1e-12 && remainder < 0.1).then(|| {
        let digits = 1 - remainder.log10().floor() as i32;
        let text = format!("{x:.*}", usize::try_from(digits).unwrap_or_default());
        text.trim_end_matches('0').into()
    })
}

fn format_digits(rounded: String, x: f64) -> String {
    trim_zeros(&format_number(rounded.parse().unwrap_or(x)))
}

fn trim_zeros(text: &str) -> String {
    let text = text.replace(".00·", "·").replace(".0·", "·").replace("0·", "·");
    match text.strip_prefix("1·") {
        Some(power) => power.into(),
        None => text,
    }
}

/// Formats an error: a relative RMS in per cent, a leak as a number.
pub fn format_amount(measure: &str, error: f64) -> String {
    if measure == LEAK_MEASURE {
        format_value(error)
    } else {
        format_percent(error)
    }
}

/// Formats a result's error for the tables.
pub fn format_error(side: &SolverSide, measure: &str) -> String {
    match side.error {
        Some(error) => format_amount(measure, error),
        None if side.is_broken() => "nothing".into(),
        None => "refused".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::make_side;
    use super::super::{DEGRADED_ERROR, RELATIVE_RMS, SAFE_ERROR};
    use super::*;

    #[test]
    fn refusal_counts_as_warning_and_panic_does_not() {
        let says = |text: &str| SolverSide {
            message: Some(text.into()),
            ..make_side(None, "")
        };
        let refusal = says("face 3 has no area: remove it");
        assert_eq!(warning_outcome(RELATIVE_RMS, &refusal), WarningOutcome::Caught);
        assert!(!refusal.is_broken());
        let panic = says("panic: index out of bounds");
        assert_eq!(warning_outcome(RELATIVE_RMS, &panic), WarningOutcome::Missed);
        assert!(panic.is_broken());
        let mut silent = make_side(None, "");
        silent.message = None;
        assert!(silent.is_broken() && silent.verdict == Verdict::Fails);
        assert!(make_side(Some(f64::NAN), "thin").is_broken());
    }

    #[test]
    fn warning_in_a_leak_case_is_no_false_alarm() {
        let warned = make_side(Some(0.0), "thin");
        assert_eq!(warning_outcome(RELATIVE_RMS, &warned), WarningOutcome::FalseAlarm);
        assert_eq!(warning_outcome(LEAK_MEASURE, &warned), WarningOutcome::Quiet);
    }

    #[test]
    fn error_equal_to_a_limit_gets_the_better_verdict() {
        let of = |error: f64| make_side(Some(error), "").verdict;
        assert_eq!(
            [of(SAFE_ERROR), of(0.021), of(DEGRADED_ERROR), of(0.11)],
            [Verdict::Safe, Verdict::Degrades, Verdict::Degrades, Verdict::Fails]
        );
        assert_eq!(of(f64::INFINITY), Verdict::Fails);
        let texts = [RELATIVE_RMS, LEAK_MEASURE].map(|measure| format_amount(measure, 1e-4));
        assert_eq!(texts, ["0.01\u{202f}%", "10⁻⁴"]);
    }

    #[test]
    fn values_are_short() {
        assert_eq!(
            [1e-5, 5e-7, 1.0 / 6.0, 1e6, 2.5e-9].map(format_value),
            ["10⁻⁵", "5·10⁻⁷", "0.167", "10⁶", "2.5·10⁻⁹"]
        );
        assert_eq!([0.99, 0.99999, 0.975].map(format_value), ["0.99", "0.99999", "0.975"]);
        assert_eq!(
            [0.01852, 1.85e-6, 9000.0, 1e4, 2.5e5].map(format_short_value),
            ["0.019", "1.9·10⁻⁶", "9000", "10⁴", "2.5·10⁵"]
        );
    }
}
