//! Decodes the text of OBJ and MTL files and joins continued lines, for the readers of both.

use crate::error::{Error, Result};
use crate::import::BYTE_ORDER_MARK;
use std::path::Path;

/// Decodes a file as UTF-8 text.
///
/// Errors: the file is binary or not UTF-8, with the line.
pub fn decode_text<'a>(path: &Path, bytes: &'a [u8]) -> Result<&'a str> {
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let fail = |at: usize, message: &str| {
        let number = 1 + bytes[..at].iter().filter(|b| **b == b'\n').count();
        Error::bad_input(path, format!("line {number}"), message)
    };
    if let Some(at) = bytes.iter().position(|b| *b == 0) {
        return Err(fail(at, "is binary, not text"));
    }
    let advice = "is not UTF-8 text: convert it, or remove the letter";
    std::str::from_utf8(bytes).map_err(|e| fail(e.valid_up_to(), advice))
}

/// Iterates over the non-empty logical lines: continued lines joined and comments removed, each with the number of its
/// first line in the file and its words separated by one space. A `#` is part of a name; elsewhere it begins a comment.
pub fn logical_lines(text: &str) -> impl Iterator<Item = (usize, String)> {
    let mut lines = text.lines().zip(1..);
    let logical = std::iter::from_fn(move || {
        let (line, number) = lines.next()?;
        let is_comment = line.trim_start().starts_with('#');
        let mut line = line.to_owned();
        while !is_comment && let Some(length) = line.trim_end().strip_suffix('\\').map(str::len) {
            line.truncate(length);
            line.push(' ');
            line.push_str(lines.next().map_or("", |(next, _)| next));
        }
        let mut words: Vec<&str> = line.split_whitespace().collect();
        if !matches!(words.first(), Some(&("o" | "g" | "usemtl" | "newmtl" | "mtllib"))) {
            let comment = words.iter().position(|word| word.starts_with('#'));
            words.truncate(comment.unwrap_or(words.len()));
        }
        Some((number, words.join(" ")))
    });
    logical.filter(|(_, line)| !line.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_lines(text: &str, expected: &[(usize, &str)]) {
        let lines: Vec<_> = logical_lines(text).collect();
        let lines: Vec<_> = lines.iter().map(|(n, line)| (*n, line.as_str())).collect();
        assert_eq!(lines, expected);
    }

    #[test]
    fn continued_lines_are_joined_and_comments_removed() {
        let text = "f 1\t2 \\\r\n 3\\\n4 # end\n  g  a #1\n# c \\\nv 1 2 3 #\n";
        assert_lines(text, &[(1, "f 1 2 3 4"), (4, "g a #1"), (6, "v 1 2 3")]);
    }

    #[test]
    fn last_line_may_end_in_a_backslash() {
        assert_lines("f 1 \\", &[(1, "f 1")]);
        assert_lines("\\\n\\", &[]);
    }

    #[test]
    fn binary_and_non_utf8_texts_are_refused() {
        let error = |bytes: &[u8]| {
            let text = decode_text(Path::new("x"), bytes);
            text.err().map_or(String::new(), |e| e.to_string())
        };
        assert_eq!(error(b"\xEF\xBB\xBFv"), "");
        assert!(error(b"v\n\nv\0").starts_with("x: line 3: is binary"));
        assert!(error(b"v\n# caf\xE9").starts_with("x: line 2: is not UTF-8"));
    }
}
