//! Every shader has a twin: `cpu/src/shader_twins/NAME.rs` for `gpu/src/shaders/NAME.wgsl`, with functions of the
//! same names in the same order. A function that the twin re-exports from another module counts as its own.

use super::source::{files_below, read_file};
use std::collections::BTreeMap;

/// Returns the texts of the files with this ending in a folder and the folders in it, by their names.
fn texts_by_name(folder: &str, ending: &str) -> BTreeMap<String, String> {
    let name = |file: &str| file.rsplit('/').next().unwrap().trim_end_matches(ending).to_owned();
    let files = files_below(folder, ending).into_iter();
    files.map(|(file, text)| (name(&file), text)).collect()
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
    let separator = if path.contains('{') { "::{" } else { "::" };
    let (module, names) = path.rsplit_once(separator).expect("a path of a module");
    let names: Vec<&str> = names.split(|c: char| "{}, ;".contains(c)).collect();
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
    let package = if package == "crate" { "cpu" } else { package };
    let module = format!("{package}/src/{}", module.replace("::", "/"));
    let files = [".rs", "/mod.rs"].map(|ending| read_file(&format!("{module}{ending}")));
    files
        .into_iter()
        .flatten()
        .next()
        .unwrap_or_else(|| panic!("no file of {path}"))
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
fn twins_have_the_functions_of_their_shader_in_its_order() {
    let shaders = texts_by_name("gpu/src/shaders", ".wgsl");
    let mut twins = texts_by_name("cpu/src/shader_twins", ".rs");
    twins.remove("mod");
    assert!(shaders.len() > 30, "{:?}", shaders.keys());
    assert!(
        shaders.keys().eq(twins.keys()),
        "{:?} {:?}",
        shaders.keys(),
        twins.keys()
    );
    let wrong = shaders.iter().filter_map(|(name, shader)| {
        let twin = rust_functions(&twins[name], &module_text);
        let compared = compare_functions(&shader_functions(shader), &twin);
        compared.err().map(|text| format!("{name}.rs: {text}"))
    });
    let wrong: Vec<String> = wrong.collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

const SHADER: &str = "fn first(x: f32) -> f32 {\n    return x;\n}\n\n@compute\nfn second() {\n}\n\nfn third() {\n}\n";

const MODULE: &str = "pub fn third() {}\n\npub fn first() {}\n\nimpl Thing<'_> {\n    fn second(&self) {}\n}\n";

/// Twins of [`SHADER`], which may re-export what [`MODULE`] has, and what is wrong with them.
const TWINS: [(&str, Result<(), &str>); 7] = [
    // It may have more functions.
    (
        "fn first() {}\n\nimpl Thing {\n    fn helper() {}\n\n    pub fn second() {}\n}\n\npub fn third() {}\n",
        Ok(()),
    ),
    ("fn first() {}\n\nfn third() {}\n", Err("second is missing")),
    (
        "fn first() {}\nfn second() {}\n#[cfg(test)]\nmod tests {\n    fn third() {}\n}\n",
        Err("third is missing"),
    ),
    (
        "fn second() {}\n\nfn first() {}\n\nfn third() {}\n",
        Err("second is out of order"),
    ),
    // Re-exports stand in the order of their module.
    (
        "pub use common::module::{\n    first, Thing,\n};\n\nfn third() {}\n",
        Ok(()),
    ),
    (
        "pub use common::module::{Thing, first, third};\n",
        Err("third is out of order"),
    ),
    (
        "pub use common::module::first;\n\nfn third() {}\n",
        Err("second is missing"),
    ),
];

#[test]
fn missing_and_swapped_functions_are_noticed() {
    for (twin, expected) in TWINS {
        let functions = rust_functions(twin, &|_| MODULE.to_owned());
        let found = compare_functions(&shader_functions(SHADER), &functions);
        assert_eq!(found, expected.map_err(str::to_owned), "{twin}");
    }
}
