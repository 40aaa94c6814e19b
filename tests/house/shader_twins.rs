//! Every shader has a twin: `cpu/src/shader_twins/NAME.rs` for `gpu/src/shaders/NAME.wgsl`, with functions of the
//! same names, its own in the same order. A function of a module of which the twin re-exports something counts, too.

use super::source::{files_below, read_file};
use std::collections::BTreeMap;

/// Returns the texts of the files with this ending in a folder and the folders in it, by their names.
fn texts_by_name(folder: &str, ending: &str) -> BTreeMap<String, String> {
    let name = |file: &str| file.rsplit('/').next().unwrap().trim_end_matches(ending).to_owned();
    let files = files_below(folder, ending).into_iter();
    files.map(|(file, text)| (name(&file), text)).collect()
}

/// Returns the functions that are defined in `text`, in order; `pub` and `const` may stand before `fn`.
fn defined_functions(text: &str) -> Vec<&str> {
    let code = text.split("#[cfg(test)]").next().unwrap().lines();
    let end = |c: char| !(c.is_alphanumeric() || c == '_');
    let name = |line: &'_ str| -> Option<usize> {
        let (before, _) = line.split_once("fn ")?;
        let plain = before
            .split_whitespace()
            .all(|word| word.starts_with("pub") || word == "const");
        plain.then_some(before.len() + 3)
    };
    code.filter_map(|line| line[name(line)?..].split(end).next()).collect()
}

/// Returns the text of each module `common::…` or `crate::…` of the CPU's crate from which a twin re-exports.
fn reexported_texts(twin: &str) -> Vec<String> {
    let uses = twin.lines().filter_map(|line| line.strip_prefix("pub use "));
    let text = |path: &str| {
        let module = path.split("::{").next().unwrap();
        let module = if path == module {
            path.rsplit_once("::").unwrap().0
        } else {
            module
        };
        let (package, module) = module.split_once("::").unwrap();
        let package = if package == "crate" { "cpu" } else { package };
        let file = format!("{package}/src/{}", module.replace("::", "/"));
        let mut files = [".rs", "/mod.rs"]
            .iter()
            .filter_map(|ending| read_file(&format!("{file}{ending}")));
        files.next().unwrap_or_else(|| panic!("no file of {path}"))
    };
    uses.map(text).collect()
}

/// Compares the functions of a shader with those of its twin, which may have more. Those of the twin's own must stand in
/// the shader's order; it must name those that it re-exports, except for methods of types.
fn compare_functions(shader: &str, twin: &str, reexported: &[String]) -> Result<(), String> {
    let mut own = defined_functions(twin).into_iter();
    let own_names: Vec<&str> = own.clone().collect();
    for function in defined_functions(shader) {
        let is_method = |text: &&String| {
            text.contains(&format!("    fn {function}")) || text.contains(&format!("    pub fn {function}"))
        };
        let named = twin
            .split(|c: char| !(c.is_alphanumeric() || c == '_'))
            .any(|word| word == function);
        let mut others = reexported
            .iter()
            .filter(|text| defined_functions(text).contains(&function));
        if own_names.contains(&function) {
            if !own.any(|name| name == function) {
                return Err(format!("{function} is out of order"));
            }
        } else if !others.any(|text| named || is_method(&text)) {
            return Err(format!("{function} is missing"));
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
        let twin = &twins[name];
        let compared = compare_functions(shader, twin, &reexported_texts(twin));
        compared.err().map(|text| format!("{name}.rs: {text}"))
    });
    let wrong: Vec<String> = wrong.collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

const SHADER: &str = "fn first(x: f32) -> f32 {\n    return x;\n}\n\n@compute\nfn second() {\n}\n\nfn third() {\n}\n";

/// Twins of [`SHADER`], the text of a module of which they re-export, and what is wrong with them.
const COMPARED_TWINS: [(&str, &str, Result<(), &str>); 6] = [
    // It may have more functions.
    (
        "fn first() {}\n\nimpl Thing {\n    fn helper() {}\n\n    pub fn second() {}\n}\n\npub const fn third() {}\n",
        "",
        Ok(()),
    ),
    (
        "fn first() {}\n\n// fn second\nfn third() {}\n",
        "",
        Err("second is missing"),
    ),
    (
        "fn first() {}\nfn second() {}\n#[cfg(test)]\nmod tests {\n    fn third() {}\n}\n",
        "",
        Err("third is missing"),
    ),
    (
        "fn second() {}\n\nfn first() {}\n\nfn third() {}\n",
        "",
        Err("second is out of order"),
    ),
    (
        "pub use common::module::{Thing, third};\nfn first() {}\n",
        "fn third() {}\nimpl Thing<'_> {\n    fn second(&self) {}\n}\n",
        Ok(()),
    ),
    (
        "fn first() {}\n",
        "fn second() {}\nfn third() {}\n",
        Err("second is missing"),
    ),
];

#[test]
fn missing_and_swapped_functions_are_noticed() {
    for (twin, reexported, expected) in COMPARED_TWINS {
        let found = compare_functions(SHADER, twin, &[reexported.to_owned()]);
        assert_eq!(found, expected.map_err(str::to_owned), "{twin}");
    }
}
