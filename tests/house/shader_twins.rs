//! Every shader has a twin: `cpu/src/shader_twins/NAME.rs` for `gpu/src/shaders/NAME.wgsl`, with functions of the
//! same names in the same order. A function that the twin re-exports from another module counts as its own.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn repository_root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read_text(file: &Path) -> String {
    fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

/// Returns the names of the files with this ending in a folder and the folders in it.
fn file_names(folder: &Path, ending: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for file in fs::read_dir(folder).unwrap() {
        let path = file.unwrap().path();
        if path.is_dir() {
            names.extend(file_names(&path, ending));
        } else if path.extension().is_some_and(|found| found == ending) {
            names.insert(path.file_stem().unwrap().to_str().unwrap().to_owned());
        }
    }
    names
}

/// Returns the first word of `text`.
fn first_word(text: &str) -> &str {
    let end = |c: char| !(c.is_alphanumeric() || c == '_');
    text.split(end).next().unwrap()
}

/// Returns the functions of a shader, in order.
fn shader_functions(text: &str) -> Vec<String> {
    let lines = text.lines().filter_map(|line| line.strip_prefix("fn "));
    lines.map(|rest| first_word(rest).to_owned()).collect()
}

/// A function of a Rust file, and the type of which it is a method.
#[derive(Debug, PartialEq)]
struct RustFunction {
    owner: Option<String>,
    name: String,
}

/// Returns the type of an `impl` line.
fn impl_type(line: &str) -> Option<String> {
    let rest = line.strip_prefix("impl")?;
    let mut rest = rest
        .strip_prefix(' ')
        .or_else(|| rest.split_once("> ").map(|(_, rest)| rest))?;
    if let Some((_, after)) = rest.split_once(" for ") {
        rest = after;
    }
    Some(first_word(rest).to_owned())
}

/// Returns the functions of a Rust file, in order; `resolve` reads a re-exported module.
fn rust_functions(text: &str, resolve: &dyn Fn(&str) -> String) -> Vec<RustFunction> {
    let text = text.split("#[cfg(test)]").next().unwrap();
    let (mut functions, mut owner) = (Vec::new(), None);
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if let Some(path) = line.strip_prefix("pub use ") {
            let mut path = path.to_owned();
            while !path.ends_with(';') {
                path += lines.next().expect("a `use` ends with a semicolon");
            }
            functions.extend(reexported_functions(&path, resolve));
            continue;
        }
        if line.starts_with("impl") {
            owner = impl_type(line);
        } else if line.starts_with('}') {
            owner = None;
        }
        let indented = line.strip_prefix("    ").unwrap_or(line);
        let plain = ["pub(crate) ", "pub(super) ", "pub ", "const "]
            .iter()
            .fold(indented, |line, prefix| line.strip_prefix(prefix).unwrap_or(line));
        if let Some(rest) = plain.strip_prefix("fn ") {
            let name = first_word(rest).to_owned();
            functions.push(RustFunction {
                owner: owner.clone(),
                name,
            });
        }
    }
    functions
}

/// Returns the functions, and methods of types, that `pub use PATH` names, in the order of their module.
fn reexported_functions(path: &str, resolve: &dyn Fn(&str) -> String) -> Vec<RustFunction> {
    let path = path.trim_end_matches(';');
    let (module, names) = path
        .rsplit_once("::")
        .filter(|_| !path.contains('{'))
        .unwrap_or_else(|| {
            let (module, names) = path.split_once("::{").expect("a path of a module");
            (module, names)
        });
    let names: Vec<&str> = (names.split(|c: char| "{}, ".contains(c)))
        .filter(|name| !name.is_empty())
        .collect();
    // What that module re-exports itself does not count.
    let functions = rust_functions(&resolve(module), &|_| String::new());
    let is_named = |function: &RustFunction| {
        let key = function.owner.as_ref().unwrap_or(&function.name);
        names.contains(&key.as_str())
    };
    functions.into_iter().filter(is_named).collect()
}

/// Returns the text of module `common::…` or `crate::…` of the CPU's crate.
fn module_text(path: &str) -> String {
    let (package, module) = path.split_once("::").expect("a path of a module");
    let package = match package {
        "crate" => "cpu",
        other => other,
    };
    let file = repository_root()
        .join(package)
        .join("src")
        .join(module.replace("::", "/"));
    let candidates = [file.with_extension("rs"), file.join("mod.rs")];
    let found = candidates.iter().find(|file| file.exists());
    read_text(found.unwrap_or_else(|| panic!("no file of {path}")))
}

/// Compares the functions of a shader with those of its twin, which may have more.
fn compare_functions(shader: &[String], twin: &[RustFunction]) -> Result<(), String> {
    let names: Vec<&str> = twin.iter().map(|function| function.name.as_str()).collect();
    let mut next = 0;
    for function in shader {
        match names[next..].iter().position(|name| name == function) {
            Some(at) => next += at + 1,
            None if names.contains(&function.as_str()) => {
                return Err(format!("{function} is out of order"));
            }
            None => return Err(format!("{function} is missing")),
        }
    }
    Ok(())
}

#[test]
fn every_shader_has_a_twin_file() {
    let shaders = file_names(&repository_root().join("gpu/src/shaders"), "wgsl");
    let mut twins = file_names(&repository_root().join("cpu/src/shader_twins"), "rs");
    twins.remove("mod");
    assert!(shaders.len() > 30, "{shaders:?}");
    assert_eq!(shaders, twins);
}

#[test]
fn twins_have_the_functions_of_their_shader_in_its_order() {
    let shaders = repository_root().join("gpu/src/shaders");
    let mut wrong = Vec::new();
    for name in file_names(&shaders, "wgsl") {
        let shader = shader_functions(&read_text(&shaders.join(format!("{name}.wgsl"))));
        let file = repository_root()
            .join("cpu/src/shader_twins")
            .join(format!("{name}.rs"));
        let twin = rust_functions(&read_text(&file), &module_text);
        if let Err(text) = compare_functions(&shader, &twin) {
            wrong.push(format!("{name}.rs: {text}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

const SHADER: &str = "fn first(x: f32) -> f32 {\n    return x;\n}\n\n@compute\nfn second() {\n}\n\nfn third() {\n}\n";

const MODULE: &str = "pub fn third() {}\n\npub fn first() {}\n\nimpl Thing<'_> {\n    fn second(&self) {}\n}\n";

fn compare_texts(twin: &str) -> Result<(), String> {
    let functions = rust_functions(twin, &|_| MODULE.to_owned());
    compare_functions(&shader_functions(SHADER), &functions)
}

#[test]
fn a_twin_with_more_functions_is_accepted() {
    let twin = "fn first() {}\n\nimpl Thing {\n    fn helper() {}\n\n    pub fn second() {}\n}\n\npub fn third() {}\n";
    assert_eq!(compare_texts(twin), Ok(()));
}

#[test]
fn a_missing_function_is_noticed() {
    let twin = "fn first() {}\n\nfn third() {}\n";
    assert_eq!(compare_texts(twin), Err("second is missing".into()));
    let in_a_test = "fn first() {}\nfn second() {}\n#[cfg(test)]\nmod tests {\n    fn third() {}\n}\n";
    assert_eq!(compare_texts(in_a_test), Err("third is missing".into()));
}

#[test]
fn swapped_functions_are_noticed() {
    let twin = "fn second() {}\n\nfn first() {}\n\nfn third() {}\n";
    assert_eq!(compare_texts(twin), Err("second is out of order".into()));
}

#[test]
fn reexports_stand_in_the_order_of_their_module() {
    let twin = "pub use common::module::{\n    first, Thing,\n};\n\nfn third() {}\n";
    assert_eq!(compare_texts(twin), Ok(()));
    let swapped = "pub use common::module::{Thing, first, third};\n";
    assert_eq!(compare_texts(swapped), Err("third is out of order".into()));
    let without = "pub use common::module::first;\n\nfn third() {}\n";
    assert_eq!(compare_texts(without), Err("second is missing".into()));
}
