//! The methods under test: the default of `solve`, the paper's method, and one method per choice
//! between them.

use super::trial::MethodSuite;
use crate::studies::{PIXEL_HEMISPHERE, PIXEL_STEREOGRAPHIC};
use common::form_factor::FormFactor;
use common::relight::{MendedFlaws, RelightMethod as Relighting};
use common::settings::{ItemBufferProjection, Iteration, Settings, SolveQuality, Visibility};
use oracle::solve::dense;

/// Name of the method that `solve` runs without options.
pub const DEFAULT_METHOD: &str = "default";

/// Pixels per side of all item buffers, few because the CPU rasteriser and software GPUs are slow.
pub const ITEM_BUFFER_PIXELS: u32 = 512;

/// A method of the atlas.
#[derive(Clone, Copy)]
pub struct AtlasMethod {
    /// Name of the method.
    pub name: &'static str,
    /// Way of solving.
    pub kind: MethodKind,
}

/// Way of solving of a method.
#[derive(Clone, Copy)]
pub enum MethodKind {
    /// `solve` without options.
    Default,
    /// `solve --quality reference`.
    Reference,
    /// Progressive refinement with this change to its default options.
    Shooting(fn(&mut Settings)),
    /// Dense linear system.
    Matrix,
    /// `relight` of an object in a room with this change of options; without a method the whole scene is
    /// solved.
    Relight(Option<Relighting>, fn(&mut Settings)),
}

/// Methods of the solve cases.
const SOLVE_METHODS: &[AtlasMethod] = &[
    method_of(DEFAULT_METHOD, MethodKind::Default),
    method_of(
        "fine",
        MethodKind::Shooting(|s| (s.meshing.patches, s.meshing.samples) = (8, 16)),
    ),
    method_of("polygon", MethodKind::Shooting(set_whole_faces)),
    method_of(
        "disc",
        MethodKind::Shooting(|s| {
            set_whole_faces(s);
            s.transport.form_factor = FormFactor::Disc;
        }),
    ),
    method_of(
        "stereographic",
        MethodKind::Shooting(|s| set_item_buffer(s, PIXEL_STEREOGRAPHIC)),
    ),
    method_of(
        "hemicube",
        MethodKind::Shooting(|s| set_item_buffer(s, ItemBufferProjection::Hemicube)),
    ),
    method_of(
        "hemisphere",
        MethodKind::Shooting(|s| set_item_buffer(s, PIXEL_HEMISPHERE)),
    ),
    method_of(
        "paper",
        MethodKind::Shooting(|s| {
            set_item_buffer(s, ItemBufferProjection::Paper);
            s.transport.form_factor = FormFactor::Disc;
        }),
    ),
    method_of("matrix", MethodKind::Matrix),
];

/// Methods that only some cases use.
const OPTIONAL_METHODS: &[AtlasMethod] = &[
    method_of("reference", MethodKind::Reference),
    method_of(
        "conserved",
        MethodKind::Shooting(|s| {
            set_whole_faces(s);
            s.transport.conserve = true;
        }),
    ),
    method_of(
        "southwell",
        MethodKind::Shooting(|s| {
            set_whole_faces(s);
            s.schedule.iteration = Iteration::Southwell;
        }),
    ),
];

/// Methods of the relight cases.
const RELIGHT_METHODS: &[AtlasMethod] = &[
    method_of(DEFAULT_METHOD, MethodKind::Relight(Some(Relighting::Signed), |_| ())),
    method_of(
        "signed",
        MethodKind::Relight(Some(Relighting::Signed), |s| {
            (s.transport.visibility, s.meshing.patches, s.meshing.samples) = (Visibility::Rays, 4, 16);
        }),
    ),
    method_of("full", MethodKind::Relight(None, |s| s.meshing.patches = 2)),
    method_of(
        "paper",
        MethodKind::Relight(Some(Relighting::Paper(AS_PRINTED)), |s| s.meshing.patches = 2),
    ),
];

const AS_PRINTED: MendedFlaws = MendedFlaws {
    empty_room: false,
    object_shadows: false,
    bleeding: false,
    shadows: false,
};

const fn method_of(name: &'static str, way: MethodKind) -> AtlasMethod {
    AtlasMethod { name, kind: way }
}

/// Sets whole faces as patches and one sample per link, centre to centre.
fn set_whole_faces(settings: &mut Settings) {
    (settings.meshing.patches, settings.meshing.samples) = (1, 1);
}

fn set_item_buffer(settings: &mut Settings, projection: ItemBufferProjection) {
    set_whole_faces(settings);
    settings.transport.visibility = Visibility::with_item_buffer(projection, ITEM_BUFFER_PIXELS);
}

/// Returns the methods of a suite.
pub fn methods_of(suite: MethodSuite) -> Vec<AtlasMethod> {
    match suite {
        MethodSuite::All => SOLVE_METHODS.to_vec(),
        MethodSuite::Relight(_) => RELIGHT_METHODS.to_vec(),
        MethodSuite::Only(names) => {
            let all = SOLVE_METHODS.iter().chain(OPTIONAL_METHODS);
            all.filter(|m| names.contains(&m.name)).copied().collect()
        }
    }
}

impl AtlasMethod {
    /// Returns whether the method also runs on the GPU.
    pub fn runs_on_gpu(&self) -> bool {
        !matches!(self.kind, MethodKind::Matrix)
    }

    /// Returns its settings on N×N texels.
    pub fn settings_on(&self, texels: u32, on_gpu: bool) -> Settings {
        let mut settings = default_settings(texels, on_gpu);
        match self.kind {
            MethodKind::Default | MethodKind::Reference => {}
            MethodKind::Matrix => settings = dense::dense_settings(texels),
            MethodKind::Shooting(change) => {
                settings.transport.visibility = Visibility::Rays;
                change(&mut settings);
            }
            MethodKind::Relight(_, change) => change(&mut settings),
        }
        settings
    }
}

/// Returns the settings of `solve --texels N --iteration cg --item-buffer 512`.
fn default_settings(texels: u32, on_gpu: bool) -> Settings {
    let mut settings = Settings::with_quality(SolveQuality::Normal);
    settings.meshing.texels = texels;
    settings.schedule.iteration = Iteration::Cg;
    if on_gpu {
        settings.transport.visibility = Visibility::with_item_buffer(PIXEL_STEREOGRAPHIC, ITEM_BUFFER_PIXELS);
    }
    settings
}
