//! Source files, parsed as far as the checks need: code, string literals, functions, paths.

use std::fs;
use std::path::{Path, PathBuf};

/// A file without comments and without its test module.
pub struct Source {
    /// `common/src/scene/mod.rs`.
    pub file: String,
    /// The text with each literal as `""`; line numbers are the file's.
    pub code: String,
    /// String literals.
    pub literals: Vec<String>,
}

impl Source {
    /// Parses `text`. The tests of a module must be its last item.
    pub fn new(file: &str, text: &str) -> Self {
        let own = text.find("#[cfg(test)]\nmod tests {");
        let text = &text[..own.unwrap_or(text.len())];
        let (code, literals) = separate_literals(text);
        Self {
            file: file.to_owned(),
            code,
            literals,
        }
    }

    /// Returns the package: `common`.
    pub fn package_name(&self) -> &str {
        self.file.split('/').next().unwrap()
    }

    /// Returns the module path: `["scene", "texel"]` of `common/src/scene/texel.rs`, empty for the crate's root.
    pub fn module_path(&self) -> Vec<&str> {
        let inner = self.file.split_once("/src/").map_or("", |(_, path)| path);
        let mut path: Vec<&str> = inner.trim_end_matches(".rs").split('/').collect();
        if path.last() == Some(&"mod") || matches!(path[..], ["lib" | "main"]) {
            path.pop();
        }
        path
    }

    /// Returns the modules of its own crate that it names by `crate::` and `super::`, braces expanded.
    pub fn used_paths(&self) -> Vec<Vec<String>> {
        let mut found = Vec::new();
        for root in ["crate::", "super::"] {
            for (at, _) in self.code.match_indices(root) {
                let before = &self.code[..at];
                if !before.ends_with(is_name) && !before.ends_with("::") {
                    self.expand_path(&self.code[at..], &mut found);
                }
            }
        }
        found
    }

    fn expand_path(&self, text: &str, found: &mut Vec<Vec<String>>) {
        let mut base: Vec<String> = self.module_path().iter().map(ToString::to_string).collect();
        let mut rest = text;
        if let Some(inner) = rest.strip_prefix("crate::") {
            (base, rest) = (Vec::new(), inner);
        }
        while let Some(inner) = rest.strip_prefix("super::") {
            base.pop();
            rest = inner;
        }
        expand_use_tree(&base, rest, found);
    }
}

/// Collects the paths of a use tree; returns its length in `text`.
fn expand_use_tree(base: &[String], text: &str, found: &mut Vec<Vec<String>>) -> usize {
    let mut path = base.to_vec();
    let mut at = 0;
    loop {
        let rest = &text[at..];
        if rest.starts_with('{') {
            at += 1;
            while !text[at..].starts_with('}') && at < text.len() {
                let skip = text[at..].find(|c: char| is_name(c) || c == '{' || c == '}');
                at += skip.unwrap_or(text.len() - at);
                if !text[at..].starts_with('}') && at < text.len() {
                    at += expand_use_tree(&path, &text[at..], found).max(1);
                }
            }
            return (at + 1).min(text.len());
        }
        let name = &rest[..rest.find(|c| !is_name(c)).unwrap_or(rest.len())];
        path.push(name.to_owned());
        at += name.len();
        if !text[at..].starts_with("::") {
            found.push(path);
            return at;
        }
        at += 2;
    }
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Separates code without comments from its string literals.
fn separate_literals(text: &str) -> (String, Vec<String>) {
    let (mut code, mut literals) = (String::new(), Vec::new());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let raw = !code.ends_with(is_name) && is_raw_literal(rest);
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if raw || c == '"' {
            let (literal, length) = first_literal(rest);
            literals.push(literal.to_owned());
            code.push_str("\"\"");
            code.extend(rest[..length].chars().filter(|c| *c == '\n'));
            length
        } else if c == '\'' {
            code.push_str("' '");
            character_length(rest)
        } else {
            code.push(c);
            c.len_utf8()
        };
        rest = &rest[length..];
    }
    (code, literals)
}

fn is_raw_literal(text: &str) -> bool {
    let hashes = text.strip_prefix('r').map(|t| t.trim_start_matches('#'));
    hashes.is_some_and(|t| t.starts_with('"'))
}

/// Returns the inside of the literal at the start of `text`, and the literal's whole length.
fn first_literal(text: &str) -> (&str, usize) {
    let (opening, inside) = text.split_once('"').unwrap();
    let closing = format!("\"{}", opening.trim_start_matches('r'));
    let is_end = |at: &usize| {
        let escapes = inside[..*at].bytes().rev().take_while(|b| *b == b'\\').count();
        opening.starts_with('r') || escapes % 2 == 0
    };
    let mut ends = inside.match_indices(&closing).map(|(at, _)| at);
    let end = ends.find(is_end).unwrap_or(inside.len());
    let length = opening.len() + 1 + end + closing.len();
    (&inside[..end], length.min(text.len()))
}

/// Returns the length of a character literal, or of the quote of a lifetime.
fn character_length(text: &str) -> usize {
    let inner = &text[1..];
    if let Some(escape) = inner.strip_prefix('\\') {
        return 3 + escape[1..].find('\'').map_or(0, |at| at + 1);
    }
    let c = inner.chars().next().map_or(0, char::len_utf8);
    if inner[c..].starts_with('\'') { c + 2 } else { 1 }
}

/// Returns the path of a file of the repository.
fn repository_path(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(file)
}

/// Reads a file of the repository.
pub fn read_file(file: &str) -> Option<String> {
    fs::read_to_string(repository_path(file)).ok()
}

/// Reads all files of this ending below a folder of the repository, sorted by name.
pub fn files_below(folder: &str, ending: &str) -> Vec<(String, String)> {
    let (mut found, mut folders) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(repository_path(&folder)).unwrap() {
            let entry = entry.unwrap();
            let name = format!("{folder}/{}", entry.file_name().to_str().unwrap());
            if entry.file_type().unwrap().is_dir() {
                folders.push(name);
            } else if name.ends_with(ending) {
                found.push((name.clone(), read_file(&name).unwrap()));
            }
        }
    }
    found.sort();
    found
}
