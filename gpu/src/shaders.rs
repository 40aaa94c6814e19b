//! The WGSL that is compiled: constants from Rust, then the files of `shaders/`.

use crate::dispatches::{Counted, DISPATCH_WORDS};
use crate::grids::{DRAW_INSTANCES, DRAW_WORDS};
pub use crate::linked::LAYOUTS as HIERARCHY_LAYOUTS;
use crate::linked::{SPOTS, State};
use crate::records::{CAPTURED, KEEP, SUBTRACTED};
pub use crate::records::{LAYOUTS, LOG_COUNT_BYTES, Layout};
use common::constants::*;
use common::escape::DIRECTIONS;
use common::form_factor::FormFactor;
use common::mesh::{Cover, TexelKind};
use common::rays::Sight;
use common::sampling::{INSIDE, STEPS};
use common::settings::{Drawing, Projection, Raster, Transport};
use common::shooting::Subtracted;
use common::{Error, Result};

/// Rounds of the loop in `measure.wgsl`, 32 operations each.
pub const ROUNDS: u32 = 256;

/// A planted fault: in shader file `file`, the one place that reads `from` reads `to` instead.
/// The harness uses it to prove that it can fail.
#[derive(Clone, Copy, Debug)]
pub struct Fault {
    /// File name in `shaders/`, without ending.
    pub file: &'static str,
    /// Text that occurs exactly once.
    pub from: &'static str,
    /// What replaces it.
    pub to: &'static str,
}

const FILES: [(&str, &str); 39] = [
    ("types", include_str!("shaders/types.wgsl")),
    ("form_factor", include_str!("shaders/form_factor.wgsl")),
    ("frame", include_str!("shaders/frame.wgsl")),
    ("hemicube", include_str!("shaders/hemicube.wgsl")),
    ("projection", include_str!("shaders/projection.wgsl")),
    ("bound", include_str!("shaders/bound.wgsl")),
    ("intersect", include_str!("shaders/intersect.wgsl")),
    ("tessellate", include_str!("shaders/tessellate.wgsl")),
    ("item_buffer", include_str!("shaders/item_buffer.wgsl")),
    (
        "item_buffer_tessellated",
        include_str!("shaders/item_buffer_tessellated.wgsl"),
    ),
    ("lookup", include_str!("shaders/lookup.wgsl")),
    ("sampling", include_str!("shaders/sampling.wgsl")),
    ("texel_point", include_str!("shaders/texel_point.wgsl")),
    ("spread", include_str!("shaders/spread.wgsl")),
    ("tree", include_str!("shaders/tree.wgsl")),
    ("rays", include_str!("shaders/rays.wgsl")),
    ("aim", include_str!("shaders/aim.wgsl")),
    ("link", include_str!("shaders/link.wgsl")),
    ("received", include_str!("shaders/received.wgsl")),
    ("closure", include_str!("shaders/closure.wgsl")),
    ("deposit", include_str!("shaders/deposit.wgsl")),
    ("escape", include_str!("shaders/escape.wgsl")),
    ("power", include_str!("shaders/power.wgsl")),
    ("select", include_str!("shaders/select.wgsl")),
    ("exchange", include_str!("shaders/exchange.wgsl")),
    ("collect", include_str!("shaders/collect.wgsl")),
    ("measure", include_str!("shaders/measure.wgsl")),
    ("hierarchy", include_str!("shaders/hierarchy.wgsl")),
    ("spots", include_str!("shaders/spots.wgsl")),
    ("bounds", include_str!("shaders/bounds.wgsl")),
    ("factors", include_str!("shaders/factors.wgsl")),
    ("reset", include_str!("shaders/reset.wgsl")),
    ("doubt", include_str!("shaders/doubt.wgsl")),
    ("choose", include_str!("shaders/choose.wgsl")),
    ("sampled", include_str!("shaders/sampled.wgsl")),
    ("scan", include_str!("shaders/scan.wgsl")),
    ("parts", include_str!("shaders/parts.wgsl")),
    ("add", include_str!("shaders/add.wgsl")),
    ("pack", include_str!("shaders/pack.wgsl")),
];

/// What draws item buffers.
const DRAWS: [&str; 3] = ["tessellate", "item_buffer", "item_buffer_tessellated"];

fn file(name: &str, faults: &[Fault]) -> Result<String> {
    let (_, text) = FILES
        .iter()
        .find(|(file, _)| *file == name)
        .ok_or_else(|| Error::Usage(format!("no shader is called {name}")))?;
    let mut text = (*text).to_owned();
    for fault in faults.iter().filter(|fault| fault.file == name) {
        if text.matches(fault.from).count() != 1 {
            return Err(Error::Usage(format!(
                "{name}: {:?} does not occur once",
                fault.from
            )));
        }
        text = text.replace(fault.from, fault.to);
    }
    Ok(text)
}

/// The module of `name` with what it includes.
///
/// Errors: [`Error::Usage`] of what draws where rays are asked, of a shader or a fault that is none.
pub fn source(name: &str, transport: &Transport, faults: &[Fault]) -> Result<String> {
    let drawing = transport.visibility.drawing();
    if drawing.is_none() && DRAWS.contains(&name) {
        return Err(Error::Usage(format!("{name} draws, and rays are asked")));
    }
    let includes: &[&str] = match name {
        "link" if drawing.is_none() => &[
            "sampling",
            "texel_point",
            "form_factor",
            "intersect",
            "tree",
            "rays",
        ],
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
        "escape" => &["frame", "intersect", "tree"],
        "tessellate" => &["frame", "hemicube", "projection", "bound"],
        "item_buffer_tessellated" => &["frame", "hemicube", "projection", "spread"],
        "item_buffer" => &["frame", "hemicube", "projection", "bound", "intersect"],
        "factors" => &["hierarchy", "sampling", "spots", "form_factor"],
        "sampled" => &[
            "hierarchy",
            "sampling",
            "spots",
            "form_factor",
            "intersect",
            "tree",
            "rays",
        ],
        "choose" => &["hierarchy", "doubt"],
        "bounds" | "scan" | "parts" | "add" | "pack" => &["hierarchy"],
        _ => &[],
    };
    let mut text = constants(transport);
    for part in ["types"].iter().chain(includes).chain([&name]) {
        text.push_str(&file(part, faults)?);
    }
    Ok(text)
}

fn constants(transport: &Transport) -> String {
    let mut text = String::new();
    let drawing = transport.visibility.drawing();
    // Where rays are asked there is no image: it has no planes, and no other constant.
    let sides = drawing.map_or(0, |drawing| drawing.projection.sides());
    let chosen = [
        ("SIDES", sides),
        ("FORM_FACTOR", transport.form_factor as u32),
    ];
    let image = drawing.iter().flat_map(image);
    for (name, value) in INTEGERS.into_iter().chain(CODES).chain(chosen).chain(image) {
        text.push_str(&format!("const {name}: u32 = {value}u;\n"));
    }
    if let Some(drawing) = drawing {
        let reach = drawing.lookup.reach();
        text.push_str(&format!("const REACH: i32 = {reach};\n"));
    }
    for (name, value) in REALS {
        text.push_str(&format!("const {name}: f32 = {value:?}f;\n"));
    }
    text
}

/// Whole numbers of what is drawn.
fn image(drawing: &Drawing) -> [(&'static str, u32); 2] {
    [
        ("SIZE", drawing.size),
        ("PROJECTION", drawing.projection.code()),
    ]
}

/// Whole numbers that are the same in every solve.
pub const INTEGERS: [(&str, u32); 20] = [
    ("LANES", LANES as u32),
    ("NEAR", NEAR),
    ("SELECT_LANES", SELECT_LANES as u32),
    ("LEVELS", LEVELS),
    ("HIDDEN", HIDDEN),
    ("DIRECTIONS", DIRECTIONS as u32),
    ("STEP_U", STEPS[0]),
    ("STEP_V", STEPS[1]),
    ("STEP_CELL_U", STEPS[2]),
    ("STEP_CELL_V", STEPS[3]),
    ("SPOTS", SPOTS),
    ("SAMPLES_FIRST", SAMPLES[0]),
    ("SAMPLES_MORE", SAMPLES[1]),
    ("SAMPLES_CUT", SAMPLES[2]),
    ("SAMPLES_MOST", SAMPLES[3]),
    ("RAY_STACK", RAY_STACK),
    ("ROUNDS", ROUNDS),
    ("DISPATCH_WORDS", DISPATCH_WORDS),
    ("DRAW_WORDS", DRAW_WORDS),
    ("DRAW_INSTANCES", DRAW_INSTANCES),
];

/// Enums as numbers: by their order in Rust, projections by their code.
pub const CODES: [(&str, u32); 29] = [
    ("PROJECTION_PAPER", Projection::Paper.code()),
    (
        "PROJECTION_HEMISPHERE",
        Projection::Hemisphere(Raster::Pixel).code(),
    ),
    (
        "PROJECTION_STEREOGRAPHIC",
        Projection::Stereographic(Raster::Pixel).code(),
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
    ("SUBTRACTED", SUBTRACTED),
    ("SUBTRACTED_BEFORE", Subtracted::Before as u32),
    ("SUBTRACTED_UNHIDDEN", Subtracted::Unhidden as u32),
    ("SUBTRACTED_ALL", Subtracted::All as u32),
    ("CAPTURED", CAPTURED),
    ("KEEP", KEEP),
    ("PAIR_NOTHING", State::Nothing as u32),
    ("PAIR_CUT", State::Cut as u32),
    ("PAIR_ASKED", State::Asked as u32),
    ("PAIR_LINK", State::Link as u32),
    ("PAIR_EDGE", State::Edge as u32),
    ("COUNTED_DEPOSIT", Counted::Deposit as u32),
    ("COUNTED_ESCAPE", Counted::Escape as u32),
    ("COUNTED_POWER", Counted::Power as u32),
    ("COUNTED_LINKS", Counted::Links as u32),
    ("COUNTED_RECEIVED", Counted::Received as u32),
];

/// Reals.
const REALS: [(&str, f32); 21] = [
    ("PI", PI),
    ("CONTACT", CONTACT),
    ("FAR", FAR),
    ("NEAR_QUAD", NEAR_QUAD),
    ("NEAR_TRIANGLE", NEAR_TRIANGLE),
    ("POINT", POINT),
    ("LITTLE", LITTLE),
    ("EDGE", EDGE),
    ("LOW", LOW),
    ("OUTLINE", OUTLINE),
    ("INSIDE_U", INSIDE[0]),
    ("INSIDE_V", INSIDE[1]),
    ("MISS", MISS),
    ("END", END),
    ("RAY_REACH", RAY_REACH),
    ("DEPTH_SCALE", DEPTH_SCALE),
    ("DEPTH_MAX", DEPTH_MAX),
    ("BELOW", BELOW),
    ("GUTTER", GUTTER),
    ("PAPER_NEAR", PAPER_NEAR),
    ("PAPER_FAR", PAPER_FAR),
];
