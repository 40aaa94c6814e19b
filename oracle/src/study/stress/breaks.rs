//! Break points: how far the parameter may go.

use super::groups::names;
use super::outcome::Half;
use super::{Side, Study, limits, outcome};
use serde::Serialize;

/// Of one method on one solver.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Break {
    /// The method.
    pub method: &'static str,
    /// The solver.
    pub solver: Half,
    /// Safe, and then not.
    pub safe: Reach,
    /// Degraded at most, and then failing.
    pub degraded: Reach,
}

/// Up to where an error stays within a limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Reach {
    /// The limit.
    pub limit: f64,
    /// The last value up to which every error is within it; none: not even the first.
    pub to: Option<f64>,
    /// The first value beyond it; none: nowhere in the sweep.
    pub breaks_at: Option<f64>,
}

/// Of all methods of a case, in the order of its rows.
pub fn of(study: &Study) -> Vec<Break> {
    let mut breaks = Vec::new();
    for method in names([study]) {
        for solver in Half::BOTH {
            let rows = study.rows.iter().filter(|row| row.method == method);
            let sides = rows.filter_map(|row| Some((row.value, solver.of(row)?)));
            let sides: Vec<(f64, &Side)> = sides.collect();
            if !sides.is_empty() {
                let [safe, degraded] =
                    limits(study.about.measure).map(|limit| reach(&sides, limit));
                breaks.push(Break {
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

fn reach(sides: &[(f64, &Side)], limit: f64) -> Reach {
    let within = |side: &Side| side.error.is_some_and(|error| error <= limit);
    let first = sides.iter().position(|(_, side)| !within(side));
    let last = first.unwrap_or(sides.len()).checked_sub(1);
    Reach {
        limit,
        to: last.map(|k| sides[k].0),
        breaks_at: first.map(|k| sides[k].0),
    }
}

/// Where the methods are no longer safe, the easiest value first, then those that are so everywhere: the
/// value, none in the last, and who.
pub fn in_order(study: &Study) -> Vec<(Option<f64>, Vec<String>)> {
    let breaks = of(study);
    let values = outcome::values(study).into_iter().map(Some);
    let at = |value: Option<f64>| {
        let here = |one: &&Break| one.safe.breaks_at == value;
        let mut who: Vec<String> = Vec::new();
        for method in names([study]) {
            let all = breaks.iter().filter(|one| one.method == method);
            let own: Vec<&Break> = all.clone().filter(here).collect();
            match own[..] {
                [] => {}
                [one] if all.count() > 1 => who.push(format!("{method} ({})", one.solver.name())),
                _ => who.push(method.to_owned()),
            }
        }
        (value, who)
    };
    let all = values.chain([None]).map(at);
    all.filter(|(_, who)| !who.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{row, side, study};
    use super::*;

    #[test]
    fn who_breaks_first_is_told_first() {
        let of = |method, value, cpu: f64, gpu: f64| {
            let mut one = row(value, side(Some(cpu), ""), Some(side(Some(gpu), "")));
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
        let told = in_order(&study("one", rows));
        let expected = [
            (Some(1.0), vec!["paper"]),
            (Some(0.1), vec!["disc (GPU)"]),
            (None, vec!["default", "disc (CPU)"]),
        ];
        assert_eq!(told.len(), expected.len());
        for ((value, who), wanted) in told.iter().zip(&expected) {
            assert_eq!(
                (value, who.iter().map(String::as_str).collect()),
                (&wanted.0, wanted.1.clone())
            );
        }
    }
}
