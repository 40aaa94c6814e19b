//! The Pareto front: the points that no other point beats in both time and error.

/// Returns for each (seconds, error) point whether it is on the Pareto front. Equal points are both
/// on it; a point with a value that is not finite is not.
pub fn pareto_front(points: &[(f64, f64)]) -> Vec<bool> {
    let usable = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite();
    let better = |a: &(f64, f64), b: &(f64, f64)| a.0 <= b.0 && a.1 <= b.1 && a != b;
    let beaten = |p| points.iter().filter(|q| usable(q)).any(|q| better(q, p));
    points.iter().map(|p| usable(p) && !beaten(p)).collect()
}

/// Returns the index of the fastest point whose error is at most `error`.
pub fn fastest_within(points: &[(f64, f64)], error: f64) -> Option<usize> {
    let reaches = |k: &usize| points[*k].1 <= error && points[*k].0.is_finite();
    (0..points.len())
        .filter(reaches)
        .min_by(|a, b| points[*a].0.total_cmp(&points[*b].0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dominated_points_are_off_the_front() {
        let points = [(1.0, 0.5), (2.0, 0.5), (1.0, 0.6), (2.0, 0.4), (3.0, 0.1)];
        assert_eq!(pareto_front(&points), [true, false, false, true, true]);
    }

    #[test]
    fn equal_points_are_both_on_the_front() {
        assert_eq!(pareto_front(&[(1.0, 0.5), (1.0, 0.5)]), [true, true]);
        assert_eq!(
            pareto_front(&[(1.0, 0.5), (1.0, 0.5), (0.5, 0.5)]),
            [false, false, true]
        );
        assert!(pareto_front(&[]).is_empty());
    }

    #[test]
    fn points_that_are_not_finite_are_off_the_front_and_dominate_none() {
        let points = [
            (f64::NAN, 0.1),
            (1.0, f64::NAN),
            (f64::NEG_INFINITY, 0.0),
            (0.5, f64::INFINITY),
            (2.0, 0.2),
        ];
        assert_eq!(pareto_front(&points), [false, false, false, false, true]);
    }

    #[test]
    fn fastest_point_within_the_error_is_found() {
        let points = [(1.0, 0.5), (3.0, 0.01), (2.0, 0.02), (0.1, f64::NAN)];
        assert_eq!(fastest_within(&points, 0.02), Some(2));
        assert_eq!(fastest_within(&points, 1.0), Some(0));
        assert_eq!(fastest_within(&points, 0.001), None);
    }
}
