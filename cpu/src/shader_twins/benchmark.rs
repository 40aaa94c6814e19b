//! Measurement of the machine: copies, and multiplications and additions.

use common::constants::MULTIPLY_ROUNDS;
use glam::Vec4;

/// Copies `source` to `sink`.
pub fn copy_values(source: &[Vec4], sink: &mut [Vec4]) {
    sink.copy_from_slice(source);
}

/// Returns the end of four chains of multiplications and additions that begin at `x`.
pub fn multiply_values(x: Vec4) -> Vec4 {
    let [mut a, mut b, mut c, mut d] = [x, x + 1.0, x + 2.0, x + 3.0];
    for _ in 0..MULTIPLY_ROUNDS {
        a = a * x + b;
        b = b * x + c;
        c = c * x + d;
        d = d * x + a;
    }
    a + b + c + d
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_multiply_to_the_last_chains_start() {
        // With x = 0 each round copies b to a, c to b, d to c, and a to d.
        let [mut a, mut b, mut c, mut d] = [0.0, 1.0, 2.0, 3.0];
        for _ in 0..MULTIPLY_ROUNDS {
            (a, b, c) = (b, c, d);
            d = a;
        }
        assert_eq!(multiply_values(Vec4::ZERO), Vec4::splat(a + b + c + d));
    }

    #[test]
    fn copies_are_equal() {
        let mut sink = [Vec4::ZERO; 2];
        copy_values(&[Vec4::X, Vec4::Y], &mut sink);
        assert_eq!(sink, [Vec4::X, Vec4::Y]);
    }
}
