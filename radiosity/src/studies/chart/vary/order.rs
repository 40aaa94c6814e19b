//! The order p of an error e ≈ C hᵖ, fitted to the points of a curve; whether the curve falls to its
//! end, and what sets its floor if it does not.

use crate::report::format::format_number;

/// Orders tried by [`fit_order_beside_truth`], in units of [`ORDER_SPACING`].
const TRIED_ORDERS: std::ops::RangeInclusive<u32> = 1..=800;
/// Spacing of the tried orders.
const ORDER_SPACING: f64 = 0.01;
/// A last step of lower order counts as stalled: halving h reduces the error by less than 16 %.
const MIN_LAST_ORDER: f64 = 0.25;
/// A whole curve of lower order counts as stalled: the slowest law here, of shadow edges cut by a
/// grid, has order ½.
const MIN_CURVE_ORDER: f64 = 0.35;
/// Errors below this are rounding of 32-bit sums over thousands of shots.
pub const ROUNDING_ERROR: f64 = 1e-5;
/// Another parameter sets the floor if refining it reduces the error by at least this share.
const MIN_ERROR_REDUCTION: f64 = 0.1;

/// Returns the least-squares slope of ln e over ln h, or none with fewer than two positive points.
pub fn fit_slope(points: &[(f64, f64)]) -> Option<f64> {
    let points = take_logarithms(points);
    let n = points.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let square: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let product: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    (points.len() >= 2 && square > 0.0).then(|| product / square)
}

/// Returns the order p if the truth, a solve with step `h0`, has the same kind and sign of error as
/// the points: e ≈ C (hᵖ − h0ᵖ), which falls faster than hᵖ. The fit is least-squares in ln e; none
/// if no p fits better than the smallest.
pub fn fit_order_beside_truth(points: &[(f64, f64)], h0: f64) -> Option<f64> {
    let usable: Vec<(f64, f64)> = points.iter().copied().filter(|p| p.0 > h0).collect();
    if take_logarithms(&usable).len() < 2 {
        return None;
    }
    let misfit = |p: f64| {
        let offsets: Vec<f64> = usable
            .iter()
            .filter(|point| point.1 > 0.0)
            .map(|(h, e)| e.ln() - (h.powf(p) - h0.powf(p)).ln())
            .collect();
        let mean = offsets.iter().sum::<f64>() / offsets.len() as f64;
        offsets.iter().map(|x| (x - mean).powi(2)).sum::<f64>()
    };
    TRIED_ORDERS
        .map(|k| f64::from(k) * ORDER_SPACING)
        .min_by(|a, b| misfit(*a).total_cmp(&misfit(*b)))
        .filter(|p| *p > 1.5 * ORDER_SPACING)
}

/// Returns the slope of the last two points.
pub fn last_slope(points: &[(f64, f64)]) -> Option<f64> {
    fit_slope(&points[points.len().saturating_sub(2)..])
}

fn take_logarithms(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let usable = |(h, e): &&(f64, f64)| *h > 0.0 && *e > 0.0 && e.is_finite();
    points.iter().filter(usable).map(|(h, e)| (h.ln(), e.ln())).collect()
}

/// Measurements that a finding is based on.
pub struct CurveEvidence {
    /// Errors of the coarsest and the finest point.
    pub ends: [f64; 2],
    /// Fitted order.
    pub order: Option<f64>,
    /// Slope of the last two points.
    pub last: Option<f64>,
    /// Changes that refine another parameter, here and in the truth, and the last point's error with
    /// each.
    pub refined: Vec<(String, f64)>,
}

impl CurveEvidence {
    /// Returns whether the last step or the whole curve has almost no order, above the rounding level.
    pub fn is_stalled(&self) -> bool {
        let below = |slope: Option<f64>, least| slope.is_some_and(|slope| slope < least);
        !self.at_rounding() && (below(self.last, MIN_LAST_ORDER) || below(self.order, MIN_CURVE_ORDER))
    }

    fn at_rounding(&self) -> bool {
        self.ends[1] < ROUNDING_ERROR
    }
}

/// Returns whether the curve converges to its last point, and the reason in words.
pub fn explain_curve(evidence: &CurveEvidence) -> (bool, String) {
    if evidence.ends.iter().all(|error| *error < ROUNDING_ERROR) {
        let text = "no error to measure: this parameter does not matter here";
        return (true, text.into());
    }
    if evidence.at_rounding() {
        return (true, "falls to the rounding of 32-bit numbers".into());
    }
    if !evidence.is_stalled() {
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
    (false, explain_floor(evidence, evidence.ends[1]))
}

/// Explains a stalled curve.
fn explain_floor(evidence: &CurveEvidence, error: f64) -> String {
    let start = format!(
        "stops at {} %: the last step has order {:.2}",
        percent_number(error),
        evidence.last.unwrap_or(0.0)
    );
    if evidence.refined.is_empty() {
        return format!("{start}; there is nothing else to refine");
    }
    let best = evidence
        .refined
        .iter()
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, refined)| *refined < (1.0 - MIN_ERROR_REDUCTION) * error);
    let tried: Vec<String> = evidence
        .refined
        .iter()
        .map(|(text, refined)| format!("{text}: {} %", percent_number(*refined)))
        .collect();
    match best {
        Some((text, refined)) => format!(
            "{start}; the floor is set by another parameter: {text} lowers it to {} % (tried: {})",
            percent_number(*refined),
            tried.join("; ")
        ),
        None => format!(
            "{start}; no other parameter lowers it (tried: {}): it is this parameter's own error, not yet where it falls steadily, or the method's",
            tried.join("; ")
        ),
    }
}

fn percent_number(x: f64) -> String {
    format_number(100.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;

    fn power_law(p: f64, h0: f64) -> Vec<(f64, f64)> {
        let offset = if h0 > 0.0 { h0.powf(p) } else { 0.0 };
        let steps = [0.25, 0.125, 0.0625, 0.03125];
        steps.map(|h: f64| (h, 7.0 * (h.powf(p) - offset))).to_vec()
    }

    #[test]
    fn order_of_a_power_law_is_recovered() {
        for p in [0.5, 1.0, 2.0] {
            assert!(abs_diff_eq!(fit_slope(&power_law(p, 0.0)).unwrap(), p, epsilon = 1e-12));
            let h0 = 1.0 / 64.0;
            assert!(abs_diff_eq!(
                fit_order_beside_truth(&power_law(p, h0), h0).unwrap(),
                p,
                epsilon = 1e-9
            ));
            // Against an inexact truth the plain slope is too steep.
            assert!(fit_slope(&power_law(p, h0)).unwrap() > p + 0.05);
        }
    }

    #[test]
    fn too_few_points_have_no_order() {
        assert_eq!(fit_slope(&[]), None);
        assert_eq!(fit_slope(&[(0.5, 1.0)]), None);
        assert_eq!(fit_slope(&[(0.5, 1.0), (0.25, 0.0)]), None);
        assert_eq!(fit_order_beside_truth(&[(0.5, 1.0), (0.1, 1.0)], 0.2), None);
        // Independent errors fall too slowly for this law.
        let level = [(0.5, 1.0), (0.25, 0.95), (0.125, 0.9)];
        assert_eq!(fit_order_beside_truth(&level, 0.0625), None);
        assert_eq!(last_slope(&[]), None);
    }

    #[test]
    fn each_kind_of_ending_has_its_text() {
        let floor = "set by another parameter: patches 4 → 8 lowers it to 2 %";
        let refined = |error| vec![("patches 4 → 8".to_owned(), error)];
        let cases = [
            ([0.1, 0.05], 1.0, vec![], true, "divides the error by 2.0"),
            ([0.1, 1e-6], 9.0, vec![], true, "rounding"),
            ([1e-7, 2e-7], -1.0, vec![], true, "does not matter"),
            ([0.1, 0.1], 0.0, vec![], false, "nothing else"),
            ([0.1, 0.1], 0.0, refined(0.02), false, floor),
            ([0.1, 0.1], 0.0, refined(0.099), false, "parameter's own"),
        ];
        for (errors, last, refined, expected, words) in cases {
            let (converges, text) = explain_curve(&CurveEvidence {
                ends: errors,
                order: Some(1.0),
                last: Some(last),
                refined,
            });
            assert_eq!(converges, expected, "{text}");
            assert!(text.contains(words), "{words}: {text}");
        }
    }
}
