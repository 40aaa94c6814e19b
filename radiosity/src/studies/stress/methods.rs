//! The methods under test: the default of `solve`, the paper's method, and one method per choice
//! between them.

use common::form_factor::FormFactor;
use common::relight::{MendedFlaws, RelightMethod};
use common::settings::{ItemBufferProjection, Iteration, Settings, SolveQuality, Visibility};
use oracle::solve::dense;
use oracle::solve::solver::DEFAULT_ERROR;

/// Pixels per side of all item buffers, few because the CPU rasteriser and software GPUs are slow.
pub const ITEM_BUFFER_PIXELS: u32 = 512;

/// A method of the atlas.
#[derive(Clone, Copy)]
pub struct AtlasMethod {
    /// Name of the method.
    pub name: &'static str,
    /// Solver that it runs.
    pub solver: MethodSolver,
    /// Method of the relight cases; without one they solve the whole scene.
    pub relighting: Option<RelightMethod>,
    /// Change to the settings of `solve`, not of the dense solver.
    pub change: fn(&mut Settings),
}

/// Solver of a method.
#[derive(Clone, Copy, PartialEq)]
pub enum MethodSolver {
    /// `solve --error`, to this share.
    ToError(f64),
    /// Progressive refinement.
    Shooting,
    /// Dense linear system.
    Dense,
}

/// `solve`, or `relight`, without options.
pub const DEFAULT: AtlasMethod = AtlasMethod {
    name: "default",
    solver: MethodSolver::ToError(DEFAULT_ERROR),
    relighting: Some(RelightMethod::Signed),
    change: |_| (),
};
/// Dense linear system.
pub const DENSE: AtlasMethod = AtlasMethod {
    name: "dense",
    solver: MethodSolver::Dense,
    ..DEFAULT
};
/// Many patches and samples.
pub const FINE: AtlasMethod = shooting("fine", |s| {
    s.transport.visibility = Visibility::Rays;
    (s.meshing.patches, s.meshing.samples) = (8, 16);
});
/// One ray from centre to centre of whole faces.
pub const POLYGON: AtlasMethod = shooting("polygon", set_whole_faces);
/// `polygon` with the disc's form factor.
pub const DISC: AtlasMethod = shooting("disc", |s| {
    set_whole_faces(s);
    s.transport.form_factor = FormFactor::Disc;
});
/// Stereographic item buffer.
pub const STEREOGRAPHIC: AtlasMethod = shooting("stereographic", |s| {
    set_item_buffer(s, ItemBufferProjection::Stereographic)
});
/// Hemicube.
pub const HEMICUBE: AtlasMethod = shooting("hemicube", |s| set_item_buffer(s, ItemBufferProjection::Hemicube));
/// Orthographic item buffer.
pub const HEMISPHERE: AtlasMethod = shooting("hemisphere", |s| set_item_buffer(s, ItemBufferProjection::Hemisphere));
const PAPER: AtlasMethod = shooting("paper", |s| {
    set_item_buffer(s, ItemBufferProjection::Paper);
    s.transport.form_factor = FormFactor::Disc;
});
/// `polygon` whose shots conserve power.
pub const CONSERVED: AtlasMethod = shooting("conserved", |s| {
    set_whole_faces(s);
    s.transport.conserve = true;
});
/// `polygon` by Southwell's iteration.
pub const SOUTHWELL: AtlasMethod = shooting("southwell", |s| {
    set_whole_faces(s);
    s.schedule.iteration = Iteration::Southwell;
});

/// Methods of a case that is solved.
pub const SOLVE_METHODS: &[AtlasMethod] = &[
    DEFAULT,
    FINE,
    POLYGON,
    DISC,
    STEREOGRAPHIC,
    HEMICUBE,
    HEMISPHERE,
    PAPER,
    DENSE,
];

/// Methods of a case that is relit.
pub const RELIGHT_METHODS: &[AtlasMethod] = &[
    DEFAULT,
    AtlasMethod {
        relighting: Some(RelightMethod::Signed),
        ..shooting("signed", |s| {
            (s.transport.visibility, s.meshing.patches, s.meshing.samples) = (Visibility::Rays, 4, 16);
        })
    },
    shooting("full", |s| s.meshing.patches = 2),
    AtlasMethod {
        relighting: Some(RelightMethod::Paper(AS_PRINTED)),
        ..shooting("paper", |s| s.meshing.patches = 2)
    },
];

const AS_PRINTED: MendedFlaws = MendedFlaws {
    empty_room: false,
    object_shadows: false,
    bleeding: false,
    shadows: false,
};

/// Makes a method of progressive refinement, of the whole scene.
const fn shooting(name: &'static str, change: fn(&mut Settings)) -> AtlasMethod {
    AtlasMethod {
        name,
        solver: MethodSolver::Shooting,
        relighting: None,
        change,
    }
}

/// Sets whole faces as patches and one ray per link, centre to centre.
fn set_whole_faces(settings: &mut Settings) {
    settings.transport.visibility = Visibility::Rays;
    (settings.meshing.patches, settings.meshing.samples) = (1, 1);
}

fn set_item_buffer(settings: &mut Settings, projection: ItemBufferProjection) {
    set_whole_faces(settings);
    settings.transport.visibility = Visibility::with_item_buffer(projection, ITEM_BUFFER_PIXELS);
}

impl AtlasMethod {
    /// Returns its settings on N×N texels: `solve --texels N --iteration cg --item-buffer 512` with its change.
    pub fn settings_on(&self, texels: u32, on_gpu: bool) -> Settings {
        if self.solver == MethodSolver::Dense {
            return dense::dense_settings(texels);
        }
        let mut settings = Settings::with_quality(SolveQuality::Normal);
        settings.meshing.texels = texels;
        settings.schedule.iteration = Iteration::Cg;
        if on_gpu {
            settings.transport.visibility =
                Visibility::with_item_buffer(ItemBufferProjection::Stereographic, ITEM_BUFFER_PIXELS);
        }
        (self.change)(&mut settings);
        settings
    }
}
