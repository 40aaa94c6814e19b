//! The methods of a chart: a base per solver, one parameter varied at a time, some combinations.

use crate::plan::SceneCounts;
use common::form_factor::FormFactor;
use common::scene::Scene;
use common::settings::ItemBufferProjection::{self, Hemicube, Hemisphere, Paper, Stereographic};
use common::settings::{ItemBufferSettings, Iteration, Meshing, Settings, SolveQuality, Visibility};
use cpu::dense::memory::{MAX_MATRIX_BYTES, matrix_bytes};
use oracle::solve::dense;
use oracle::solve::solver::SolverKind::{self, Cpu, Dense, Gpu};
use serde_json::Value;
use std::collections::HashMap;

/// Most visibility samples of the base; its patches are halved until it has no more.
const MAX_BASE_SAMPLES: u64 = 1 << 24;
/// Most texels of a truth by the dense solver: about a minute of solving.
const MAX_TRUTH_TEXELS: u64 = 6000;
/// Item-buffer pixels per side on the CPU, whose scalar rasteriser is slow.
const TWIN_PIXELS: u32 = 256;
const DEFAULT_PIXELS: u32 = ItemBufferSettings::DEFAULT.size;

/// One way to solve a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SolveMethod {
    /// The solver.
    pub solver: SolverKind,
    /// Differences from the base as command-line options.
    pub options: String,
    /// Settings of progressive refinement.
    pub settings: Settings,
    /// Requested error of an adaptive solve; none for progressive refinement.
    pub target_error: Option<f64>,
    /// Name of the curve, and value of the varied option.
    pub curve: Option<(&'static str, f64)>,
}

impl SolveMethod {
    /// Makes a method of progressive refinement, or of the dense solver, that is on no curve.
    pub fn new(solver: SolverKind, options: impl Into<String>, settings: Settings) -> Self {
        Self {
            solver,
            options: options.into(),
            settings,
            target_error: None,
            curve: None,
        }
    }

    /// Makes an adaptive method.
    pub fn to_error(solver: SolverKind, error: f64, settings: Settings) -> Self {
        Self {
            target_error: Some(error),
            ..Self::new(solver, format!("--error {}%", 100.0 * error), settings)
        }
    }
}

/// Requested errors, and whether the short table has them too.
const TARGET_ERRORS: [(f64, bool); 7] = [
    (0.1, false),
    (0.05, true),
    (0.02, false),
    (0.01, true),
    (0.005, false),
    (0.003, true),
    (0.002, false),
];

const BOTH: &[SolverKind] = &[Cpu, Gpu];

/// Solvers, whether the short table has the row too, change to the base.
type MethodRow = (&'static [SolverKind], bool, fn(&mut Settings));

/// Table of the progressive methods; the first row is the base.
const METHOD_ROWS: &[MethodRow] = &[
    (BOTH, true, |_| ()),
    (BOTH, true, |s| s.meshing.texels /= 2),
    (BOTH, false, |s| s.meshing.texels *= 2),
    (BOTH, false, |s| s.meshing.patches /= 4),
    (BOTH, true, |s| s.meshing.patches /= 2),
    (BOTH, true, |s| s.meshing.patches *= 2),
    (BOTH, true, |s| s.meshing.samples = 1),
    (BOTH, true, |s| s.meshing.samples *= 4),
    (BOTH, true, |s| s.transport.form_factor = FormFactor::Disc),
    (BOTH, false, |s| s.transport.form_factor = FormFactor::Paper),
    (BOTH, true, |s| s.schedule.iteration = Iteration::Southwell),
    (BOTH, false, |s| s.schedule.iteration = Iteration::Chebyshev),
    (BOTH, true, |s| s.schedule.epsilon = 0.01),
    (BOTH, false, |s| s.schedule.epsilon = 1e-4),
    (&[Cpu], true, |s| draw_with(s, Stereographic, TWIN_PIXELS)),
    (&[Gpu], true, |s| s.transport.visibility = Visibility::Rays),
    (&[Gpu], false, |s| draw_with(s, Hemisphere, DEFAULT_PIXELS)),
    (&[Gpu], false, |s| draw_with(s, Hemicube, DEFAULT_PIXELS)),
    (&[Gpu], true, |s| draw_with(s, Paper, DEFAULT_PIXELS)),
    (&[Gpu], true, |s| draw_with(s, Stereographic, 256)),
    (&[Gpu], false, |s| draw_with(s, Stereographic, 2048)),
    (BOTH, true, set_draft),
    (BOTH, true, set_paper_method),
    (BOTH, false, |s| {
        set_paper_method(s);
        s.transport.conserve = true;
    }),
    (BOTH, true, |s| refine_patches(s, 2, 1)),
    (BOTH, true, |s| refine_patches(s, 2, 4)),
    (&[Cpu], false, |s| refine_patches(s, 4, 1)),
    (&[Cpu], false, |s| refine_patches(s, 4, 4)),
];

fn draw_with(s: &mut Settings, projection: ItemBufferProjection, pixels: u32) {
    s.transport.visibility = Visibility::with_item_buffer(projection, pixels);
}

/// Sets the meshing and ε of `--quality draft`, but no finer than the base.
fn set_draft(s: &mut Settings) {
    let draft = SolveQuality::Draft.meshing();
    s.meshing = Meshing {
        texels: s.meshing.texels.min(draft.texels),
        patches: s.meshing.patches.min(draft.patches),
        ..draft
    };
    s.schedule.epsilon = SolveQuality::Draft.epsilon();
}

/// Sets the paper's method: whole faces shoot, disc factors between centres, Southwell iteration.
fn set_paper_method(s: &mut Settings) {
    (s.meshing.patches, s.meshing.samples) = (1, 1);
    s.transport.form_factor = FormFactor::Disc;
    s.schedule.iteration = Iteration::Southwell;
}

/// Sets ray visibility and multiplies patches and samples.
fn refine_patches(s: &mut Settings, patches: u32, samples: u32) {
    s.transport.visibility = Visibility::Rays;
    s.meshing.patches *= patches;
    s.meshing.samples *= samples;
}

/// Returns the default settings of progressive refinement on N×N texels, with fewer patches in
/// large scenes.
pub fn base_settings(scene: &Scene, solver: SolverKind, quality: SolveQuality, texels: u32) -> Settings {
    let mut settings = Settings::with_quality(quality);
    settings.meshing.texels = texels;
    settings.schedule.iteration = Iteration::Cg;
    if solver == Gpu {
        settings.transport.visibility = Visibility::ItemBuffer(ItemBufferSettings::DEFAULT);
    }
    let samples = |s: &Settings| {
        let links = SceneCounts::new(scene, &s.meshing).link_count();
        links.saturating_mul(s.meshing.samples.into())
    };
    while settings.meshing.patches > 1 && samples(&settings) > MAX_BASE_SAMPLES {
        settings.meshing.patches /= 2;
    }
    settings
}

/// Returns the texels per side on which errors are measured: those of `quality`, or a half or a
/// quarter of them if the dense solver can then provide the truth.
pub fn truth_texels(scene: &Scene, quality: SolveQuality) -> u32 {
    let requested = quality.meshing().texels;
    let fits = |n: &u32| scene.faces.len() as u64 * u64::from(*n).pow(2) <= MAX_TRUTH_TEXELS;
    let sides = [requested, requested / 2, requested / 4];
    sides.into_iter().find(fits).unwrap_or(requested)
}

/// Returns whether the dense solver's system for N×N texels per face fits in memory.
pub fn has_dense_truth(scene: &Scene, texels: u32) -> bool {
    texels > 0 && matrix_bytes(scene.faces.len() as u64 * u64::from(texels).pow(2)) <= MAX_MATRIX_BYTES
}

/// Returns all methods of `solver`, without duplicates.
pub fn list_methods(scene: &Scene, solver: SolverKind, quality: SolveQuality, texels: u32) -> Vec<SolveMethod> {
    if solver == Dense {
        let sides = [texels / 4, texels / 2, texels].into_iter();
        let fitting = sides.filter(|texels| has_dense_truth(scene, *texels));
        let method = |n| SolveMethod::new(Dense, format!("--texels {n}"), dense::dense_settings(n));
        return fitting.map(method).collect();
    }
    let base = base_settings(scene, solver, quality, texels);
    let mut methods: Vec<SolveMethod> = Vec::new();
    let is_listed = |short: bool| short || quality != SolveQuality::Draft;
    for (solvers, short, change) in METHOD_ROWS {
        let mut settings = base;
        change(&mut settings);
        settings.meshing.texels = settings.meshing.texels.max(1);
        settings.meshing.patches = settings.meshing.patches.clamp(1, settings.meshing.texels);
        let is_new = methods.iter().all(|m| m.settings != settings);
        if solvers.contains(&solver) && is_listed(*short) && is_new {
            methods.push(SolveMethod::new(solver, format_options(&base, &settings), settings));
        }
    }
    let errors = TARGET_ERRORS.iter().filter(|(_, short)| is_listed(*short));
    methods.extend(errors.map(|(error, _)| SolveMethod::to_error(solver, *error, base)));
    methods
}

/// Returns each setting in result.json as on the command line: name and value.
fn option_values(settings: &Settings) -> Vec<(String, String)> {
    let Ok(Value::Object(all)) = serde_json::to_value(settings) else {
        return Vec::new();
    };
    let option = |(name, value): (String, Value)| {
        let name = if name == "cells" { "patches".into() } else { name };
        (name, value.to_string().trim_matches('"').to_owned())
    };
    all.into_iter().map(option).collect()
}

/// Formats the differences from the base as options, or "base" if there are none. An item buffer
/// that the base lacks is compared with the default one.
fn format_options(base: &Settings, settings: &Settings) -> String {
    let mut drawn = *base;
    drawn.transport.visibility = Visibility::ItemBuffer(ItemBufferSettings::DEFAULT);
    let before: HashMap<String, String> = [option_values(&drawn), option_values(base)]
        .concat()
        .into_iter()
        .collect();
    let changed = option_values(settings)
        .into_iter()
        .filter(|(name, value)| before.get(name) != Some(value));
    let text = |(name, value): (String, String)| match value.as_str() {
        "true" | "false" => format!("--{name}"),
        _ => format!("--{name} {value}"),
    };
    let texts: Vec<String> = changed.map(text).collect();
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
    fn methods_differ_and_name_their_options() {
        for (faces, quality, expected) in [
            (19, SolveQuality::Normal, 40..70),
            (168, SolveQuality::Normal, 40..70),
            (1, SolveQuality::Draft, 20..55),
        ] {
            let scene = scene(faces);
            let n = truth_texels(&scene, quality);
            let mut all = 0;
            for solver in [Cpu, Gpu] {
                let methods = list_methods(&scene, solver, quality, n);
                all += methods.len();
                assert_eq!(methods[0].options, "base");
                for (k, method) in methods.iter().enumerate() {
                    let Meshing {
                        texels,
                        patches,
                        samples,
                    } = method.settings.meshing;
                    assert!((1..=texels).contains(&patches) && samples >= 1);
                    let is_twin = |m: &SolveMethod| m.options == method.options;
                    assert!(!methods[..k].iter().any(is_twin), "{}", method.options);
                }
            }
            assert!(expected.contains(&all), "{faces} faces: {all} points");
        }
    }

    #[test]
    fn large_scenes_get_fewer_texels_and_patches() {
        // The dense solver has too many texels with 5000 faces at any resolution.
        for (faces, texels) in [(19, 16), (168, 4), (5000, 16)] {
            assert_eq!(truth_texels(&scene(faces), SolveQuality::Normal), texels);
        }
        for (faces, texels, patches) in [(19, 16, 4), (168, 8, 1), (168, 4, 2)] {
            let settings = base_settings(&scene(faces), Cpu, SolveQuality::Normal, texels);
            assert_eq!(settings.meshing.patches, patches);
        }
    }
}
