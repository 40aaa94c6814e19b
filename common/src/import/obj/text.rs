//! OBJ and MTL as lines: tabs, comments and continued lines undone, since tobj knows few of them.

use crate::error::{Error, Result};
use crate::import::BOM;
use std::path::Path;
use tobj::LoadError;

/// The text of a file.
pub fn utf8<'a>(path: &Path, bytes: &'a [u8]) -> Result<&'a str> {
    let bytes = bytes.strip_prefix(BOM).unwrap_or(bytes);
    let place = |at: usize| {
        format!(
            "line {}",
            1 + bytes[..at].iter().filter(|b| **b == b'\n').count()
        )
    };
    if let Some(at) = bytes.iter().position(|b| *b == 0) {
        return Err(Error::input(path, place(at), "is binary, not text"));
    }
    std::str::from_utf8(bytes).map_err(|e| {
        Error::input(
            path,
            place(e.valid_up_to()),
            "is not UTF-8 text: convert it, or remove the letter",
        )
    })
}

/// The lines that say something, each with the number of its first line in the file and its words
/// parted by one space. Names keep a `#`; elsewhere it begins a comment.
pub fn lines(text: &str) -> Vec<(usize, String)> {
    let mut result = Vec::new();
    let mut rest = text.lines().enumerate();
    while let Some((number, line)) = rest.next() {
        let mut words: Vec<&str> = line.split_whitespace().collect();
        let is_comment = words.first().is_none_or(|w| w.starts_with('#'));
        while !is_comment && continues(&mut words) {
            words.extend(
                rest.next()
                    .map(|(_, line)| line.split_whitespace())
                    .into_iter()
                    .flatten(),
            );
        }
        if !matches!(
            words.first(),
            Some(&("o" | "g" | "usemtl" | "newmtl" | "mtllib"))
        ) {
            let comment = words
                .iter()
                .position(|w| w.starts_with('#'))
                .unwrap_or(words.len());
            words.truncate(comment);
        }
        if !words.is_empty() {
            result.push((number + 1, words.join(" ")));
        }
    }
    result
}

/// Takes a final backslash off.
fn continues(words: &mut Vec<&str>) -> bool {
    let Some(last) = words.pop() else {
        return false;
    };
    let stripped = last.strip_suffix('\\');
    words.extend(Some(stripped.unwrap_or(last)).filter(|w| !w.is_empty()));
    stripped.is_some()
}

/// Text for tobj, and the line of the file from which each of its lines comes.
#[derive(Default)]
pub struct Lines {
    text: String,
    /// Where each line ends in `text`, and its number in the file.
    ends: Vec<(usize, usize)>,
}

impl Lines {
    /// Appends a line.
    pub fn push(&mut self, number: usize, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
        self.ends.push((self.text.len(), number));
    }

    /// What `parser` makes of the whole. tobj's errors name no line: the culprit is the last line
    /// of the shortest beginning that fails, found by halving.
    pub fn parse<T>(
        &self,
        path: &Path,
        parser: impl Fn(&mut &[u8]) -> std::result::Result<T, LoadError>,
    ) -> Result<T> {
        let parse = |end: usize| parser(&mut &self.text.as_bytes()[..end]);
        parse(self.text.len()).map_err(|whole| {
            let k = self.ends.partition_point(|(end, _)| parse(*end).is_ok());
            let Some((end, number)) = self.ends.get(k) else {
                return Error::input(path, "", message(whole));
            };
            let error = parse(*end).err().unwrap_or(whole);
            Error::input(path, format!("line {number}"), message(error))
        })
    }
}

fn message(error: LoadError) -> String {
    match error {
        LoadError::PositionParseError => {
            "a vertex needs three numbers: is the file cut off?".into()
        }
        LoadError::ScalingByZeroError => "a vertex has the weight 0".into(),
        LoadError::ColorParseError => "a vertex has too many numbers".into(),
        LoadError::FaceParseError => "a corner of this face is not the number of a vertex".into(),
        LoadError::FaceVertexOutOfBounds => {
            "a corner of this face is a vertex that does not exist".into()
        }
        LoadError::InvalidObjectName => "a material needs a name".into(),
        LoadError::MaterialParseError => "cannot be understood: is a number missing?".into(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(text: &str) -> Vec<(usize, String)> {
        lines(text)
    }

    #[test]
    fn lines_are_joined_and_tidied() {
        let expected =
            [(1, "f 1 2 3 4"), (4, "g a #1"), (6, "v 1 2 3")].map(|(n, l)| (n, l.to_owned()));
        assert_eq!(
            told("f 1\t2 \\\r\n 3\\\n4 # end\n  g  a #1\n# c \\\nv 1 2 3 #\n"),
            expected
        );
    }

    #[test]
    fn a_last_line_may_end_in_a_backslash() {
        assert_eq!(told("f 1 \\"), [(1, "f 1".to_owned())]);
        assert_eq!(told("\\\n\\"), []);
    }

    #[test]
    fn the_first_bad_line_is_named() {
        let parser = |text: &mut &[u8]| match text.windows(2).any(|w| w == b"b\n") {
            true => Err(LoadError::FaceParseError),
            false => Ok(()),
        };
        for at in 0..9 {
            let mut text = Lines::default();
            (0..9).for_each(|k| text.push(10 * k, if k >= at { "b" } else { "a" }));
            let error = text
                .parse(Path::new("x.obj"), parser)
                .map_err(|e| e.to_string());
            assert!(error.is_err_and(|e| e.starts_with(&format!("x.obj: line {}: ", 10 * at))));
        }
    }

    #[test]
    fn text_is_utf8() {
        let error = |bytes: &[u8]| {
            utf8(Path::new("x"), bytes)
                .map_err(|e| e.to_string())
                .err()
                .unwrap_or_default()
        };
        assert_eq!(error(b"\xEF\xBB\xBFv"), "");
        assert!(error(b"v\n\nv\0").starts_with("x: line 3: is binary"));
        assert!(error(b"v\n# caf\xE9").starts_with("x: line 2: is not UTF-8"));
    }
}
