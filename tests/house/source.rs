//! Source files without comments, and the paths that they use.

use std::fs;
use std::path::{Path, PathBuf};

/// A file without comments and without its test module.
pub struct Source {
    /// `common/src/scene/mod.rs`.
    pub file: String,
    /// The lines, each up to its comment.
    pub code: String,
}

impl Source {
    /// Cuts comments from `text`. The tests of a module must be its last item.
    pub fn new(file: &str, text: &str) -> Self {
        let own = text.find("#[cfg(test)]\nmod tests {").unwrap_or(text.len());
        let lines = text[..own].lines().map(|line| line.split("//").next().unwrap());
        Self {
            file: file.to_owned(),
            code: lines.collect::<Vec<_>>().join("\n"),
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
    pub fn used_paths(&self) -> Vec<Vec<&str>> {
        let mut found = Vec::new();
        for root in ["crate::", "super::"] {
            for (at, _) in self.code.match_indices(root) {
                let before = &self.code[..at];
                if !before.ends_with(is_name) && !before.ends_with("::") {
                    expand_use_tree(&self.module_path(), &self.code[at..], &mut found);
                }
            }
        }
        found
    }
}

/// Collects the paths of a use tree that begins in the module `base`; returns what follows it.
fn expand_use_tree<'s>(base: &[&'s str], text: &'s str, found: &mut Vec<Vec<&'s str>>) -> &'s str {
    let mut path = base.to_vec();
    let mut rest = text;
    loop {
        if let Some(inner) = rest.strip_prefix('{') {
            rest = inner;
            while let Some(at) = rest.find(|c| is_name(c) || c == '{' || c == '}') {
                rest = &rest[at..];
                match rest.strip_prefix('}') {
                    Some(after) => return after,
                    None => rest = expand_use_tree(&path, rest, found),
                }
            }
            return rest;
        }
        let (name, after) = rest.split_at(rest.find(|c| !is_name(c)).unwrap_or(rest.len()));
        match name {
            "crate" => path.clear(),
            "super" => drop(path.pop()),
            name => path.push(name),
        }
        match after.strip_prefix("::") {
            Some(inner) => rest = inner,
            None => {
                found.push(path);
                return after;
            }
        }
    }
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
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
