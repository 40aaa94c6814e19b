//! The front: points of which none is both faster and more accurate.

/// Whether each (seconds, error) is on the front. One that is as fast and as accurate as another
/// stays beside it; what is not a number is never on it.
pub fn front(points: &[(f64, f64)]) -> Vec<bool> {
    let usable = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite();
    let better = |a: &(f64, f64), b: &(f64, f64)| a.0 <= b.0 && a.1 <= b.1 && a != b;
    let beaten = |p| points.iter().filter(|q| usable(q)).any(|q| better(q, p));
    points.iter().map(|p| usable(p) && !beaten(p)).collect()
}

/// The fastest whose error is at most `error`.
pub fn fastest(points: &[(f64, f64)], error: f64) -> Option<usize> {
    let reaches = |k: &usize| points[*k].1 <= error && points[*k].0.is_finite();
    (0..points.len())
        .filter(reaches)
        .min_by(|a, b| points[*a].0.total_cmp(&points[*b].0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dominated_are_off() {
        let points = [(1.0, 0.5), (2.0, 0.5), (1.0, 0.6), (2.0, 0.4), (3.0, 0.1)];
        assert_eq!(front(&points), [true, false, false, true, true]);
    }

    #[test]
    fn equals_stay_beside_each_other() {
        assert_eq!(front(&[(1.0, 0.5), (1.0, 0.5)]), [true, true]);
        assert_eq!(
            front(&[(1.0, 0.5), (1.0, 0.5), (0.5, 0.5)]),
            [false, false, true]
        );
        assert!(front(&[]).is_empty());
    }

    #[test]
    fn what_is_no_number_is_never_on_it_and_beats_nobody() {
        let points = [
            (f64::NAN, 0.1),
            (1.0, f64::NAN),
            (f64::NEG_INFINITY, 0.0),
            (0.5, f64::INFINITY),
            (2.0, 0.2),
        ];
        assert_eq!(front(&points), [false, false, false, false, true]);
    }

    #[test]
    fn the_fastest_reaches_the_error() {
        let points = [(1.0, 0.5), (3.0, 0.01), (2.0, 0.02), (0.1, f64::NAN)];
        assert_eq!(fastest(&points, 0.02), Some(2));
        assert_eq!(fastest(&points, 1.0), Some(0));
        assert_eq!(fastest(&points, 0.001), None);
    }
}
