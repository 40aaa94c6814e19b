//! Lines of the source by the name of an item: `fn`, `struct`, `enum` or `const` of Rust, `fn` of WGSL, with the comment
//! above it.
//!
//! The end of an item is found by the layout of rustfmt, which the shaders have, too: the closing brace stands alone, as far
//! to the right as the item's first line.

use crate::Result;
use std::fs;
use std::path::Path;

/// Words that may stand before the keyword of an item.
const ITEM_QUALIFIERS: [&str; 3] = ["pub", "pub(crate)", "pub(super)"];
/// Keywords of items.
const ITEM_KEYWORDS: [&str; 4] = ["fn", "struct", "enum", "const"];

/// Reads the lines of `item` in `file`, a path in the repository.
///
/// Errors: there is no such file, or the file has no such item.
pub fn read_item(repository: &Path, file: &str, item: &str) -> Result<String> {
    let text = fs::read_to_string(repository.join(file)).map_err(|error| format!("{file}: {error}"))?;
    find_item(&text, item).ok_or_else(|| format!("{file} has no item {item}"))
}

/// Returns the lines of `item` in `text`, from the comment above it to its end, moved to the left margin.
pub fn find_item(text: &str, item: &str) -> Option<String> {
    let lines: Vec<&str> = text.lines().collect();
    let start = lines.iter().position(|line| defined_name(line) == Some(item))?;
    let margin = &lines[start][..lines[start].len() - lines[start].trim_start().len()];
    let above = lines[..start].iter().rev();
    let comment = above.take_while(|line| is_above_item(line.trim_start())).count();
    let end = match lines[start].ends_with(['}', ';']) {
        true => start,
        false => start + lines[start..].iter().position(|line| is_end(line, margin))?,
    };
    let own = lines[start - comment..=end].iter();
    let moved = own.map(|line| line.strip_prefix(margin).unwrap_or(line));
    // What tells the compiler to inline says nothing about the method.
    let shown: Vec<&str> = moved.filter(|line| !line.starts_with("#[")).collect();
    Some(shown.join("\n"))
}

/// Returns the name of the item that begins on this line.
fn defined_name(line: &str) -> Option<&str> {
    let mut words = line
        .split_whitespace()
        .skip_while(|word| ITEM_QUALIFIERS.contains(word));
    let mut keyword = words.next()?;
    let mut name = words.next()?;
    if keyword == "const" && name == "fn" {
        (keyword, name) = (name, words.next()?);
    }
    let end = name.find(|c: char| !(c.is_alphanumeric() || c == '_'));
    ITEM_KEYWORDS
        .contains(&keyword)
        .then(|| &name[..end.unwrap_or(name.len())])
}

/// Returns whether a line is part of the comment or of the attributes above an item.
fn is_above_item(line: &str) -> bool {
    ["//", "#[", "@"].iter().any(|start| line.starts_with(start))
}

fn is_end(line: &str, margin: &str) -> bool {
    line.strip_prefix(margin)
        .is_some_and(|rest| ["}", "};", "];"].contains(&rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "\
//! A module.

impl X {
    /// Adds.
    #[inline]
    pub fn add(
        self,
    ) -> u32 {
        if a {
            b
        }
    }

    fn add_all() {}
}

// Width.
const WIDTH: u32 = 3;

// Doubles.
@compute @workgroup_size(64)
fn double(x: f32) -> f32 {
    return 2.0 * x;
}
";

    #[test]
    fn item_has_its_comment_and_ends_at_its_brace() {
        let add = "/// Adds.\npub fn add(\n    self,\n) -> u32 {\n    if a {\n        b\n    }\n}";
        assert_eq!(find_item(TEXT, "add").unwrap(), add);
        assert_eq!(find_item(TEXT, "add_all").unwrap(), "fn add_all() {}");
        assert_eq!(find_item(TEXT, "WIDTH").unwrap(), "// Width.\nconst WIDTH: u32 = 3;");
        let double = "// Doubles.\n@compute @workgroup_size(64)\nfn double(x: f32) -> f32 {\n    return 2.0 * x;\n}";
        assert_eq!(find_item(TEXT, "double").unwrap(), double);
        assert_eq!(find_item(TEXT, "ad"), None);
    }
}
