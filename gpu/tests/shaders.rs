//! WGSL and Rust agree: members of structs have the offsets of the records, codes are those of the enums, and
//! shaders define no constant a second time.

use common::settings::{ItemBufferProjection, ItemBufferSettings, Transport, Visibility};
use common::shooting::SubtractedLink;
use gpu::shaders::{DRAWING_SHADERS, ENUM_CODES, HIERARCHY_LAYOUTS, LOG_COUNT_BYTES, TRANSPORT_LAYOUTS, module_source};
use obvhs::cwbvh::node::CwBvhNode;
use std::fs;
use std::mem::offset_of;
use std::path::{Path, PathBuf};
use wgpu::naga::{Expression, Literal, Module, TypeInner, front::wgsl::parse_str};

/// Constants that shaders may define themselves: no other file has them, or the twin has the same.
const SHADER_CONSTANTS: [&str; 3] = ["COUNTED_BIT", "EMPTY_BOUND", "FULL_BOUND"];

/// Name and text of every shader.
fn shader_texts() -> Vec<(String, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/shaders");
    let files = fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
    let named = |path: PathBuf| {
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        (name, fs::read_to_string(path).unwrap())
    };
    files.map(named).collect()
}

/// Returns every module that is compiled, for rays and for each projection.
fn compiled_modules() -> Vec<(String, Module)> {
    let drawn = ItemBufferProjection::ALL_PROJECTIONS;
    let drawn = drawn.map(|projection| Visibility::with_item_buffer(projection, 1024));
    let mut modules = Vec::new();
    for visibility in drawn.into_iter().chain([Visibility::Rays]) {
        let transport = Transport {
            visibility,
            ..Transport::default()
        };
        for (name, text) in shader_texts() {
            if !["@compute", "@vertex"].iter().any(|stage| text.contains(stage)) {
                continue;
            }
            if visibility == Visibility::Rays && DRAWING_SHADERS.contains(&name.as_str()) {
                assert!(module_source(&name, &transport, &[]).is_err(), "{name}");
                continue;
            }
            let text = module_source(&name, &transport, &[]).unwrap();
            let module = parse_str(&text).unwrap_or_else(|error| {
                panic!("{name}: {}", error.emit_to_string(&text));
            });
            modules.push((name, module));
        }
    }
    modules
}

/// Returns names and offsets of the members of a struct without padding, and its size.
fn struct_members(module: &Module, wanted: &str) -> Option<(Vec<(String, usize)>, usize)> {
    let (_, found) = (module.types.iter()).find(|(_, kind)| kind.name.as_deref() == Some(wanted))?;
    let TypeInner::Struct { members, span } = &found.inner else {
        panic!("{wanted} is no struct");
    };
    let members = members.iter().map(|member| {
        let name = member.name.clone().unwrap_or_default();
        (name, member.offset as usize)
    });
    let named = members.filter(|(name, _)| !name.starts_with("pad")).collect();
    Some((named, *span as usize))
}

/// Members of a node of obvhs, by their names in the shaders.
const NODE_MEMBERS: &[(&str, usize)] = &[
    ("origin", offset_of!(CwBvhNode, p)),
    ("scale", offset_of!(CwBvhNode, e)),
    ("children", offset_of!(CwBvhNode, child_base_idx)),
    ("primitives", offset_of!(CwBvhNode, primitive_base_idx)),
    ("kinds", offset_of!(CwBvhNode, child_meta)),
    ("x", offset_of!(CwBvhNode, child_min_x)),
    ("y", offset_of!(CwBvhNode, child_min_y)),
    ("z", offset_of!(CwBvhNode, child_min_z)),
];

#[test]
fn struct_members_have_the_offsets_of_the_records_and_of_obvhs() {
    let modules = compiled_modules();
    let records = TRANSPORT_LAYOUTS.into_iter().chain(HIERARCHY_LAYOUTS);
    let records = records.map(|layout| (layout.name, layout.members, layout.size));
    for (wanted, members, size) in records.chain([("Node", NODE_MEMBERS, size_of::<CwBvhNode>())]) {
        let named = members.iter().filter(|(name, _)| !name.starts_with("pad"));
        let record: Vec<(String, usize)> = named.map(|(name, at)| ((*name).to_owned(), *at)).collect();
        let mut seen = 0;
        for (name, module) in &modules {
            if let Some(found) = struct_members(module, wanted) {
                assert_eq!(found, (record.clone(), size), "{wanted} in {name}");
                seen += 1;
            }
        }
        assert!(seen > 0, "{wanted} is in no shader");
    }
}

#[test]
fn log_records_begin_at_the_offset_that_the_host_reads() {
    let modules = compiled_modules();
    let logs = modules.iter().filter_map(|(_, module)| struct_members(module, "Log"));
    let records = |(name, _): &(String, usize)| name == "records";
    let starts = logs.map(|(members, _)| members.into_iter().find(records).unwrap().1);
    let starts: Vec<usize> = starts.collect();
    assert!(!starts.is_empty());
    assert!(starts.iter().all(|at| *at as u64 == LOG_COUNT_BYTES), "{starts:?}");
}

/// Returns the value of a module's constant.
fn constant_value(module: &Module, wanted: &str) -> Option<u32> {
    let (_, found) = (module.constants.iter()).find(|(_, c)| c.name.as_deref() == Some(wanted))?;
    match module.global_expressions[found.init] {
        Expression::Literal(Literal::U32(value)) => Some(value),
        _ => panic!("{wanted} is no u32"),
    }
}

#[test]
fn shader_codes_equal_enum_values() {
    for (name, module) in compiled_modules() {
        for (code, value) in ENUM_CODES {
            assert_eq!(constant_value(&module, code), Some(value), "{code} in {name}");
        }
        let subtracted = constant_value(&module, "SUBTRACTED_BITS").unwrap();
        let bits = [
            subtracted,
            constant_value(&module, "CAPTURED_BIT").unwrap(),
            constant_value(&module, "KEEP_BIT").unwrap(),
            constant_value(&module, "PROBE_BIT").unwrap(),
        ];
        assert_eq!(subtracted & SubtractedLink::All as u32, SubtractedLink::All as u32);
        let union = bits.iter().fold(0, |union, bit| union | bit);
        assert_eq!(bits.iter().sum::<u32>(), union, "bits overlap");
    }
}

#[test]
fn modules_for_rays_define_no_projection() {
    let of = |visibility| Transport {
        visibility,
        ..Transport::default()
    };
    let drawn = of(Visibility::ItemBuffer(ItemBufferSettings::DEFAULT));
    for name in ["view", "link", "escape"] {
        let image = [&of(Visibility::Rays), &drawn].map(|transport| {
            let module = parse_str(&module_source(name, transport, &[]).unwrap()).unwrap();
            ["PROJECTION", "IMAGE_SIZE", "IMAGE_PLANES"].map(|wanted| constant_value(&module, wanted))
        });
        let code = ItemBufferProjection::Stereographic.shader_code();
        assert_eq!(image[0], [None, None, Some(0)], "{name}");
        assert_eq!(image[1], [Some(code), Some(1024), Some(1)], "{name}");
    }
}

/// Returns the names defined by `keyword` at the beginning of a line.
fn defined_names<'t>(text: &'t str, keyword: &str) -> Vec<&'t str> {
    let rests = text.lines().filter_map(|line| line.strip_prefix(keyword));
    let end = |c: char| !(c.is_alphanumeric() || c == '_');
    rests.filter_map(|rest| rest.split(end).next()).collect()
}

#[test]
fn shaders_define_no_shared_constant() {
    for (name, text) in shader_texts() {
        for constant in defined_names(&text, "const ") {
            assert!(SHADER_CONSTANTS.contains(&constant), "{constant} in {name}.wgsl");
        }
    }
}

#[test]
fn compiled_functions_are_found_in_the_texts() {
    let texts = shader_texts();
    let all: Vec<&str> = texts.iter().flat_map(|(_, text)| defined_names(text, "fn ")).collect();
    for (name, module) in compiled_modules() {
        let entries = module.entry_points.iter().map(|entry| entry.name.as_str());
        let others = (module.functions.iter()).filter_map(|(_, function)| function.name.as_deref());
        for function in entries.chain(others) {
            assert!(all.contains(&function), "{function} of {name}");
        }
    }
}
