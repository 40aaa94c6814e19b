//! Break points: the parameter values at which each method stops being accurate.

use super::groups::method_names;
use super::outcome::Processor;
use super::{CaseStudy, SolverSide, error_limits, outcome};
use serde::Serialize;

/// Break points of one method on one solver.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BreakPoint {
    /// Name of the method.
    pub method: &'static str,
    /// The solver.
    pub solver: Processor,
    /// Range in which it is safe.
    pub safe: SafeRange,
    /// Range in which it is degraded at most.
    pub degraded: SafeRange,
}

/// Range of the sweep in which the error stays within a limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SafeRange {
    /// Limit of the error.
    pub limit: f64,
    /// Last value up to which every error is within the limit; none if the first exceeds it.
    pub to: Option<f64>,
    /// First value beyond the limit; none if there is none in the sweep.
    pub breaks_at: Option<f64>,
}

/// Returns the break points of all methods of a case, in the order of its rows.
pub fn find_breaks(study: &CaseStudy) -> Vec<BreakPoint> {
    let mut breaks = Vec::new();
    for method in method_names([study]) {
        for solver in Processor::BOTH {
            let rows = study.rows.iter().filter(|row| row.method == method);
            let sides = rows.filter_map(|row| Some((row.value, solver.side_of(row)?)));
            let sides: Vec<(f64, &SolverSide)> = sides.collect();
            if !sides.is_empty() {
                let [safe, degraded] = error_limits(study.info.measure).map(|limit| range_within(&sides, limit));
                breaks.push(BreakPoint {
                    method,
                    solver,
                    safe,
                    degraded,
                });
            }
        }
    }
    breaks
}

fn range_within(sides: &[(f64, &SolverSide)], limit: f64) -> SafeRange {
    let within = |side: &SolverSide| side.error.is_some_and(|error| error <= limit);
    let first = sides.iter().position(|(_, side)| !within(side));
    let last = first.unwrap_or(sides.len()).checked_sub(1);
    SafeRange {
        limit,
        to: last.map(|k| sides[k].0),
        breaks_at: first.map(|k| sides[k].0),
    }
}

/// Groups the methods by the first value at which they are not safe, in order of the sweep. Methods
/// that are safe everywhere come last, without a value.
pub fn breaks_in_order(study: &CaseStudy) -> Vec<(Option<f64>, Vec<String>)> {
    let breaks = find_breaks(study);
    let values = outcome::swept_values(study).into_iter().map(Some);
    let at = |value: Option<f64>| {
        let here = |one: &&BreakPoint| one.safe.breaks_at == value;
        let mut labels: Vec<String> = Vec::new();
        for method in method_names([study]) {
            let all = breaks.iter().filter(|one| one.method == method);
            let broken_here: Vec<&BreakPoint> = all.clone().filter(here).collect();
            match broken_here[..] {
                [] => {}
                [one] if all.count() > 1 => labels.push(format!("{method} ({})", one.solver.name())),
                _ => labels.push(method.to_owned()),
            }
        }
        (value, labels)
    };
    let all = values.chain([None]).map(at);
    all.filter(|(_, labels)| !labels.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{make_row, make_side, make_study};
    use super::*;

    #[test]
    fn methods_are_listed_in_order_of_breaking() {
        let of = |method, value, cpu: f64, gpu: f64| {
            let mut one = make_row(value, make_side(Some(cpu), ""), Some(make_side(Some(gpu), "")));
            one.method = method;
            one
        };
        let rows = vec![
            of("default", 1.0, 0.01, 0.01),
            of("paper", 1.0, 0.5, 0.5),
            of("disc", 1.0, 0.01, 0.01),
            of("default", 0.1, 0.01, 0.01),
            of("paper", 0.1, 0.01, 0.01),
            of("disc", 0.1, 0.01, 0.05),
        ];
        let listed = breaks_in_order(&make_study("one", rows));
        let expected = [
            (Some(1.0), vec!["paper"]),
            (Some(0.1), vec!["disc (GPU)"]),
            (None, vec!["default", "disc (CPU)"]),
        ];
        assert_eq!(listed.len(), expected.len());
        for ((value, labels), wanted) in listed.iter().zip(&expected) {
            assert_eq!(
                (value, labels.iter().map(String::as_str).collect()),
                (&wanted.0, wanted.1.clone())
            );
        }
    }
}
