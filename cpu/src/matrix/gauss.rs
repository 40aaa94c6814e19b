//! Quadrature on [−1, 1]: Gauss–Legendre, and tanh-sinh for what is singular at its ends.

use std::f64::consts::PI;
use std::sync::LazyLock;

/// Highest order of the tabulated Gauss–Legendre rules.
pub const HIGHEST: usize = 32;

/// Nodes and weights.
pub type Rule = Vec<(f64, f64)>;

/// Gauss–Legendre of order n, exact for polynomials of degree 2n − 1.
pub fn gauss(n: usize) -> &'static Rule {
    static RULES: LazyLock<Vec<Rule>> = LazyLock::new(|| (0..=HIGHEST).map(legendre).collect());
    &RULES[n.min(HIGHEST)]
}

/// The roots of Pₙ by Newton's method from Tricomi's guess; weights 2/((1 − x²)P′ₙ²).
fn legendre(n: usize) -> Rule {
    (0..n)
        .map(|k| {
            let mut x = (PI * (k as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 0.0;
            // Quadratic convergence from 1e−2: five steps reach rounding.
            for _ in 0..8 {
                let (value, derivative) = polynomial(n, x);
                slope = derivative;
                x -= value / derivative;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// Pₙ(x) and its derivative by the three-term recurrence.
fn polynomial(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        (before, value) = (
            value,
            ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k,
        );
    }
    if n == 0 {
        return (1.0, 0.0);
    }
    (value, n as f64 * (x * value - before) / (x * x - 1.0))
}

/// Tanh-sinh (Takahasi & Mori 1974) on an interval of length 1: each (distance, weight) counts
/// twice, once from either end, so that nothing is lost to cancellation beside an end.
pub fn tanh_sinh() -> &'static Rule {
    /// Step 1/16: rounding only for what is analytic inside, and for singularities beside an end.
    const STEP: f64 = 1.0 / 16.0;
    static RULE: LazyLock<Rule> = LazyLock::new(|| {
        (0..=56)
            .map(|k| {
                let u = f64::from(k) * STEP;
                let v = PI / 2.0 * u.sinh();
                // 1/(1 + e^{2v}) is the distance from the end, without cancellation.
                let share = 1.0 / (1.0 + (2.0 * v).exp());
                let weight = PI / 4.0 * u.cosh() / v.cosh().powi(2) * STEP;
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
    fn rules_integrate_what_they_should() {
        for n in 1..=HIGHEST {
            let degree = 2 * n as i32 - 2;
            let sum: f64 = gauss(n).iter().map(|(x, w)| w * x.powi(degree)).sum();
            let exact = 2.0 / f64::from(degree + 1);
            assert!(
                abs_diff_eq!(sum / exact, 1.0, epsilon = 1e-13),
                "{n}: {sum}"
            );
        }
        // ∫₀¹ ln x dx = −1, and by symmetry from the other end.
        let sum: f64 = tanh_sinh()
            .iter()
            .map(|(x, w)| w * (x.ln() + (-x).ln_1p()))
            .sum();
        assert!((sum + 1.0).abs() < 1e-13, "{sum}");
    }
}
