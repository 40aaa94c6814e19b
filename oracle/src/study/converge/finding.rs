//! Whether a curve still falls at its end, and if not, what its floor is made of.

use super::Point;

/// A last step with less than this order counts as none: halving h takes 16 % off the error.
const STALLED: f64 = 0.25;
/// So does a whole curve with less than this: the slowest law known here, that of shadow edges cut
/// by a grid, has order ½.
const LEVEL: f64 = 0.35;
/// Errors below this are the rounding of 32-bit sums over thousands of shots.
pub const ROUNDING: f64 = 1e-5;
/// Another parameter sets the floor if refining it takes at least this share off the error.
const MATTERS: f64 = 0.1;

/// What is known about a curve.
pub struct Evidence<'a> {
    /// Coarse to fine.
    pub points: &'a [Point],
    /// The fitted order.
    pub order: Option<f64>,
    /// The slope of the last two points.
    pub last: Option<f64>,
    /// The last point's error with another parameter made finer (in its truth, too).
    pub refined: Vec<(String, f64)>,
}

impl Evidence<'_> {
    /// Whether the last step, or the whole curve, gains next to nothing, rounding apart.
    pub fn stalled(&self) -> bool {
        let below = |slope: Option<f64>, least| slope.is_some_and(|slope| slope < least);
        !self.at_rounding() && (below(self.last, STALLED) || below(self.order, LEVEL))
    }

    fn at_rounding(&self) -> bool {
        self.points.last().is_some_and(|last| last.error < ROUNDING)
    }
}

/// Whether the curve converges as far as it was followed, and the reason in words.
pub fn finding(evidence: &Evidence) -> (bool, String) {
    let (Some(first), Some(last)) = (evidence.points.first(), evidence.points.last()) else {
        return (false, "no points".into());
    };
    if first.error < ROUNDING && last.error < ROUNDING {
        let text = "no error to measure: this parameter does not matter here";
        return (true, text.into());
    }
    if evidence.at_rounding() {
        return (true, "falls to the rounding of 32-bit numbers".into());
    }
    if !evidence.stalled() {
        return (
            true,
            match evidence.order {
                Some(order) => format!(
                    "falls to the end: half the step divides the error by {:.1}",
                    order.exp2()
                ),
                None => "too few points for an order".into(),
            },
        );
    }
    (false, floor(evidence, last.error))
}

/// Why the error no longer falls.
fn floor(evidence: &Evidence, error: f64) -> String {
    let start = format!(
        "stops at {} %: the last step has order {:.2}",
        percent(error),
        evidence.last.unwrap_or(0.0)
    );
    if evidence.refined.is_empty() {
        return format!("{start}; there is nothing else to refine");
    }
    let best = evidence
        .refined
        .iter()
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, refined)| *refined < (1.0 - MATTERS) * error);
    let tried: Vec<String> = evidence
        .refined
        .iter()
        .map(|(text, refined)| format!("{text}: {} %", percent(*refined)))
        .collect();
    match best {
        Some((text, refined)) => format!(
            "{start}; the floor is set by another parameter: {text} lowers it to {} % (tried: {})",
            percent(*refined),
            tried.join("; ")
        ),
        None => format!(
            "{start}; no other parameter lowers it (tried: {}): it is this parameter's own error, not yet where it falls steadily, or the method's",
            tried.join("; ")
        ),
    }
}

fn percent(x: f64) -> String {
    crate::show::number::number(100.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(errors: &[f64]) -> Vec<Point> {
        let point = |(k, error): (usize, &f64)| Point {
            value: (1 << k) as f64,
            error: *error,
            bias: 0.0,
            seconds: 1.0,
            shots: 1,
        };
        errors.iter().enumerate().map(point).collect()
    }

    fn told(errors: &[f64], last: f64, refined: &[(&str, f64)]) -> (bool, String) {
        finding(&Evidence {
            points: &points(errors),
            order: Some(1.0),
            last: Some(last),
            refined: refined.iter().map(|(t, e)| ((*t).to_owned(), *e)).collect(),
        })
    }

    #[test]
    fn each_way_to_end_has_its_words() {
        let cases = [
            (
                told(&[0.1, 0.05], 1.0, &[]),
                true,
                "divides the error by 2.0",
            ),
            (told(&[0.1, 1e-6], 9.0, &[]), true, "rounding"),
            (told(&[1e-7, 2e-7], -1.0, &[]), true, "does not matter"),
            (told(&[0.1, 0.1], 0.0, &[]), false, "nothing else"),
            (
                told(&[0.1, 0.1], 0.0, &[("cells 4 → 8", 0.02)]),
                false,
                "set by another parameter: cells 4 → 8 lowers it to 2 %",
            ),
            (
                told(&[0.1, 0.1], 0.0, &[("cells 4 → 8", 0.099)]),
                false,
                "parameter's own",
            ),
        ];
        for ((converges, text), expected, words) in cases {
            assert_eq!(converges, expected, "{text}");
            assert!(text.contains(words), "{words}: {text}");
        }
    }
}
