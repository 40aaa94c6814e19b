//! Quadrature on [−1, 1]: Gauss–Legendre, and tanh-sinh for integrands with singularities at the ends.

use std::f64::consts::PI;
use std::sync::LazyLock;

/// Highest order of the tabulated Gauss–Legendre rules.
pub const MAX_GAUSS_ORDER: usize = 32;

/// Nodes and weights.
pub type QuadratureRule = Vec<(f64, f64)>;

/// Returns the Gauss–Legendre rule of order n, exact for polynomials of degree 2n − 1.
pub fn gauss_legendre(n: usize) -> &'static QuadratureRule {
    static RULES: LazyLock<Vec<QuadratureRule>> = LazyLock::new(|| (0..=MAX_GAUSS_ORDER).map(legendre_rule).collect());
    &RULES[n.min(MAX_GAUSS_ORDER)]
}

/// Computes the roots of Pₙ by Newton's method from Tricomi's guess; weights 2/((1 − x²)P′ₙ²).
fn legendre_rule(n: usize) -> QuadratureRule {
    (0..n)
        .map(|k| {
            let mut x = (PI * (k as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 0.0;
            // Quadratic convergence from 1e−2: five steps reach rounding.
            for _ in 0..8 {
                let (value, derivative) = legendre_polynomial(n, x);
                slope = derivative;
                x -= value / derivative;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// Returns Pₙ(x) and its derivative by the three-term recurrence.
fn legendre_polynomial(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        (before, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
    }
    if n == 0 {
        return (1.0, 0.0);
    }
    (value, n as f64 * (x * value - before) / (x * x - 1.0))
}

/// Returns the tanh-sinh rule (Takahasi & Mori 1974) on an interval of length 1: each (distance, weight) counts
/// twice, once from either end, which avoids cancellation near an end.
pub fn tanh_sinh() -> &'static QuadratureRule {
    /// Step at which the error is rounding only, for integrands analytic inside, with singularities at an end.
    const STEP_LENGTH: f64 = 1.0 / 16.0;
    static RULE: LazyLock<QuadratureRule> = LazyLock::new(|| {
        (0..=56)
            .map(|k| {
                let u = f64::from(k) * STEP_LENGTH;
                let v = PI / 2.0 * u.sinh();
                // 1/(1 + e^{2v}) is the distance from the end, without cancellation.
                let share = 1.0 / (1.0 + (2.0 * v).exp());
                let weight = PI / 4.0 * u.cosh() / v.cosh().powi(2) * STEP_LENGTH;
                (share, if k == 0 { weight / 2.0 } else { weight })
            })
            .collect()
    });
    &RULE
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;

    #[test]
    fn gauss_integrates_polynomials_and_tanh_sinh_logarithms() {
        for n in 1..=MAX_GAUSS_ORDER {
            let degree = 2 * n as i32 - 2;
            let sum: f64 = gauss_legendre(n).iter().map(|(x, w)| w * x.powi(degree)).sum();
            let exact = 2.0 / f64::from(degree + 1);
            assert!(abs_diff_eq!(sum / exact, 1.0, epsilon = 1e-13), "{n}: {sum}");
        }
        // ∫₀¹ ln x dx = −1, and by symmetry from the other end.
        let sum: f64 = tanh_sinh().iter().map(|(x, w)| w * (x.ln() + (-x).ln_1p())).sum();
        assert!((sum + 1.0).abs() < 1e-13, "{sum}");
    }
}
