//! The ways to solve: a base per solver, one parameter at a time, and a few combinations.

use super::Solver;
use crate::plan::Counts;
use crate::solve::dense;
use common::form_factor::FormFactor;
use common::scene::Scene;
use common::settings::{
    Drawing, Iteration, Lookup, Meshing, Projection, Quality, Raster, Settings, Visibility,
};
use cpu::matrix::memory::{MEMORY, bytes};
use serde_json::Value;

/// Samples of the base: cells are halved until it has no more, so that it takes seconds.
const SAMPLES: u64 = 1 << 24;
/// Texels of a truth of our own: about a minute of the matrix; twice as many take several.
const TRUTH: u64 = 6000;
/// The twin of an item buffer is a plain loop: with more pixels it only gets slower.
const TWIN_PIXELS: u32 = 256;
const PIXELS: u32 = Drawing::DEFAULT.size;
const STEREOGRAPHIC: Projection = Projection::Stereographic(Raster::Pixel);
const HEMISPHERE: Projection = Projection::Hemisphere(Raster::Pixel);

/// One way to solve.
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    /// Who.
    pub solver: Solver,
    /// What is varied: an option's name, or "base" or "combination".
    pub sweep: &'static str,
    /// How it differs from the base, as the command line has it.
    pub options: String,
    /// How it shoots.
    pub settings: Settings,
    /// The error that is asked for; none: it shoots.
    pub asked: Option<f64>,
}

/// Errors that are asked for, and whether the short table has them too.
const ERRORS: [(f64, bool); 7] = [
    (0.1, false),
    (0.05, true),
    (0.02, false),
    (0.01, true),
    (0.005, false),
    (0.003, true),
    (0.002, false),
];

/// Who a row of the table is for.
#[derive(Clone, Copy, PartialEq)]
enum For {
    Both,
    Cpu,
    Gpu,
}

/// Solvers, sweep, whether the short table has it too, and the change to the base.
type Row = (For, &'static str, bool, fn(&mut Settings));

/// The table.
const ROWS: &[Row] = &[
    (For::Both, "base", true, |_| ()),
    (For::Both, "texels", true, |s| s.meshing.texels /= 2),
    (For::Both, "texels", false, |s| s.meshing.texels *= 2),
    (For::Both, "cells", false, |s| s.meshing.cells /= 4),
    (For::Both, "cells", true, |s| s.meshing.cells /= 2),
    (For::Both, "cells", true, |s| s.meshing.cells *= 2),
    (For::Both, "samples", true, |s| s.meshing.samples = 1),
    (For::Cpu, "samples", false, |s| s.meshing.samples = 2),
    (For::Both, "samples", true, |s| s.meshing.samples *= 4),
    (For::Both, "form-factor", true, |s| {
        s.transport.form_factor = FormFactor::Disc;
    }),
    (For::Both, "form-factor", false, |s| {
        s.transport.form_factor = FormFactor::Paper;
    }),
    (For::Both, "iteration", true, |s| {
        s.schedule.iteration = Iteration::Southwell;
    }),
    (For::Both, "iteration", false, |s| {
        s.schedule.iteration = Iteration::Chebyshev;
    }),
    (For::Cpu, "epsilon", false, |s| s.schedule.epsilon = 0.1),
    (For::Both, "epsilon", true, |s| s.schedule.epsilon = 0.01),
    (For::Both, "epsilon", false, |s| s.schedule.epsilon = 1e-4),
    (For::Cpu, "visibility", true, |s| {
        drawn(s, STEREOGRAPHIC, TWIN_PIXELS);
    }),
    (For::Cpu, "visibility", false, |s| {
        drawn(s, HEMISPHERE, TWIN_PIXELS);
    }),
    (For::Cpu, "visibility", false, |s| {
        drawn(s, Projection::Hemicube, TWIN_PIXELS);
    }),
    (For::Cpu, "visibility", false, |s| {
        drawn(s, Projection::Paper, TWIN_PIXELS);
    }),
    (For::Gpu, "visibility", true, |s| {
        s.transport.visibility = Visibility::Rays;
    }),
    (For::Gpu, "visibility", false, |s| {
        drawn(s, HEMISPHERE, PIXELS);
    }),
    (For::Gpu, "visibility", false, |s| {
        drawn(s, Projection::Hemicube, PIXELS);
    }),
    (For::Gpu, "visibility", true, |s| {
        drawn(s, Projection::Paper, PIXELS);
    }),
    (For::Gpu, "item-buffer", true, |s| {
        drawn(s, STEREOGRAPHIC, 256);
    }),
    (For::Gpu, "item-buffer", false, |s| {
        drawn(s, STEREOGRAPHIC, 512);
    }),
    (For::Gpu, "item-buffer", false, |s| {
        drawn(s, STEREOGRAPHIC, 2048);
    }),
    (For::Gpu, "lookup", false, |s| {
        s.transport.visibility = Visibility::Drawn(Drawing {
            lookup: Lookup::Exact,
            ..Drawing::DEFAULT
        });
    }),
    (For::Both, "combination", true, draft),
    (For::Both, "combination", false, |s| {
        let texels = s.meshing.texels;
        draft(s);
        s.meshing.texels = texels;
    }),
    (For::Both, "combination", true, paper),
    (For::Both, "combination", false, |s| {
        paper(s);
        s.transport.conserve = true;
    }),
    (For::Both, "combination", false, |s| {
        s.transport.form_factor = FormFactor::Disc;
        s.transport.conserve = true;
    }),
    (For::Both, "combination", false, |s| finest(s, 1, 1)),
    (For::Both, "combination", true, |s| finest(s, 2, 1)),
    (For::Gpu, "combination", false, |s| finest(s, 1, 4)),
    (For::Both, "combination", true, |s| finest(s, 2, 4)),
    (For::Cpu, "combination", false, |s| finest(s, 4, 1)),
    (For::Cpu, "combination", false, |s| finest(s, 4, 4)),
];

fn drawn(s: &mut Settings, projection: Projection, pixels: u32) {
    s.transport.visibility = Visibility::drawn(projection, pixels);
}

/// `--quality draft`, but no finer than the base.
fn draft(s: &mut Settings) {
    let draft = Quality::Draft.meshing();
    s.meshing = Meshing {
        texels: s.meshing.texels.min(draft.texels),
        cells: s.meshing.cells.min(draft.cells),
        ..draft
    };
    s.schedule.epsilon = Quality::Draft.epsilon();
}

/// Whole faces, discs, centres, one shot after the other.
fn paper(s: &mut Settings) {
    (s.meshing.cells, s.meshing.samples) = (1, 1);
    s.transport.form_factor = FormFactor::Disc;
    s.schedule.iteration = Iteration::Southwell;
}

/// The best visibility, more cells and samples.
fn finest(s: &mut Settings, cells: u32, samples: u32) {
    s.transport.visibility = Visibility::Rays;
    s.meshing.cells *= cells;
    s.meshing.samples *= samples;
}

/// Shooting by default, on N×N texels, with fewer cells where these would take long.
pub fn base(scene: &Scene, solver: Solver, quality: Quality, texels: u32) -> Settings {
    let mut settings = Settings::of(quality);
    settings.meshing.texels = texels;
    settings.schedule.iteration = Iteration::Cg;
    if solver == Solver::Gpu {
        settings.transport.visibility = Visibility::Drawn(Drawing::DEFAULT);
    }
    let samples = |s: &Settings| {
        Counts::new(scene, &s.meshing)
            .links()
            .saturating_mul(s.meshing.samples.into())
    };
    while settings.meshing.cells > 1 && samples(&settings) > SAMPLES {
        settings.meshing.cells /= 2;
    }
    settings
}

/// The texels a side that are asked for: `quality`'s, halved until the matrix answers soon, unless
/// that leaves too few.
pub fn texels(scene: &Scene, quality: Quality) -> u32 {
    let asked = quality.meshing().texels;
    let fits = |n: &u32| scene.faces.len() as u64 * u64::from(*n).pow(2) <= TRUTH;
    let sides = [asked, asked / 2, asked / 4];
    sides.into_iter().find(fits).unwrap_or(asked)
}

/// All methods of `solver`, each once.
pub fn methods(scene: &Scene, solver: Solver, quality: Quality, texels: u32) -> Vec<Method> {
    let base = base(scene, solver, quality, texels);
    let mut methods: Vec<Method> = Vec::new();
    let mine = match solver {
        Solver::Cpu => For::Cpu,
        Solver::Gpu => For::Gpu,
        Solver::Matrix => return matrices(scene, texels),
    };
    let rows = ROWS.iter().filter(|(who, _, short, _)| {
        (*who == For::Both || *who == mine) && (*short || quality != Quality::Draft)
    });
    for (_, sweep, _, change) in rows {
        let mut settings = base;
        change(&mut settings);
        settings.meshing.texels = settings.meshing.texels.max(1);
        settings.meshing.cells = settings.meshing.cells.clamp(1, settings.meshing.texels);
        if methods.iter().all(|m| m.settings != settings) {
            methods.push(Method {
                solver,
                sweep,
                options: options(&base, &settings),
                settings,
                asked: None,
            });
        }
    }
    let errors = ERRORS
        .iter()
        .filter(|(_, short)| *short || quality != Quality::Draft);
    methods.extend(errors.map(|(error, _)| Method {
        solver,
        sweep: "error",
        options: format!("--error {}%", 100.0 * error),
        settings: base,
        asked: Some(*error),
    }));
    methods
}

/// The matrix on as many texels as it can hold.
fn matrices(scene: &Scene, texels: u32) -> Vec<Method> {
    let fits = |n: &u32| *n > 0 && bytes(scene.faces.len() as u64 * u64::from(*n).pow(2)) <= MEMORY;
    let sides = [texels / 4, texels / 2, texels];
    let method = |texels| Method {
        solver: Solver::Matrix,
        sweep: "texels",
        options: format!("--texels {texels}"),
        settings: dense::settings(texels),
        asked: None,
    };
    sides.into_iter().filter(fits).map(method).collect()
}

/// What is unlike the base, as options; "base" where nothing is. Of an item buffer that the base has
/// not, what is unlike the default.
fn options(base: &Settings, settings: &Settings) -> String {
    let all = [base, settings].map(|s| serde_json::to_value(s).unwrap_or_default());
    let drawn = serde_json::to_value(Visibility::Drawn(Drawing::DEFAULT)).unwrap_or_default();
    let [old, new] = &all;
    let before = |name: &String| old.get(name).or(drawn.get(name));
    let changed = (new.as_object().into_iter().flatten())
        .filter(|(name, value)| before(name) != Some(*value));
    let texts: Vec<String> = changed
        .map(|(name, value)| match value {
            Value::Bool(_) => format!("--{name}"),
            Value::String(text) => format!("--{name} {text}"),
            other => format!("--{name} {other}"),
        })
        .collect();
    if texts.is_empty() {
        "base".into()
    } else {
        texts.join(" ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::Face;
    use glam::{DVec3, Vec3};

    fn scene(faces: usize) -> Scene {
        let c = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        Scene {
            faces: vec![Face::quad("q", c, Vec3::ONE, Vec3::splat(0.5)); faces],
            ..Scene::default()
        }
    }

    #[test]
    fn every_method_is_another_one_and_says_how() {
        for (faces, quality) in [
            (19, Quality::Normal),
            (168, Quality::Normal),
            (1, Quality::Draft),
        ] {
            let scene = scene(faces);
            let n = texels(&scene, quality);
            let mut all = 0;
            for solver in [Solver::Cpu, Solver::Gpu] {
                let methods = methods(&scene, solver, quality, n);
                all += methods.len();
                assert_eq!(methods[0].options, "base");
                for (k, method) in methods.iter().enumerate() {
                    let s = &method.settings;
                    assert!(
                        s.meshing.cells >= 1
                            && s.meshing.cells <= s.meshing.texels
                            && s.meshing.samples >= 1
                    );
                    let twins = methods[..k].iter().filter(|m| m.options == method.options);
                    assert_eq!(twins.count(), 0, "{}", method.options);
                }
            }
            let expected = if quality == Quality::Draft {
                20..55
            } else {
                54..95
            };
            assert!(expected.contains(&all), "{faces} faces: {all} points");
        }
    }

    #[test]
    fn large_scenes_ask_for_less() {
        assert_eq!(texels(&scene(19), Quality::Normal), 16);
        assert_eq!(texels(&scene(168), Quality::Normal), 4);
        assert_eq!(
            base(&scene(19), Solver::Cpu, Quality::Normal, 16)
                .meshing
                .cells,
            4
        );
        assert_eq!(
            base(&scene(168), Solver::Cpu, Quality::Normal, 8)
                .meshing
                .cells,
            1
        );
        assert_eq!(
            base(&scene(168), Solver::Cpu, Quality::Normal, 4)
                .meshing
                .cells,
            2
        );
        // Too many for the matrix at any useful resolution.
        assert_eq!(texels(&scene(5000), Quality::Normal), 16);
    }
}
