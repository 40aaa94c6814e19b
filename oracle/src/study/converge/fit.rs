//! The order p of an error e ≈ C hᵖ from measured points.

/// Orders that are looked for.
const ORDERS: std::ops::RangeInclusive<u32> = 1..=800;
/// Their spacing.
const SPACING: f64 = 0.01;

/// The least-squares slope of ln e over ln h; none below two points with both above 0.
pub fn slope(points: &[(f64, f64)]) -> Option<f64> {
    let points = logarithms(points);
    let n = points.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let square: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let product: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    (points.len() >= 2 && square > 0.0).then(|| product / square)
}

/// The order if the truth, a solve with step `h0`, has the same kind of error as the points, of one
/// sign with theirs: e ≈ C (hᵖ − h0ᵖ), which falls faster than hᵖ. The best p in the least-squares
/// sense of ln e; none where no p fits better than the smallest.
pub fn order_beside(points: &[(f64, f64)], h0: f64) -> Option<f64> {
    let usable: Vec<(f64, f64)> = points.iter().copied().filter(|p| p.0 > h0).collect();
    if logarithms(&usable).len() < 2 {
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
    ORDERS
        .map(|k| f64::from(k) * SPACING)
        .min_by(|a, b| misfit(*a).total_cmp(&misfit(*b)))
        .filter(|p| *p > 1.5 * SPACING)
}

/// The slope of the last two points.
pub fn last_slope(points: &[(f64, f64)]) -> Option<f64> {
    slope(&points[points.len().saturating_sub(2)..])
}

fn logarithms(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let usable = |(h, e): &&(f64, f64)| *h > 0.0 && *e > 0.0 && e.is_finite();
    points
        .iter()
        .filter(usable)
        .map(|(h, e)| (h.ln(), e.ln()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;

    fn points(p: f64, h0: f64) -> Vec<(f64, f64)> {
        [0.25, 0.125, 0.0625, 0.03125]
            .map(|h: f64| {
                (
                    h,
                    7.0 * (h.powf(p) - if h0 > 0.0 { h0.powf(p) } else { 0.0 }),
                )
            })
            .to_vec()
    }

    #[test]
    fn powers_are_recognised() {
        for p in [0.5, 1.0, 2.0] {
            assert!(abs_diff_eq!(
                slope(&points(p, 0.0)).unwrap(),
                p,
                epsilon = 1e-12
            ));
            let h0 = 1.0 / 64.0;
            assert!(abs_diff_eq!(
                order_beside(&points(p, h0), h0).unwrap(),
                p,
                epsilon = 1e-9
            ));
            // The plain slope is too steep against a truth that is not exact.
            assert!(slope(&points(p, h0)).unwrap() > p + 0.05);
        }
    }

    #[test]
    fn too_few_points_have_no_order() {
        assert_eq!(slope(&[]), None);
        assert_eq!(slope(&[(0.5, 1.0)]), None);
        assert_eq!(slope(&[(0.5, 1.0), (0.25, 0.0)]), None);
        assert_eq!(order_beside(&[(0.5, 1.0), (0.1, 1.0)], 0.2), None);
        // Independent errors fall more slowly than any such truth allows.
        let level = [(0.5, 1.0), (0.25, 0.95), (0.125, 0.9)];
        assert_eq!(order_beside(&level, 0.0625), None);
        assert_eq!(last_slope(&[]), None);
    }
}
