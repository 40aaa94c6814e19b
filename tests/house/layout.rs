//! docs/architecture.md holds: who knows whom, no circles, no file and no function too long, and no
//! word of the program's command line in what others may link.

use super::source::{Source, files};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Whom a package must not depend on. Nobody depends on `oracle` but those who test and measure.
const STRANGERS: [(&str, &[&str]); 6] = [
    ("common", &["cpu", "gpu", "oracle", "wgpu"]),
    ("cpu", &["gpu", "oracle", "wgpu"]),
    ("gpu", &["cpu", "oracle"]),
    ("oracle", &["wgpu"]),
    ("tests", &["wgpu"]),
    ("benches", &["wgpu"]),
];

/// Lines of a file, its tests not counted; the aim is 300.
const FILE: usize = 450;
/// Lines of a function; the aim is 70.
const FUNCTION: usize = 100;
/// Lines of a shader; the aim is 150.
const SHADER: usize = 175;

/// Being cut: what is longer today.
const LONG: &[&str] = &[];

/// Being untied: knots of today. They may lose modules and gain none.
const TIED: &[&str] = &[
    // Folders: a page is shown by whom it is about, and a solve is refined by what compares.
    "oracle::judge, oracle::plan, oracle::relight, oracle::show, oracle::solve",
    "oracle::judge::compare, oracle::judge::comparison, oracle::judge::diff",
];

/// Being reworded: files whose messages name options today.
const OPTIONS: &[&str] = &["gpu/src/adapter.rs"];

/// Packages whose sources are held.
const SOURCES: [&str; 4] = ["common", "cpu", "gpu", "oracle"];
/// Those of them that others may link, and whose messages therefore name no option.
const LIBRARIES: [&str; 3] = ["common", "cpu", "gpu"];

fn sources() -> Vec<Source> {
    let all = SOURCES
        .iter()
        .flat_map(|p| files(&format!("{p}/src"), ".rs"));
    all.filter(|(file, _)| !file.ends_with("/tests.rs"))
        .map(|(file, text)| Source::new(&file, &text))
        .collect()
}

/// What a manifest depends on, whatever the section.
fn dependencies(manifest: &str) -> Vec<&str> {
    let mut inside = false;
    let mut found = Vec::new();
    for line in manifest.lines() {
        if line.starts_with('[') {
            inside = line.contains("dependencies]");
        } else if inside && let Some(end) = line.find(['.', ' ', '=']) {
            found.push(&line[..end]);
        }
    }
    found
}

fn strangers(package: &str, manifest: &str) -> Vec<String> {
    let (_, banned) = STRANGERS.iter().find(|(p, _)| *p == package).unwrap();
    let known = dependencies(manifest).into_iter();
    known
        .filter(|name| banned.contains(name))
        .map(|name| format!("{package} knows {name}"))
        .collect()
}

/// Who passes another's device types on makes others know wgpu.
fn device_types(source: &Source) -> Option<String> {
    let named = source.code.contains("wgpu::");
    (source.package() != "gpu" && named).then(|| format!("{} names wgpu", source.file))
}

/// Imports between two modules that lie side by side; whoever is inside of one speaks for it.
fn imports(sources: &[Source]) -> BTreeSet<(String, String)> {
    let modules: BTreeSet<(&str, Vec<&str>)> =
        sources.iter().map(|s| (s.package(), s.module())).collect();
    let mut found = BTreeSet::new();
    for source in sources {
        let from = source.module();
        for path in source.paths() {
            let mut to: Vec<&str> = path.iter().map(String::as_str).collect();
            while !to.is_empty() && !modules.contains(&(source.package(), to.clone())) {
                to.pop();
            }
            let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
            // Parent and child belong together.
            if common < from.len() && common < to.len() {
                let name =
                    |path: &[&str]| format!("{}::{}", source.package(), path[..=common].join("::"));
                found.insert((name(&from), name(&to)));
            }
        }
    }
    found
}

/// Modules that lead to each other, each knot one line: `cpu::a, cpu::b`.
fn knots(sources: &[Source]) -> BTreeSet<String> {
    let imports = imports(sources);
    let reached = |from: &str| {
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
    let all: BTreeMap<&str, BTreeSet<String>> = imports
        .iter()
        .map(|(a, _)| (a.as_str(), reached(a)))
        .collect();
    let knot = |a: &&str| -> Vec<&str> {
        let others = all
            .iter()
            .filter(|(b, to)| to.contains(*a) && all[a].contains(**b));
        others.map(|(b, _)| *b).collect()
    };
    let knots = all.keys().map(knot).filter(|knot| !knot.is_empty());
    knots.map(|knot| knot.join(", ")).collect()
}

fn long_files(sources: &[Source]) -> Vec<String> {
    let long = sources.iter().filter(|s| s.lines > FILE);
    long.map(|s| format!("{} has {} lines", s.file, s.lines))
        .collect()
}

fn long_functions(source: &Source) -> Vec<String> {
    let long = source.functions().into_iter().filter(|f| f.1 > FUNCTION);
    long.map(|(name, lines)| format!("{} {name} has {lines} lines", source.file))
        .collect()
}

/// `--texels` in a message of a library: only `oracle` knows what its options are called.
fn options(source: &Source) -> Vec<String> {
    let named = |text: &&String| {
        let mut starts = text.match_indices("--");
        starts.any(|(at, _)| text[at + 2..].starts_with(|c: char| c.is_ascii_lowercase()))
    };
    let found = source.literals.iter().filter(named);
    let library = LIBRARIES.contains(&source.package());
    found
        .filter(|_| library)
        .map(|text| format!("{}: {text}", source.file))
        .collect()
}

/// No fault but those that are known, and each of these still there: else it is time to strike it out.
fn none_but(known: &[&str], faults: &[String], is: impl Fn(&str, &str) -> bool) {
    let (new, gone) = (
        faults.iter().filter(|f| !known.iter().any(|k| is(k, f))),
        known.iter().filter(|k| !faults.iter().any(|f| is(k, f))),
    );
    let (new, gone) = (Vec::from_iter(new), Vec::from_iter(gone));
    assert!(
        new.is_empty() && gone.is_empty(),
        "new: {new:#?}\nmended, to be struck out: {gone:#?}"
    );
}

/// The message is about this file.
fn about(known: &str, fault: &str) -> bool {
    fault.starts_with(known)
}

/// A knot, or what is left of it.
fn within(known: &str, fault: &str) -> bool {
    let known: Vec<&str> = known.split(", ").collect();
    fault.split(", ").all(|module| known.contains(&module))
}

#[test]
fn packages_know_whom_they_may() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut faults = Vec::new();
    for (package, _) in STRANGERS {
        let manifest = fs::read_to_string(root.join(package).join("Cargo.toml")).unwrap();
        assert!(dependencies(&manifest).len() > 3, "{package}");
        faults.extend(strangers(package, &manifest));
    }
    let sources = sources();
    let device = |s: &Source| s.package() == "gpu" && s.code.contains("wgpu::");
    assert!(sources.iter().any(device));
    faults.extend(sources.iter().filter_map(device_types));
    none_but(&[], &faults, about);
}

#[test]
fn no_module_leads_back_to_itself() {
    let sources = sources();
    assert!(imports(&sources).len() > 100);
    none_but(TIED, &Vec::from_iter(knots(&sources)), within);
}

#[test]
fn files_and_functions_are_short() {
    let sources = sources();
    let functions: usize = sources.iter().map(|s| s.functions().len()).sum();
    assert!(functions > 1000, "{functions}");
    let mut faults = long_files(&sources);
    faults.extend(sources.iter().flat_map(long_functions));
    for (file, text) in files("gpu/src/shaders", ".wgsl") {
        if text.lines().count() > SHADER {
            faults.push(format!("{file} has {} lines", text.lines().count()));
        }
    }
    none_but(LONG, &faults, about);
}

#[test]
fn libraries_name_no_option_of_the_program() {
    let faults: Vec<String> = sources().iter().flat_map(options).collect();
    none_but(OPTIONS, &faults, about);
}

/// Each promise broken once.
#[test]
fn what_breaks_a_promise_is_found() {
    let manifest =
        "[dependencies]\ncpu.workspace = true\n[dev-dependencies]\nwgpu = { }\n[lib]\noracle = 1";
    assert_eq!(strangers("gpu", manifest), ["gpu knows cpu"]);
    assert_eq!(strangers("oracle", manifest), ["oracle knows wgpu"]);

    let of = |file: &str, text: &str| Source::new(file, text);
    assert!(device_types(&of("oracle/src/a.rs", "gpu::wgpu::Device")).is_some());
    assert!(device_types(&of("oracle/src/a.rs", "// wgpu::Device")).is_none());

    let circle = |b: &str| {
        let a = of(
            "cpu/src/a/mod.rs",
            "use crate::{b::{self, c}, d};\nmod inner;",
        );
        let inner = of(
            "cpu/src/a/inner.rs",
            "use super::X; fn f() { super::super::d::f() }",
        );
        knots(&[a, inner, of("cpu/src/b.rs", b), of("cpu/src/d.rs", "")])
    };
    assert!(circle("// crate::a\nuse crate::d;\nuse std::a;").is_empty());
    for back in ["fn f() { crate::a::inner::g() }", "use super::{d, a::X};"] {
        assert_eq!(Vec::from_iter(circle(back)), ["cpu::a, cpu::b"]);
    }

    let body = "    let s = \"}\";\n".repeat(FUNCTION);
    let long = of(
        "cpu/src/a.rs",
        &format!("fn g() {{}}\nfn f(a: [u8; 2]) {{\n{body}}}\nfn h();"),
    );
    assert_eq!(long_functions(&long), ["cpu/src/a.rs f has 102 lines"]);
    assert_eq!(
        long_files(&[of("cpu/src/a.rs", &"\n".repeat(FILE + 1))]).len(),
        1
    );
    let tested = format!("\n#[cfg(test)]\nmod tests {{{}}}", "\n".repeat(FILE));
    assert_eq!(long_files(&[of("cpu/src/a.rs", &tested)]).len(), 0);

    let says = "f(r#\"lower --texels\"#, '\"', \"a -- b\") // \"--cells\"";
    assert_eq!(
        options(&of("gpu/src/a.rs", says)),
        ["gpu/src/a.rs: lower --texels"]
    );
    assert_eq!(options(&of("oracle/src/a.rs", says)).len(), 0);
}
