//! Escaping of text from files for display.

/// Returns `text` with its control characters escaped: they would move a terminal's cursor, and XML
/// forbids most of them.
pub fn escape_control(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for letter in text.chars() {
        if letter.is_control() {
            plain.extend(letter.escape_default());
        } else {
            plain.push(letter);
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped() {
        assert_eq!(escape_control("a wall, größer <&> \\ 壁"), "a wall, größer <&> \\ 壁");
        assert_eq!(
            escape_control("\x1b[2J\n\t\u{7f}\u{9b}"),
            "\\u{1b}[2J\\n\\t\\u{7f}\\u{9b}"
        );
    }
}
