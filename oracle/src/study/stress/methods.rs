//! The ways to solve that are put to the test: what `solve` does by itself, the paper's, and one
//! for each choice in between.

use super::trial::Suite;
use crate::solve::dense;
use common::form_factor::FormFactor;
use common::relight::{Mended, Method as Relighting};
use common::settings::{Iteration, Projection, Quality, Raster, Settings, Visibility};

/// The method whose answer a user gets who asks for nothing.
pub const DEFAULT: &str = "default";

/// Pixels a side of all item buffers, the default's too: their twin is a plain loop, and so is a
/// software GPU.
pub const PIXELS: u32 = 512;

const STEREOGRAPHIC: Projection = Projection::Stereographic(Raster::Pixel);

/// One way.
#[derive(Clone, Copy)]
pub struct Method {
    /// Its name.
    pub name: &'static str,
    /// How.
    pub way: Way,
}

/// How a method solves.
#[derive(Clone, Copy)]
pub enum Way {
    /// As `solve` with no options.
    Default,
    /// As `solve --quality reference`.
    Reference,
    /// Shooting, by its default options but for these.
    Given(fn(&mut Settings)),
    /// The dense system.
    Matrix,
    /// An object put into a room by `relight`, with these options; no method: everything again.
    Relight(Option<Relighting>, fn(&mut Settings)),
}

/// The ways to solve.
const SOLVES: &[Method] = &[
    given(DEFAULT, Way::Default),
    given(
        "fine",
        Way::Given(|s| (s.meshing.cells, s.meshing.samples) = (8, 16)),
    ),
    given("polygon", Way::Given(whole)),
    given(
        "disc",
        Way::Given(|s| {
            whole(s);
            s.transport.form_factor = FormFactor::Disc;
        }),
    ),
    given("stereographic", Way::Given(|s| drawn(s, STEREOGRAPHIC))),
    given("hemicube", Way::Given(|s| drawn(s, Projection::Hemicube))),
    given(
        "hemisphere",
        Way::Given(|s| drawn(s, Projection::Hemisphere(Raster::Pixel))),
    ),
    given(
        "paper",
        Way::Given(|s| {
            drawn(s, Projection::Paper);
            s.transport.form_factor = FormFactor::Disc;
        }),
    ),
    given("matrix", Way::Matrix),
];

/// Those that only some cases ask for.
const OTHERS: &[Method] = &[
    given("reference", Way::Reference),
    given(
        "conserved",
        Way::Given(|s| {
            whole(s);
            s.transport.conserve = true;
        }),
    ),
    given(
        "southwell",
        Way::Given(|s| {
            whole(s);
            s.schedule.iteration = Iteration::Southwell;
        }),
    ),
];

/// The ways to relight.
const RELIGHTS: &[Method] = &[
    given(DEFAULT, Way::Relight(Some(Relighting::Signed), |_| ())),
    given(
        "signed",
        Way::Relight(Some(Relighting::Signed), |s| {
            (s.transport.visibility, s.meshing.cells, s.meshing.samples) =
                (Visibility::Rays, 4, 16);
        }),
    ),
    given("full", Way::Relight(None, |s| s.meshing.cells = 2)),
    given(
        "paper",
        Way::Relight(Some(Relighting::Paper(AS_PRINTED)), |s| s.meshing.cells = 2),
    ),
];

const AS_PRINTED: Mended = Mended {
    empty_room: false,
    object_shadows: false,
    bleeding: false,
    shadows: false,
};

const fn given(name: &'static str, way: Way) -> Method {
    Method { name, way }
}

/// Whole faces shoot, centre to centre.
fn whole(settings: &mut Settings) {
    (settings.meshing.cells, settings.meshing.samples) = (1, 1);
}

fn drawn(settings: &mut Settings, projection: Projection) {
    whole(settings);
    settings.transport.visibility = Visibility::drawn(projection, PIXELS);
}

/// Those that try.
pub fn of(suite: Suite) -> Vec<Method> {
    match suite {
        Suite::All => SOLVES.to_vec(),
        Suite::Relight(_) => RELIGHTS.to_vec(),
        Suite::Only(names) => {
            let all = SOLVES.iter().chain(OTHERS);
            all.filter(|m| names.contains(&m.name)).copied().collect()
        }
    }
}

impl Method {
    /// Whether there is a GPU's side to it.
    pub fn on_gpu(&self) -> bool {
        !matches!(self.way, Way::Matrix)
    }

    /// Its options on N×N texels.
    pub fn settings(&self, texels: u32, on_gpu: bool) -> Settings {
        let mut settings = default(texels, on_gpu);
        match self.way {
            Way::Default | Way::Reference => {}
            Way::Matrix => settings = dense::settings(texels),
            Way::Given(change) => {
                settings.transport.visibility = Visibility::Rays;
                change(&mut settings);
            }
            Way::Relight(_, change) => change(&mut settings),
        }
        settings
    }
}

/// What `solve --texels N --iteration cg --item-buffer 512` does.
fn default(texels: u32, on_gpu: bool) -> Settings {
    let mut settings = Settings::of(Quality::Normal);
    settings.meshing.texels = texels;
    settings.schedule.iteration = Iteration::Cg;
    if on_gpu {
        settings.transport.visibility = Visibility::drawn(STEREOGRAPHIC, PIXELS);
    }
    settings
}
