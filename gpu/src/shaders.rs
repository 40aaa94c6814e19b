//! Assembly of the WGSL modules: constants from Rust, then shader files. Pipelines are compiled from them.
//! Tests plant faults here.

use crate::dispatch_arguments::{CountedStage, DISPATCH_WORDS};
use crate::function_calls::FunctionCall;
pub use crate::link_records::LINK_LAYOUTS as HIERARCHY_LAYOUTS;
use crate::link_records::{BLOCK_SPOTS, PairState};
use crate::module_text::ModuleText;
use crate::records::{CAPTURED_BIT, KEEP_BIT, PROBE_BIT, SUBTRACTED_BITS};
pub use crate::records::{LOG_COUNT_BYTES, RecordLayout, TRANSPORT_LAYOUTS};
use crate::shader_files::{SHADER_STAGES, ShaderFile, ShaderStage};
use common::constants::*;
use common::escape::ESCAPE_DIRECTION_COUNT;
use common::form_factor::FormFactor;
use common::mesh::{Cover, TexelKind};
use common::rays::LineOfSight;
use common::sampling::{RECURRENCE_STEPS, STEP_OFFSETS};
use common::settings::{ItemBufferProjection, ItemBufferSettings, Transport, Visibility};
use common::shooting::SubtractedLink;
use common::{Error, Result};

/// A planted fault: in shader file `file`, the one place that reads `from` reads `to` instead.
/// Tests use it to prove that a comparison can fail.
#[derive(Clone, Copy, Debug)]
pub struct ShaderFault {
    /// File name in `shaders/`, without ending.
    pub file: &'static str,
    /// Text that occurs exactly once.
    pub from: &'static str,
    /// Replacement.
    pub to: &'static str,
}

/// Shaders that draw item buffers.
pub const DRAWING_SHADERS: [&str; 2] = ["item_buffer", "item_buffer_paper"];

/// Returns the text of a shader file, with the faults planted in it.
fn shader_text(name: &str, text: &str, faults: &[ShaderFault]) -> Result<String> {
    let mut text = text.to_owned();
    for fault in faults.iter().filter(|fault| fault.file == name) {
        if text.matches(fault.from).count() != 1 {
            return Err(Error::Usage(format!("{name}: {:?} does not occur once", fault.from)));
        }
        text = text.replace(fault.from, fault.to);
    }
    Ok(text)
}

/// Returns the text of the module of shader `name`: constants, the files that it includes, and its own file.
///
/// Errors: [`Error::Usage`] for a shader that draws where visibility is by rays, for an unknown shader, and
/// for a fault whose text does not occur once.
pub fn module_source(name: &str, transport: &Transport, faults: &[ShaderFault]) -> Result<String> {
    Ok(assemble_module(name, transport, faults, &[])?.text())
}

/// Returns the module of shader `name`, in which `given` files take the place of the program's.
///
/// Errors: as of [`module_source`].
pub(crate) fn assemble_module<'f>(
    name: &str,
    transport: &Transport,
    faults: &[ShaderFault],
    given: &'f [ShaderFile],
) -> Result<ModuleText<'f>> {
    let drawing = transport.visibility.item_buffer();
    if drawing.is_none() && DRAWING_SHADERS.contains(&name) {
        return Err(Error::Usage(format!(
            "{name} draws item buffers, and visibility is by rays"
        )));
    }
    let includes = included_files(name, drawing.is_some());
    join_files(includes.iter().chain([&name]), transport, faults, given)
}

/// Returns the module that calls a function.
///
/// Errors: as of [`module_source`].
pub(crate) fn assemble_call<'f>(
    call: &FunctionCall,
    transport: &Transport,
    faults: &[ShaderFault],
    given: &'f [ShaderFile],
) -> Result<ModuleText<'f>> {
    let mut module = join_files(call.files, transport, faults, given)?;
    module.add_part(call.function, call.entry_text(), None);
    Ok(module)
}

/// Joins constants, `types` and these files, in which `given` ones take the place of the program's.
fn join_files<'f, 'n>(
    names: impl IntoIterator<Item = &'n &'n str>,
    transport: &Transport,
    faults: &[ShaderFault],
    given: &'f [ShaderFile],
) -> Result<ModuleText<'f>> {
    let mut module = ModuleText::new(constant_declarations(transport));
    for part in ["types"].iter().chain(names) {
        let stage = ShaderStage::find(part)?;
        let file = given.iter().find(|file| file.stage == *part);
        let text = file.map_or(stage.text, |file| &file.text);
        module.add_part(stage.name, shader_text(part, text, faults)?, file);
    }
    Ok(module)
}

/// Compiles each module that has one of the `given` files in it, without a GPU. A file that compiles with rays or
/// with item buffers passes.
///
/// Errors: of the first file that does not compile, or lacks an entry point.
pub fn check_shader_files(given: &[ShaderFile]) -> Result<()> {
    let visibilities = [Visibility::ItemBuffer(ItemBufferSettings::DEFAULT), Visibility::Rays];
    for stage in SHADER_STAGES
        .iter()
        .filter(|stage| stage.entry_points().next().is_some())
    {
        let mut failure = None;
        for visibility in visibilities {
            let transport = Transport {
                visibility,
                ..Transport::default()
            };
            let Ok(module) = assemble_module(stage.name, &transport, &[], given) else {
                continue;
            };
            if module.given_file().is_some() {
                match module
                    .parse()
                    .and_then(|parsed| module.require_entries(&parsed, stage.entry_points()))
                {
                    Err(error) => failure = failure.or(Some(error)),
                    Ok(()) => {
                        failure = None;
                        break;
                    }
                }
            }
        }
        failure.map_or(Ok(()), Err)?;
    }
    Ok(())
}

/// Returns the files that the module of shader `name` includes beside `types`, in order.
fn included_files(name: &str, has_item_buffer: bool) -> &'static [&'static str] {
    match name {
        "link" if !has_item_buffer => &["sampling", "texel_point", "form_factor", "intersect", "bvh", "rays"],
        "link" => &[
            "sampling",
            "texel_point",
            "form_factor",
            "frame",
            "hemicube",
            "projection",
            "intersect",
            "lookup",
        ],
        "escape" => &["frame", "intersect", "bvh"],
        "item_buffer_paper" => &["frame", "hemicube", "projection", "image_bound"],
        "item_buffer" => &["frame", "hemicube", "projection", "image_bound", "intersect"],
        "link_factors" => &["hierarchy_types", "sampling", "surface_points", "form_factor"],
        "sample_links" => &[
            "hierarchy_types",
            "sampling",
            "surface_points",
            "form_factor",
            "intersect",
            "bvh",
            "rays",
        ],
        "refine" => &["hierarchy_types", "visibility_samples"],
        "link_bounds" | "prefix_sum" | "subdivide_nodes" | "add_links" | "store_links" => &["hierarchy_types"],
        _ => &[],
    }
}

fn constant_declarations(transport: &Transport) -> String {
    let mut text = String::new();
    let drawing = transport.visibility.item_buffer();
    // With visibility by rays there is no image: no planes, and none of its constants.
    let sides = drawing.map_or(0, |drawing| drawing.projection.plane_count());
    let chosen = [("IMAGE_PLANES", sides), ("FORM_FACTOR", transport.form_factor as u32)];
    let image = drawing.iter().flat_map(image_constants);
    for (name, value) in INTEGER_CONSTANTS
        .into_iter()
        .chain(ENUM_CODES)
        .chain(chosen)
        .chain(image)
    {
        text.push_str(&format!("const {name}: u32 = {value}u;\n"));
    }
    if let Some(drawing) = drawing {
        let reach = drawing.lookup.reach_pixels();
        text.push_str(&format!("const LOOKUP_REACH: i32 = {reach};\n"));
    }
    let offsets = [("STEP_OFFSET_U", STEP_OFFSETS[0]), ("STEP_OFFSET_V", STEP_OFFSETS[1])];
    for (name, value) in REAL_CONSTANTS.into_iter().chain(offsets) {
        text.push_str(&format!("const {name}: f32 = {value:?}f;\n"));
    }
    text
}

/// Integer constants of an item buffer.
fn image_constants(drawing: &ItemBufferSettings) -> [(&'static str, u32); 2] {
    [
        ("IMAGE_SIZE", drawing.size),
        ("PROJECTION", drawing.projection.shader_code()),
    ]
}

/// Integer constants that are the same in every solve.
pub const INTEGER_CONSTANTS: [(&str, u32); 15] = [
    ("PATCH_SUM_LANES", PATCH_SUM_LANES as u32),
    ("NEAR_POINTS_PER_SIDE", NEAR_POINTS_PER_SIDE),
    ("SELECT_LANES", SELECT_LANES as u32),
    ("ESCAPE_DIRECTION_COUNT", ESCAPE_DIRECTION_COUNT as u32),
    ("STEP_U", RECURRENCE_STEPS[0]),
    ("STEP_V", RECURRENCE_STEPS[1]),
    ("STEP_PATCH_U", RECURRENCE_STEPS[2]),
    ("STEP_PATCH_V", RECURRENCE_STEPS[3]),
    ("BLOCK_SPOTS", BLOCK_SPOTS),
    ("SAMPLES_FIRST", VISIBILITY_SAMPLE_COUNTS[0]),
    ("SAMPLES_SECOND", VISIBILITY_SAMPLE_COUNTS[1]),
    ("SAMPLES_SUBDIVIDE", VISIBILITY_SAMPLE_COUNTS[2]),
    ("SAMPLES_MAX", VISIBILITY_SAMPLE_COUNTS[3]),
    ("RAY_STACK_LEVELS", RAY_STACK_LEVELS),
    ("DISPATCH_WORDS", DISPATCH_WORDS),
];

/// Codes of enums: their order in Rust, of projections their code.
pub const ENUM_CODES: [(&str, u32); 30] = [
    ("PROJECTION_PAPER", ItemBufferProjection::Paper.shader_code()),
    ("PROJECTION_HEMISPHERE", ItemBufferProjection::Hemisphere.shader_code()),
    (
        "PROJECTION_STEREOGRAPHIC",
        ItemBufferProjection::Stereographic.shader_code(),
    ),
    ("PROJECTION_HEMICUBE", ItemBufferProjection::Hemicube.shader_code()),
    ("FORM_FACTOR_PAPER", FormFactor::Paper as u32),
    ("FORM_FACTOR_DISC", FormFactor::Disc as u32),
    ("TEXEL_QUAD", TexelKind::Quad as u32),
    ("TEXEL_INVERTED", TexelKind::Inverted as u32),
    ("COVER_OPEN", Cover::Open as u32),
    ("COVER_ROOM", Cover::Room as u32),
    ("SIGHT_BLOCKED", LineOfSight::Blocked as u32),
    ("SIGHT_HIDDEN_BY_OBJECT", LineOfSight::HiddenByObject as u32),
    ("SIGHT_CLEAR", LineOfSight::Clear as u32),
    ("SUBTRACTED_BITS", SUBTRACTED_BITS),
    ("SUBTRACTED_BEFORE", SubtractedLink::Before as u32),
    ("SUBTRACTED_UNHIDDEN", SubtractedLink::Unhidden as u32),
    ("SUBTRACTED_ALL", SubtractedLink::All as u32),
    ("CAPTURED_BIT", CAPTURED_BIT),
    ("KEEP_BIT", KEEP_BIT),
    ("PROBE_BIT", PROBE_BIT),
    ("PAIR_SKIP", PairState::Skip as u32),
    ("PAIR_SUBDIVIDE", PairState::Subdivide as u32),
    ("PAIR_PENDING", PairState::Pending as u32),
    ("PAIR_LINK", PairState::Link as u32),
    ("PAIR_EDGE", PairState::Edge as u32),
    ("COUNTED_DEPOSIT", CountedStage::Deposit as u32),
    ("COUNTED_ESCAPE", CountedStage::Escape as u32),
    ("COUNTED_POWER", CountedStage::Power as u32),
    ("COUNTED_LINKS", CountedStage::Links as u32),
    ("COUNTED_TRANSFER", CountedStage::Transfer as u32),
];

/// Makes a table of the names and the values of constants.
macro_rules! named_constants {
    ($($name:ident)*) => { [$((stringify!($name), $name)),*] };
}

/// Floating-point constants.
const REAL_CONSTANTS: [(&str, f32); 19] = named_constants! {
    PI CONTACT_DISTANCE FAR_DISTANCE_RADII NEAR_OFFSET_QUAD NEAR_OFFSET_TRIANGLE POINT_SOURCE_RADII ONE_SAMPLE_LIMIT
    MAX_PEAK_TO_MEAN MIN_COMPACT_AREA MAX_GRAZING_HEIGHT_RATIO OUTLINE_MARGIN MISS_DISTANCE SEGMENT_END_FRACTION RAY_REACH
    DEPTH_SCALE MAX_DEPTH GUTTER_PIXELS PAPER_NEAR_PLANE PAPER_FAR_PLANE
};
