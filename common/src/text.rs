//! Text from files, made fit to be shown to people.

/// `text` with its control characters spelt out: a name must not move a terminal's cursor, and
/// XML forbids most of them.
pub fn plain(text: &str) -> String {
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
    fn control_characters_are_spelt_out() {
        assert_eq!(
            plain("a wall, größer <&> \\ 壁"),
            "a wall, größer <&> \\ 壁"
        );
        assert_eq!(
            plain("\x1b[2J\n\t\u{7f}\u{9b}"),
            "\\u{1b}[2J\\n\\t\\u{7f}\\u{9b}"
        );
    }
}
