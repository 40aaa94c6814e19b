//! Numbers as people read them.

/// Four significant digits; powers of ten outside 0.001…99 999.
pub fn number(x: f64) -> String {
    let size = x.abs();
    if x.is_nan() {
        "not a number".into()
    } else if x.is_infinite() {
        if x > 0.0 {
            "∞".into()
        } else {
            "−∞".into()
        }
    } else if x == 0.0 {
        "0".into()
    } else if (1e-3..1e5).contains(&size) {
        let digits = (3 - size.log10().floor() as i32).max(0) as usize;
        let text = format!("{x:.digits$}");
        let text = if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.')
        } else {
            &text
        };
        text.replace('-', "−")
    } else {
        power(&format!("{x:.2e}"))
    }
}

/// Rust's 1.5e-7 as 1.5·10⁻⁷.
pub fn power(text: &str) -> String {
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    format!("{}·10{}", mantissa.replace('-', "−"), superscript(exponent))
}

fn superscript(exponent: &str) -> String {
    let raised = |c: char| match c.to_digit(10) {
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
        None => '⁻',
    };
    exponent.chars().map(raised).collect()
}

/// A share in per cent.
pub fn percent(x: f64) -> String {
    if x.is_finite() {
        format!("{}\u{202f}%", number(100.0 * x))
    } else {
        number(x)
    }
}

/// A count, its thousands apart.
pub fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_true() {
        let texts = [0.0, 1.0, -0.25, 0.0012345, 12_345.6, 1.5e-7, -2e9, f64::NAN].map(number);
        let expected = [
            "0",
            "1",
            "−0.25",
            "0.001234",
            "12346",
            "1.50·10⁻⁷",
            "−2.00·10⁹",
            "not a number",
        ];
        assert_eq!(texts, expected);
        assert_eq!(percent(0.1234), "12.34\u{202f}%");
        assert_eq!(
            [count(0), count(999), count(1_234_567)],
            ["0", "999", "1\u{202f}234\u{202f}567"]
        );
    }
}
