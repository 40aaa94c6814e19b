//! Break points: how far the parameter may go.

use super::groups::names;
use super::outcome::Half;
use super::{Side, Study, limits};
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
