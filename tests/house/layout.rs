//! The layout that docs/architecture.md promises: packages depend in one direction, modules form no
//! circles, and libraries name no option of the program's command line.

use super::source::{Source, files_below, read_file};
use std::collections::{BTreeMap, BTreeSet};

/// Packages that a package must not depend on: `common ← cpu, gpu ← oracle ← radiosity`; `stage_check` depends on none,
/// `properties` on `common`, and only `stage_check` and `gpu` use wgpu.
const FORBIDDEN_DEPENDENCIES: [(&str, &[&str]); 11] = [
    ("stage_check", &["common", "cpu", "gpu", "oracle", "radiosity"]),
    ("common", &["cpu", "gpu", "oracle", "radiosity", "wgpu"]),
    ("properties", &["cpu", "gpu", "oracle", "radiosity", "wgpu"]),
    ("cpu", &["gpu", "oracle", "radiosity", "wgpu"]),
    ("gpu", &["cpu", "oracle", "radiosity"]),
    ("oracle", &["radiosity", "wgpu", "clap", "maud", "plotters", "image"]),
    ("radiosity", &["wgpu"]),
    ("web", &["cpu", "gpu", "live", "wgpu"]),
    ("web/live", &["web", "wgpu"]),
    ("tests", &["wgpu"]),
    ("benches", &["wgpu"]),
];

/// Lines that a shader may have; the aim is 150.
const MAX_SHADER_LINES: usize = 175;

/// Packages whose sources are examined.
const SOURCE_PACKAGES: [&str; 9] = [
    "common",
    "stage_check",
    "properties",
    "cpu",
    "gpu",
    "oracle",
    "radiosity",
    "web",
    "web/live",
];
/// Packages that other programs link, so their messages name no option.
const LIBRARIES: [&str; 5] = ["common", "stage_check", "properties", "cpu", "gpu"];
/// Packages that may use wgpu.
const WGPU_PACKAGES: [&str; 2] = ["stage_check", "gpu"];

fn sources() -> Vec<Source> {
    let all = SOURCE_PACKAGES
        .iter()
        .flat_map(|p| files_below(&format!("{p}/src"), ".rs"));
    all.filter(|(file, _)| !file.ends_with("/tests.rs"))
        .map(|(file, text)| Source::new(&file, &text))
        .collect()
}

/// Returns the names of a manifest's dependencies, of all its dependency sections.
fn dependency_names(manifest: &str) -> Vec<&str> {
    let mut in_section = false;
    let mut names = Vec::new();
    for line in manifest.lines() {
        if line.starts_with('[') {
            in_section = line.contains("dependencies]");
        } else if in_section && let Some(end) = line.find(['.', ' ', '=']) {
            names.push(&line[..end]);
        }
    }
    names
}

/// Returns one message for each forbidden dependency in the manifest.
fn forbidden_dependencies(package: &str, manifest: &str) -> Vec<String> {
    let (_, forbidden) = FORBIDDEN_DEPENDENCIES.iter().find(|(p, _)| *p == package).unwrap();
    dependency_names(manifest)
        .into_iter()
        .filter(|name| forbidden.contains(name))
        .map(|name| format!("{package} depends on {name}"))
        .collect()
}

/// Returns a message if a package names wgpu that may not, be it through a re-export.
fn misplaced_wgpu(source: &Source) -> Option<String> {
    let named = source.code.contains("wgpu::");
    (named && !WGPU_PACKAGES.contains(&source.package_name())).then(|| format!("{} names wgpu", source.file))
}

/// Imports between modules that lie side by side. A module inside of one counts as that one; parent and child
/// belong together.
fn sibling_imports(sources: &[Source]) -> BTreeSet<(String, String)> {
    let modules: BTreeSet<(&str, Vec<&str>)> = sources.iter().map(|s| (s.package_name(), s.module_path())).collect();
    let mut imports = BTreeSet::new();
    for source in sources {
        let package = source.package_name();
        let from = source.module_path();
        for path in source.used_paths() {
            let mut to = path;
            while !to.is_empty() && !modules.contains(&(package, to.clone())) {
                to.pop();
            }
            let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
            if shared < from.len() && shared < to.len() {
                let name = |path: &[&str]| format!("{package}::{}", path[..=shared].join("::"));
                imports.insert((name(&from), name(&to)));
            }
        }
    }
    imports
}

/// Returns the groups of modules that import each other in a circle, each as one line: `cpu::a, cpu::b`.
fn module_cycles(sources: &[Source]) -> BTreeSet<String> {
    let imports = sibling_imports(sources);
    let reachable = |from: &str| {
        let (mut seen, mut next) = (BTreeSet::new(), vec![from.to_owned()]);
        while let Some(at) = next.pop() {
            for (_, to) in imports.iter().filter(|(a, _)| *a == at) {
                if seen.insert(to.clone()) {
                    next.push(to.clone());
                }
            }
        }
        seen
    };
    let reached: BTreeMap<&str, BTreeSet<String>> = imports.iter().map(|(a, _)| (a.as_str(), reachable(a))).collect();
    let cycle = |a: &&str| -> Vec<&str> {
        let members = reached
            .iter()
            .filter(|(b, to)| to.contains(*a) && reached[a].contains(**b));
        members.map(|(b, _)| *b).collect()
    };
    let cycles = reached.keys().map(cycle).filter(|cycle| !cycle.is_empty());
    cycles.map(|cycle| cycle.join(", ")).collect()
}

/// Returns one message for each line of a library that names an option, such as `--texels`: only the program knows its
/// options.
fn named_options(source: &Source) -> Vec<String> {
    let names_option = |line: &&str| {
        let mut starts = line.match_indices("--");
        starts.any(|(at, _)| line[at + 2..].starts_with(|c: char| c.is_ascii_lowercase()))
    };
    let library = LIBRARIES.contains(&source.package_name());
    let lines = source.code.lines().filter(|line| library && names_option(line));
    lines.map(|line| format!("{}: {line}", source.file)).collect()
}

#[test]
fn packages_depend_in_one_direction() {
    let mut faults = Vec::new();
    for (package, _) in FORBIDDEN_DEPENDENCIES {
        let manifest = read_file(&format!("{package}/Cargo.toml")).unwrap();
        assert!(dependency_names(&manifest).len() > 2, "{package}");
        faults.extend(forbidden_dependencies(package, &manifest));
    }
    let sources = sources();
    let names_wgpu = |s: &Source| s.package_name() == "gpu" && s.code.contains("wgpu::");
    assert!(sources.iter().any(names_wgpu));
    faults.extend(sources.iter().filter_map(misplaced_wgpu));
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn modules_form_no_circles() {
    let sources = sources();
    assert!(sibling_imports(&sources).len() > 100);
    let cycles = module_cycles(&sources);
    assert!(cycles.is_empty(), "{cycles:#?}");
}

#[test]
fn shaders_are_short() {
    let shaders = files_below("gpu/src/shaders", ".wgsl");
    assert!(shaders.len() > 30);
    for (file, text) in shaders {
        let lines = text.lines().count();
        assert!(lines <= MAX_SHADER_LINES, "{file} has {lines} lines");
    }
}

#[test]
fn libraries_name_no_option_of_the_program() {
    let faults: Vec<String> = sources().iter().flat_map(named_options).collect();
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Plants one violation of each rule.
#[test]
fn violations_of_the_layout_are_found() {
    let manifest = "[dependencies]\ncpu.workspace = true\n[dev-dependencies]\nwgpu = { }\n[lib]\noracle = 1";
    assert_eq!(forbidden_dependencies("gpu", manifest), ["gpu depends on cpu"]);
    assert_eq!(forbidden_dependencies("oracle", manifest), ["oracle depends on wgpu"]);

    let source = |file: &str, text: &str| Source::new(file, text);
    assert!(misplaced_wgpu(&source("oracle/src/a.rs", "gpu::wgpu::Device")).is_some());
    assert!(misplaced_wgpu(&source("oracle/src/a.rs", "// wgpu::Device")).is_none());

    let cycles_with = |b: &str| {
        let a = source("cpu/src/a/mod.rs", "use crate::{b::{self, c}, d};\nmod inner;");
        let inner = source("cpu/src/a/inner.rs", "use super::X; fn f() { super::super::d::f() }");
        module_cycles(&[a, inner, source("cpu/src/b.rs", b), source("cpu/src/d.rs", "")])
    };
    assert!(cycles_with("// crate::a\nuse crate::d;\nuse std::a;").is_empty());
    for back in ["fn f() { crate::a::inner::g() }", "use super::{d, a::X};"] {
        assert_eq!(Vec::from_iter(cycles_with(back)), ["cpu::a, cpu::b"]);
    }

    let options = "f(\"lower --texels\");\ng(\"a -- b\") // --cells";
    let found = named_options(&source("gpu/src/a.rs", options));
    assert_eq!(found, ["gpu/src/a.rs: f(\"lower --texels\");"]);
    assert_eq!(named_options(&source("radiosity/src/a.rs", options)).len(), 0);
}
