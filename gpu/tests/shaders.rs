//! The WGSL against the Rust that it must agree with: the members of its structs lie where the records
//! have them, its codes are those of the enums, and its functions have twins of the same name in the
//! file that the shader's first lines name.

use common::form_factor::FormFactor;
use common::mesh::{Cover, TexelKind};
use common::rays::Sight;
use common::settings::{Drawing, Projection, Raster, Transport, Visibility};
use common::shooting::Subtracted;
use gpu::shaders::{HIERARCHY_LAYOUTS, LAYOUTS, LOG_COUNT_BYTES, source};
use obvhs::cwbvh::node::CwBvhNode;
use std::fs;
use std::mem::offset_of;
use std::path::{Path, PathBuf};
use wgpu::naga::{Expression, Literal, Module, TypeInner, front::wgsl::parse_str};

/// Functions without a twin of their name, and why.
const NO_TWIN: [(&str, &[&str], &str); 23] = [
    (
        "bounds",
        &["bounds", "bound_of"],
        "a spot at a time of Bounds::call",
    ),
    (
        "choose",
        &["append", "first", "again", "enough", "weigh"],
        "choose and through, cut where the spots are asked",
    ),
    (
        "choose",
        &["seen_of", "whole"],
        "a link's own: Sampled::call has the sum",
    ),
    (
        "factors",
        &["factor", "lambert", "write", "plain", "clipped"],
        "a spot at a time of Factors::call and rows::lanes::form_factors",
    ),
    ("pack", &["pack"], "the host's lists grow"),
    ("parts", &["parts"], "the host's lists grow"),
    ("reset", &["reset"], "the host asks at once"),
    ("sampled", &["sampled"], "a spot at a time of Sampled::call"),
    ("scan", &["scan", "made"], "the host's lists grow"),
    ("aim", &["whole", "draw"], "the host's loops draw"),
    (
        "collect",
        &["collect"],
        "accumulate is its loop, over rows of links",
    ),
    (
        "exchange",
        &["exchange"],
        "accumulate is its loop, over rows of what cells take",
    ),
    (
        "form_factor",
        &["to_corner"],
        "the twin keeps a list of the corners",
    ),
    (
        "item_buffer",
        &["vertex", "seen"],
        "draw_pixels asks the bound's pixels, nothing is handed on",
    ),
    ("link", &["links_of"], "the solver's loop over texels"),
    (
        "measure",
        &["copy", "multiply"],
        "measures the machine, computes nothing",
    ),
    ("frame", &["look"], "a twin's frame is an argument"),
    ("projection", &["tile"], "a twin has one buffer"),
    (
        "select",
        &["first", "next", "record", "load"],
        "the host's loop: Engine::run keeps the log",
    ),
    (
        "select",
        &["reduce", "choose"],
        "total and select: WGSL has a select of its own",
    ),
    ("select", &["dispatch"], "the host knows what it has to do"),
    (
        "tessellate",
        &["tessellate"],
        "draw_tessellated goes level by level",
    ),
    (
        "types",
        &["flat"],
        "a workgroup's number: the host has none",
    ),
];

/// Shaders whose twin is another's.
const FOREIGN: [(&str, &str); 1] = [("tree", "obvhs")];

/// Constants that shaders may define themselves: nobody else knows them, or the twin has the same.
const OWN: [&str; 3] = ["KNOWN", "NOWHERE", "EVERYWHERE"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Name and text of every shader.
fn shaders() -> Vec<(String, String)> {
    let folder = root().join("gpu/src/shaders");
    let files = fs::read_dir(folder)
        .unwrap()
        .map(|file| file.unwrap().path());
    let named = |path: PathBuf| {
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        (name, fs::read_to_string(path).unwrap())
    };
    files.map(named).collect()
}

/// What draws item buffers: no ray needs them.
const DRAW: [&str; 3] = ["item_buffer", "item_buffer_tessellated", "tessellate"];

/// Every module that is compiled, by rays and by each projection.
fn modules() -> Vec<(String, Module)> {
    let drawn = [
        Projection::Paper,
        Projection::Hemisphere(Raster::Pixel),
        Projection::Stereographic(Raster::Pixel),
        Projection::Hemicube,
    ];
    let drawn = drawn.map(|projection| Visibility::drawn(projection, 1024));
    let mut modules = Vec::new();
    for visibility in drawn.into_iter().chain([Visibility::Rays]) {
        let transport = Transport {
            visibility,
            ..Transport::default()
        };
        for (name, text) in shaders() {
            if !["@compute", "@vertex"]
                .iter()
                .any(|stage| text.contains(stage))
            {
                continue;
            }
            if visibility == Visibility::Rays && DRAW.contains(&name.as_str()) {
                assert!(source(&name, &transport, &[]).is_err(), "{name}");
                continue;
            }
            let text = source(&name, &transport, &[]).unwrap();
            let module = parse_str(&text).unwrap_or_else(|error| {
                panic!("{name}: {}", error.emit_to_string(&text));
            });
            modules.push((name, module));
        }
    }
    modules
}

/// Names, offsets and size of a struct; padding has no twin.
fn members(module: &Module, wanted: &str) -> Option<(Vec<(String, usize)>, usize)> {
    let (_, found) =
        (module.types.iter()).find(|(_, kind)| kind.name.as_deref() == Some(wanted))?;
    let TypeInner::Struct { members, span } = &found.inner else {
        panic!("{wanted} is no struct");
    };
    let members = members.iter().map(|member| {
        let name = member.name.clone().unwrap_or_default();
        (name, member.offset as usize)
    });
    let named = members
        .filter(|(name, _)| !name.starts_with("pad"))
        .collect();
    Some((named, *span as usize))
}

#[test]
fn structs_lie_as_the_records_do() {
    let modules = modules();
    for layout in LAYOUTS.into_iter().chain(HIERARCHY_LAYOUTS) {
        let named = (layout.members.iter()).filter(|(name, _)| !name.starts_with("pad"));
        let record: Vec<(String, usize)> =
            named.map(|(name, at)| ((*name).to_owned(), *at)).collect();
        let mut seen = 0;
        for (name, module) in &modules {
            if let Some((members, size)) = members(module, layout.name) {
                assert_eq!(members, record, "{} in {name}", layout.name);
                assert_eq!(size, layout.size, "{} in {name}", layout.name);
                seen += 1;
            }
        }
        assert!(seen > 0, "{} is in no shader", layout.name);
    }
}

#[test]
fn the_log_begins_where_the_host_reads_it() {
    let modules = modules();
    let logs = modules
        .iter()
        .filter_map(|(_, module)| members(module, "Log"));
    let records = |(name, _): &(String, usize)| name == "records";
    let starts = logs.map(|(members, _)| members.into_iter().find(records).unwrap().1);
    let starts: Vec<usize> = starts.collect();
    assert!(!starts.is_empty());
    assert!(
        starts.iter().all(|at| *at as u64 == LOG_COUNT_BYTES),
        "{starts:?}"
    );
}

#[test]
fn nodes_lie_as_the_tree_s_do() {
    let node = [
        ("origin", offset_of!(CwBvhNode, p)),
        ("scale", offset_of!(CwBvhNode, e)),
        ("children", offset_of!(CwBvhNode, child_base_idx)),
        ("primitives", offset_of!(CwBvhNode, primitive_base_idx)),
        ("kinds", offset_of!(CwBvhNode, child_meta)),
        ("x", offset_of!(CwBvhNode, child_min_x)),
        ("y", offset_of!(CwBvhNode, child_min_y)),
        ("z", offset_of!(CwBvhNode, child_min_z)),
    ];
    let node = node.map(|(name, at)| (name.to_owned(), at)).to_vec();
    let modules = modules();
    let found = modules
        .iter()
        .filter_map(|(_, module)| members(module, "Node"));
    let found: Vec<_> = found.collect();
    assert!(!found.is_empty());
    for (members, size) in found {
        assert_eq!((members, size), (node.clone(), size_of::<CwBvhNode>()));
    }
}

/// The value of a module's constant.
fn constant(module: &Module, wanted: &str) -> Option<u32> {
    let (_, found) = (module.constants.iter()).find(|(_, c)| c.name.as_deref() == Some(wanted))?;
    match module.global_expressions[found.init] {
        Expression::Literal(Literal::U32(value)) => Some(value),
        _ => panic!("{wanted} is no u32"),
    }
}

#[test]
fn codes_are_those_of_the_enums() {
    let codes = [
        ("PROJECTION_PAPER", Projection::Paper.code()),
        (
            "PROJECTION_HEMISPHERE",
            Projection::Hemisphere(Raster::Tessellated).code(),
        ),
        (
            "PROJECTION_STEREOGRAPHIC",
            Projection::Stereographic(Raster::Tessellated).code(),
        ),
        ("PROJECTION_HEMICUBE", Projection::Hemicube.code()),
        ("FORM_FACTOR_PAPER", FormFactor::Paper as u32),
        ("FORM_FACTOR_DISC", FormFactor::Disc as u32),
        ("QUAD", TexelKind::Quad as u32),
        ("INVERTED", TexelKind::Inverted as u32),
        ("COVER_OPEN", Cover::Open as u32),
        ("COVER_ROOM", Cover::Room as u32),
        ("BLOCKED", Sight::Blocked as u32),
        ("HIDDEN_BY_OBJECT", Sight::Hidden as u32),
        ("CLEAR", Sight::Clear as u32),
        ("SUBTRACTED_BEFORE", Subtracted::Before as u32),
        ("SUBTRACTED_UNHIDDEN", Subtracted::Unhidden as u32),
        ("SUBTRACTED_ALL", Subtracted::All as u32),
    ];
    for (name, module) in modules() {
        for (code, value) in codes {
            assert_eq!(constant(&module, code), Some(value), "{code} in {name}");
        }
        let subtracted = constant(&module, "SUBTRACTED").unwrap();
        let bits = [
            subtracted,
            constant(&module, "CAPTURED").unwrap(),
            constant(&module, "KEEP").unwrap(),
        ];
        assert_eq!(subtracted & Subtracted::All as u32, Subtracted::All as u32);
        assert_eq!(
            bits[0] + bits[1] + bits[2],
            bits[0] | bits[1] | bits[2],
            "bits overlap"
        );
    }
}

#[test]
fn rays_have_no_projection() {
    let of = |visibility| Transport {
        visibility,
        ..Transport::default()
    };
    let drawn = of(Visibility::Drawn(Drawing::DEFAULT));
    for name in ["aim", "link", "escape"] {
        let image = [&of(Visibility::Rays), &drawn].map(|transport| {
            let module = parse_str(&source(name, transport, &[]).unwrap()).unwrap();
            ["PROJECTION", "SIZE", "SIDES"].map(|wanted| constant(&module, wanted))
        });
        let code = Projection::Stereographic(Raster::Pixel).code();
        assert_eq!(image[0], [None, None, Some(0)], "{name}");
        assert_eq!(image[1], [Some(code), Some(1024), Some(1)], "{name}");
    }
}

/// What comes after `keyword` at the beginning of a line.
fn defined<'t>(text: &'t str, keyword: &str) -> Vec<&'t str> {
    let rests = text.lines().filter_map(|line| line.strip_prefix(keyword));
    let end = |c: char| !(c.is_alphanumeric() || c == '_');
    rests.filter_map(|rest| rest.split(end).next()).collect()
}

#[test]
fn shaders_write_no_constant_a_second_time() {
    for (name, text) in shaders() {
        for constant in defined(&text, "const ") {
            assert!(OWN.contains(&constant), "{constant} in {name}.wgsl");
        }
    }
}

/// The texts of the files that the shader's first lines call its twins.
fn twins(name: &str, text: &str) -> String {
    let head: String = text
        .lines()
        .take_while(|line| line.starts_with("//"))
        .collect();
    let (_, files) = head.split_once("Twin").unwrap_or(("", ""));
    let words = files.split(|c: char| c.is_whitespace() || ",;".contains(c));
    let files: Vec<&str> = (words.map(|word| word.trim_end_matches(['.', ':'])))
        .filter(|word| word.ends_with(".rs"))
        .collect();
    let read = |file: &&str| {
        let text = fs::read_to_string(root().join(file));
        text.unwrap_or_else(|error| panic!("{name}.wgsl names {file}: {error}"))
    };
    files.iter().map(read).collect()
}

#[test]
fn functions_have_twins_of_their_name() {
    for (name, text) in shaders() {
        if FOREIGN.iter().any(|(file, _)| *file == name) {
            continue;
        }
        let rust = twins(&name, &text);
        let excused: Vec<&str> = NO_TWIN
            .iter()
            .filter(|(file, ..)| *file == name)
            .flat_map(|(_, functions, _)| functions.iter().copied())
            .collect();
        let functions = defined(&text, "fn ");
        for function in &functions {
            let has = ["(", "<"]
                .iter()
                .any(|end| rust.contains(&format!("fn {function}{end}")));
            let excuse = excused.contains(function);
            assert!(
                has != excuse,
                "{function} in {name}.wgsl: twin {has}, excused {excuse}"
            );
        }
        for function in excused {
            assert!(
                functions.contains(&function),
                "{name}.wgsl has no {function}"
            );
        }
    }
}

#[test]
fn every_function_is_found() {
    let texts = shaders();
    let all: Vec<&str> = texts
        .iter()
        .flat_map(|(_, text)| defined(text, "fn "))
        .collect();
    for (name, module) in modules() {
        let entries = module.entry_points.iter().map(|entry| entry.name.as_str());
        let others = (module.functions.iter()).filter_map(|(_, function)| function.name.as_deref());
        for function in entries.chain(others) {
            assert!(all.contains(&function), "{function} of {name}");
        }
    }
}
