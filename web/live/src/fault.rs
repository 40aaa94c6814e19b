//! Faults to plant in a shader of the page, each of which its stage shows.

use serde::Serialize;

/// A fault, and what it does.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LiveFault {
    /// What it does.
    pub description: &'static str,
    /// File name in `gpu/src/shaders`, without ending.
    pub file: &'static str,
    /// Text of the file.
    pub from: &'static str,
    /// What takes its place.
    pub to: &'static str,
    /// The stage that differs from its twin.
    pub stage: &'static str,
    /// The visibility that runs the file, rays or an item buffer; none: both do.
    pub visibility: Option<&'static str>,
}

/// The faults, in the order of a shot's stages.
pub const LIVE_FAULTS: [LiveFault; 8] = [
    LiveFault {
        description: "the neighbour of the strongest patch shoots",
        file: "select",
        from: "var patch_index = lane_patch[0];",
        to: "var patch_index = min(lane_patch[0] + 1u, params.patches - 1u);",
        stage: "select",
        visibility: None,
    },
    LiveFault {
        description: "the farthest face is drawn",
        file: "item_buffer",
        from: "min(hit.t * DEPTH_SCALE, MAX_DEPTH)",
        to: "1.0 - min(hit.t * DEPTH_SCALE, MAX_DEPTH)",
        stage: "item buffer",
        visibility: Some("stereographic"),
    },
    LiveFault {
        description: "form factors of near patches are doubled",
        file: "form_factor",
        from: "-sum / (2.0 * PI)",
        to: "-sum / PI",
        stage: "form factor",
        visibility: None,
    },
    LiveFault {
        description: "nothing blocks a ray",
        file: "rays",
        from: "return SIGHT_BLOCKED;",
        to: "return SIGHT_CLEAR;",
        stage: "rays",
        visibility: Some("rays"),
    },
    LiveFault {
        description: "all that is looked up is visible",
        file: "lookup",
        from: "return found;",
        to: "return true;",
        stage: "lookup",
        visibility: Some("stereographic"),
    },
    LiveFault {
        description: "half of what is visible is lost",
        file: "link",
        from: "next.seen += g;",
        to: "next.seen += 0.5 * g;",
        stage: "link",
        visibility: None,
    },
    LiveFault {
        description: "a tenth of the reflected light is lost",
        file: "deposit",
        from: "texels[k].reflectance * received",
        to: "0.9 * texels[k].reflectance * received",
        stage: "deposit",
        visibility: None,
    },
    LiveFault {
        description: "the shooter keeps half of its light",
        file: "deposit",
        from: "residual[k] = vec4f(0.0);",
        to: "residual[k] *= 0.5;",
        stage: "deposit",
        visibility: None,
    },
];
