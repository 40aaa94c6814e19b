//! Formats numbers for readers: significant digits, percentages, durations and counts.

/// Formats `x` with four significant digits; outside 0.001…99 999 as a power of ten.
pub fn format_number(x: f64) -> String {
    let size = x.abs();
    if x.is_nan() {
        "not a number".into()
    } else if x.is_infinite() {
        if x > 0.0 { "∞".into() } else { "−∞".into() }
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
        format_scientific(&format!("{x:.2e}"))
    }
}

/// Converts Rust's scientific notation (1.5e-7) to 1.5·10⁻⁷.
pub fn format_scientific(text: &str) -> String {
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    format!("{}·10{}", mantissa.replace('-', "−"), superscript_digits(exponent))
}

fn superscript_digits(exponent: &str) -> String {
    let raised = |c: char| match c.to_digit(10) {
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
        None => '⁻',
    };
    exponent.chars().map(raised).collect()
}

/// Formats the share `x` in per cent.
pub fn format_percent(x: f64) -> String {
    if x.is_finite() {
        format!("{}\u{202f}%", format_number(100.0 * x))
    } else {
        format_number(x)
    }
}

/// Formats a time in its natural unit: 78.5 µs, 2.4 ms, 12.3 s, 3 min 20 s, 5 h 12 min, 2 d 7 h.
pub fn format_duration(seconds: f64) -> String {
    let short = |x: f64| {
        let digits = (2 - x.log10().floor() as i32).clamp(0, 2) as usize;
        let text = format!("{x:.digits$}");
        match text.contains('.') {
            true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
            false => text,
        }
    };
    let two = |whole: u64, [many, part]: [&str; 2], of: u64| match whole % of {
        0 => format!("{} {many}", whole / of),
        rest => format!("{} {many} {rest} {part}", whole / of),
    };
    // The negation also catches NaN.
    if !(seconds.is_finite() && seconds > 0.0) {
        return format!("{} s", format_number(seconds));
    }
    match seconds {
        s if s < 1e-7 => format!("{} s", format_number(s)),
        s if s < 0.995e-4 => format!("{} µs", short(1e6 * s)),
        s if s < 0.0995 => format!("{} ms", short(1e3 * s)),
        s if s < 59.5 => format!("{} s", short(s)),
        s if s < 3570.0 => two(s.round() as u64, ["min", "s"], 60),
        s if s < 85_500.0 => two((s / 60.0).round() as u64, ["h", "min"], 60),
        s => two((s / 3600.0).round() as u64, ["d", "h"], 24),
    }
}

/// Formats a count with thousands separated by narrow spaces.
pub fn format_count(n: u64) -> String {
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

/// Formats each part of a list as `one` or, for another count, `many`: 1 face, 2 faces.
pub fn count_noun(n: usize, one: &str, many: &str) -> String {
    format!("{} {}", format_count(n as u64), if n == 1 { one } else { many })
}

/// Returns a path without its folders.
pub fn file_name(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn duration_is_formatted_in_its_natural_unit() {
        let all = [
            0.0, 7.85e-5, 0.002409, 0.35, 1.0, 12.345, 59.7, 200.0, 3600.0, 18_720.0, 198_000.0,
        ];
        let expected = "0 s, 78.5 µs, 2.41 ms, 0.35 s, 1 s, 12.3 s, 1 min, 3 min 20 s, 1 h, 5 h 12 min, 2 d 7 h";
        assert_eq!(all.map(format_duration).join(", "), expected);
    }

    #[test]
    fn number_has_four_significant_digits() {
        let texts = [0.0, 1.0, -0.25, 0.0012345, 12_345.6, 1.5e-7, -2e9, f64::NAN].map(format_number);
        let expected = "0, 1, −0.25, 0.001234, 12346, 1.50·10⁻⁷, −2.00·10⁹, not a number";
        assert_eq!(texts.join(", "), expected);
        assert_eq!(format_percent(0.1234), "12.34\u{202f}%");
        assert_eq!(
            [format_count(0), format_count(999), format_count(1_234_567)],
            ["0", "999", "1\u{202f}234\u{202f}567"]
        );
    }
}
