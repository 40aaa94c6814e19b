//! The WGSL that is compiled: constants from Rust, then the files of `shaders/`.

use crate::dispatches::{Counted, DISPATCH_WORDS};
use common::constants::*;
use common::escape::DIRECTIONS;
use common::form_factor::FormFactor;
use common::sampling::{INSIDE, STEPS};
use common::settings::{Lookup, Settings, Visibility};
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

const FILES: [(&str, &str); 24] = [
    ("types", include_str!("shaders/types.wgsl")),
    ("form_factor", include_str!("shaders/form_factor.wgsl")),
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
];

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
pub fn source(name: &str, settings: &Settings, faults: &[Fault]) -> Result<String> {
    let includes: &[&str] = match name {
        "link" if settings.visibility == Visibility::Rays => {
            &["sampling", "form_factor", "intersect", "tree", "rays"]
        }
        "link" => &[
            "sampling",
            "form_factor",
            "hemicube",
            "projection",
            "intersect",
            "lookup",
        ],
        "escape" => &["hemicube", "projection", "intersect", "tree"],
        "tessellate" | "item_buffer_tessellated" => &["hemicube", "projection", "bound"],
        "item_buffer" => &["hemicube", "projection", "bound", "intersect"],
        _ => &[],
    };
    let mut text = constants(settings);
    for part in ["types"].iter().chain(includes).chain([&name]) {
        text.push_str(&file(part, faults)?);
    }
    Ok(text)
}

fn constants(settings: &Settings) -> String {
    let projection = match settings.visibility {
        Visibility::Paper => 0,
        Visibility::Hemisphere => 1,
        Visibility::Stereographic | Visibility::Rays => 2,
        Visibility::Hemicube => 3,
    };
    let form_factor = match settings.form_factor {
        FormFactor::Paper => 0,
        FormFactor::Disc => 1,
        FormFactor::Polygon => 2,
    };
    let reach = match settings.lookup {
        Lookup::Exact => 0,
        Lookup::Neighbours => 1,
    };
    let mut text = String::new();
    let integers = [
        ("LANES", LANES as u32),
        ("NEAR", NEAR),
        ("SELECT_LANES", SELECT_LANES as u32),
        ("LEVELS", LEVELS),
        ("HIDDEN", HIDDEN),
        ("DIRECTIONS", DIRECTIONS as u32),
        ("SIZE", settings.item_buffer),
        ("PROJECTION", projection),
        ("PROJECTION_PAPER", 0),
        ("PROJECTION_HEMISPHERE", 1),
        ("PROJECTION_STEREOGRAPHIC", 2),
        ("PROJECTION_HEMICUBE", 3),
        ("SIDES", settings.visibility.sides()),
        ("FORM_FACTOR", form_factor),
        ("FORM_FACTOR_PAPER", 0),
        ("FORM_FACTOR_DISC", 1),
        ("STEP_U", STEPS[0]),
        ("STEP_V", STEPS[1]),
        ("RAY_STACK", RAY_STACK),
        ("ROUNDS", ROUNDS),
        ("DISPATCH_WORDS", DISPATCH_WORDS),
        ("COUNTED_DEPOSIT", Counted::Deposit as u32),
        ("COUNTED_ESCAPE", Counted::Escape as u32),
        ("COUNTED_POWER", Counted::Power as u32),
        ("COUNTED_LINKS", Counted::Links as u32),
        ("COUNTED_RECEIVED", Counted::Received as u32),
    ];
    for (name, value) in integers {
        text.push_str(&format!("const {name}: u32 = {value}u;\n"));
    }
    text.push_str(&format!("const REACH: i32 = {reach};\n"));
    let reals = [
        ("PI", PI),
        ("CONTACT", CONTACT),
        ("FAR", FAR),
        ("NEAR_QUAD", NEAR_QUAD),
        ("NEAR_TRIANGLE", NEAR_TRIANGLE),
        ("POINT", POINT),
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
    for (name, value) in reals {
        text.push_str(&format!("const {name}: f32 = {value:?}f;\n"));
    }
    text
}
