//! How far the numbers of a text may be rounded: a program writes them all to so many decimals, or to
//! so many significant digits.

/// Fewer digits than this are what was meant: 552.8 mm.
const MEANT: i32 = 6;
/// Rounded numbers end in any digit, those that are meant in a few: .5, .25 and .75.
const ENDINGS: u32 = 3;

/// The digits of all coordinates of a file.
#[derive(Clone, Copy, Debug, Default)]
pub struct Digits {
    /// The most behind the point, counting the exponent.
    decimals: i32,
    /// The most from the first that is not 0.
    significant: i32,
    /// Which digits the longest numbers end in, as bits.
    endings: u16,
}

impl Digits {
    /// One more coordinate.
    pub fn see(&mut self, word: &str) {
        let (mantissa, exponent) = word.split_once(['e', 'E']).unwrap_or((word, "0"));
        let (Some((_, fraction)), Ok(exponent)) =
            (mantissa.split_once('.'), exponent.parse::<i32>())
        else {
            return;
        };
        let digits = mantissa.bytes().filter(u8::is_ascii_digit);
        let significant = digits.skip_while(|d| *d == b'0').count() as i32;
        if significant > self.significant {
            (self.significant, self.endings) = (significant, 0);
        }
        if let Some(last) = fraction
            .bytes()
            .last()
            .filter(|_| significant == self.significant)
        {
            self.endings |= 1 << (last.wrapping_sub(b'0') & 15);
        }
        self.decimals = self.decimals.max(fraction.len() as i32 - exponent);
    }

    /// What a coordinate x may be off by.
    pub fn rounding(&self, x: f64) -> f64 {
        if self.significant < MEANT || self.endings.count_ones() < ENDINGS {
            return 0.0;
        }
        let first = if x == 0.0 {
            0
        } else {
            x.abs().log10().floor() as i32 + 1
        };
        0.5 * 10f64.powi((-self.decimals).max(first - self.significant))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn digits(words: &[&str]) -> Digits {
        let mut digits = Digits::default();
        words.iter().for_each(|word| digits.see(word));
        digits
    }

    #[test]
    fn few_digits_and_few_endings_are_meant() {
        for words in [
            &["552.8", "0", "-0.25"][..],
            &["1000000", "1000001"],
            &["1000000.5", "1000001.5", "0.25"],
            &["nonsense", "1.5e", "."],
        ] {
            assert_eq!(digits(words).rounding(1e6), 0.0, "{words:?}");
        }
    }

    #[test]
    fn decimals_and_significant_digits_both_limit() {
        // printf's %f
        let fixed = digits(&["1234.567891", "1000.123457", "-0.333333", "1234.567892"]);
        assert_eq!(fixed.rounding(0.3), 0.5e-6);
        assert_eq!(fixed.rounding(1234.5), 0.5e-6);
        // printf's %g
        let short = digits(&["1.23457e+06", "0.333333", "0.00142859", "-1.00001"]);
        assert_eq!(short.rounding(1.2e6), 5.0);
        assert_eq!(short.rounding(0.33), 0.5e-6);
    }
}
