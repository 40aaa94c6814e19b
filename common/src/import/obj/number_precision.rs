//! Estimates the rounding of an OBJ file's coordinates, by which [`crate::precision`] finds misshapen faces. A program
//! writes all numbers with the same number of decimals, or with the same number of significant digits.

/// Fewest significant digits of a rounded number; shorter numbers count as exact (552.8 mm).
const MIN_ROUNDED_DIGITS: i32 = 6;
/// Fewest different last digits of rounded numbers; exact numbers end in few (.5, .25 and .75).
const MIN_ROUNDED_ENDINGS: u32 = 3;

/// Number of digits of a file's coordinates.
#[derive(Clone, Copy, Debug, Default)]
pub struct NumberPrecision {
    /// Largest number of decimals, exponent included.
    decimals: i32,
    /// Largest number of significant digits.
    significant: i32,
    /// Last digits of the numbers with the most significant digits: bit d stands for digit d.
    last_digits: u16,
}

impl NumberPrecision {
    /// Records a coordinate.
    pub fn record_number(&mut self, word: &str) {
        let (mantissa, exponent) = word.split_once(['e', 'E']).unwrap_or((word, "0"));
        let (Some((_, fraction)), Ok(exponent)) = (mantissa.split_once('.'), exponent.parse::<i32>()) else {
            return;
        };
        let digits = mantissa.bytes().filter(u8::is_ascii_digit);
        let significant = digits.skip_while(|d| *d == b'0').count() as i32;
        if significant > self.significant {
            (self.significant, self.last_digits) = (significant, 0);
        }
        let last = fraction.bytes().last();
        if let Some(last) = last.filter(|_| significant == self.significant) {
            self.last_digits |= 1 << (last.wrapping_sub(b'0') & 15);
        }
        let decimals = (fraction.len() as i32).saturating_sub(exponent);
        self.decimals = self.decimals.max(decimals);
    }

    /// Returns the largest rounding error of a coordinate x.
    pub fn rounding_error(&self, x: f64) -> f64 {
        let endings = self.last_digits.count_ones();
        if self.significant < MIN_ROUNDED_DIGITS || endings < MIN_ROUNDED_ENDINGS {
            return 0.0;
        }
        let first = match x.abs() {
            0.0 => 0,
            x => (x.log10().floor() as i32).saturating_add(1),
        };
        0.5 * 10f64.powi((-self.decimals).max(first - self.significant))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn precision_of(words: &[&str]) -> NumberPrecision {
        let mut digits = NumberPrecision::default();
        words.iter().for_each(|word| digits.record_number(word));
        digits
    }

    #[test]
    fn few_digits_or_few_last_digits_count_as_exact() {
        for words in [
            &["552.8", "0", "-0.25"][..],
            &["1000000", "1000001"],
            &["1000000.5", "1000001.5", "0.25"],
            &["nonsense", "1.5e", "."],
        ] {
            assert_eq!(precision_of(words).rounding_error(1e6), 0.0, "{words:?}");
        }
    }

    #[test]
    fn decimals_and_significant_digits_both_limit() {
        // printf's %f
        let fixed = precision_of(&["1234.567891", "1000.123457", "-0.333333", "1234.567892"]);
        assert_eq!(fixed.rounding_error(0.3), 0.5e-6);
        assert_eq!(fixed.rounding_error(1234.5), 0.5e-6);
        // printf's %g
        let short = precision_of(&["1.23457e+06", "0.333333", "0.00142859", "-1.00001"]);
        assert_eq!(short.rounding_error(1.2e6), 5.0);
        assert_eq!(short.rounding_error(0.33), 0.5e-6);
    }
}
