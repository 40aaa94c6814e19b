//! The methods of a chart: a base per solver, one parameter varied at a time, some combinations.

use self::SolverFilter::{Both, Cpu, Gpu};
use super::SolverKind;
use crate::plan::SceneCounts;
use crate::studies::{PIXEL_HEMISPHERE, PIXEL_STEREOGRAPHIC};
use common::form_factor::FormFactor;
use common::scene::Scene;
use common::settings::{
    ItemBufferProjection, ItemBufferSettings, Iteration, Lookup, Meshing, Settings, SolveQuality, Visibility,
};
use cpu::dense::memory::{MAX_MATRIX_BYTES, matrix_bytes};
use oracle::solve::dense;
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
    /// The varied option's name, or "base" or "combination".
    pub sweep: &'static str,
    /// Differences from the base as command-line options.
    pub options: String,
    /// Settings of progressive refinement.
    pub settings: Settings,
    /// Requested error of an adaptive solve; none for progressive refinement.
    pub target_error: Option<f64>,
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

/// Solvers that a row of the table applies to.
#[derive(Clone, Copy, PartialEq)]
enum SolverFilter {
    Both,
    Cpu,
    Gpu,
}

/// Solvers, swept option, whether the short table has the row too, change to the base.
type MethodRow = (SolverFilter, &'static str, bool, fn(&mut Settings));

/// Table of the progressive methods.
const METHOD_ROWS: &[MethodRow] = &[
    (Both, "base", true, |_| ()),
    (Both, "texels", true, |s| s.meshing.texels /= 2),
    (Both, "texels", false, |s| s.meshing.texels *= 2),
    (Both, "cells", false, |s| s.meshing.patches /= 4),
    (Both, "cells", true, |s| s.meshing.patches /= 2),
    (Both, "cells", true, |s| s.meshing.patches *= 2),
    (Both, "samples", true, |s| s.meshing.samples = 1),
    (Cpu, "samples", false, |s| s.meshing.samples = 2),
    (Both, "samples", true, |s| s.meshing.samples *= 4),
    (Both, "form-factor", true, |s| {
        s.transport.form_factor = FormFactor::Disc;
    }),
    (Both, "form-factor", false, |s| {
        s.transport.form_factor = FormFactor::Paper;
    }),
    (Both, "iteration", true, |s| {
        s.schedule.iteration = Iteration::Southwell;
    }),
    (Both, "iteration", false, |s| {
        s.schedule.iteration = Iteration::Chebyshev;
    }),
    (Cpu, "epsilon", false, |s| s.schedule.epsilon = 0.1),
    (Both, "epsilon", true, |s| s.schedule.epsilon = 0.01),
    (Both, "epsilon", false, |s| s.schedule.epsilon = 1e-4),
    (Cpu, "visibility", true, |s| {
        set_item_buffer(s, PIXEL_STEREOGRAPHIC, TWIN_PIXELS);
    }),
    (Cpu, "visibility", false, |s| {
        set_item_buffer(s, PIXEL_HEMISPHERE, TWIN_PIXELS);
    }),
    (Cpu, "visibility", false, |s| {
        set_item_buffer(s, ItemBufferProjection::Hemicube, TWIN_PIXELS);
    }),
    (Cpu, "visibility", false, |s| {
        set_item_buffer(s, ItemBufferProjection::Paper, TWIN_PIXELS);
    }),
    (Gpu, "visibility", true, |s| {
        s.transport.visibility = Visibility::Rays;
    }),
    (Gpu, "visibility", false, |s| {
        set_item_buffer(s, PIXEL_HEMISPHERE, DEFAULT_PIXELS);
    }),
    (Gpu, "visibility", false, |s| {
        set_item_buffer(s, ItemBufferProjection::Hemicube, DEFAULT_PIXELS);
    }),
    (Gpu, "visibility", true, |s| {
        set_item_buffer(s, ItemBufferProjection::Paper, DEFAULT_PIXELS);
    }),
    (Gpu, "item-buffer", true, |s| {
        set_item_buffer(s, PIXEL_STEREOGRAPHIC, 256);
    }),
    (Gpu, "item-buffer", false, |s| {
        set_item_buffer(s, PIXEL_STEREOGRAPHIC, 512);
    }),
    (Gpu, "item-buffer", false, |s| {
        set_item_buffer(s, PIXEL_STEREOGRAPHIC, 2048);
    }),
    (Gpu, "lookup", false, |s| {
        s.transport.visibility = Visibility::ItemBuffer(ItemBufferSettings {
            lookup: Lookup::Exact,
            ..ItemBufferSettings::DEFAULT
        });
    }),
    (Both, "combination", true, set_draft),
    (Both, "combination", false, |s| {
        let texels = s.meshing.texels;
        set_draft(s);
        s.meshing.texels = texels;
    }),
    (Both, "combination", true, set_paper_method),
    (Both, "combination", false, |s| {
        set_paper_method(s);
        s.transport.conserve = true;
    }),
    (Both, "combination", false, |s| {
        s.transport.form_factor = FormFactor::Disc;
        s.transport.conserve = true;
    }),
    (Both, "combination", false, |s| refine_patches(s, 1, 1)),
    (Both, "combination", true, |s| refine_patches(s, 2, 1)),
    (Gpu, "combination", false, |s| refine_patches(s, 1, 4)),
    (Both, "combination", true, |s| refine_patches(s, 2, 4)),
    (Cpu, "combination", false, |s| refine_patches(s, 4, 1)),
    (Cpu, "combination", false, |s| refine_patches(s, 4, 4)),
];

fn set_item_buffer(s: &mut Settings, projection: ItemBufferProjection, pixels: u32) {
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
    if solver == SolverKind::Gpu {
        settings.transport.visibility = Visibility::ItemBuffer(ItemBufferSettings::DEFAULT);
    }
    let samples = |s: &Settings| {
        SceneCounts::new(scene, &s.meshing)
            .link_count()
            .saturating_mul(s.meshing.samples.into())
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

/// Returns all methods of `solver`, without duplicates.
pub fn list_methods(scene: &Scene, solver: SolverKind, quality: SolveQuality, texels: u32) -> Vec<SolveMethod> {
    let base = base_settings(scene, solver, quality, texels);
    let mut methods: Vec<SolveMethod> = Vec::new();
    let own_filter = match solver {
        SolverKind::Cpu => SolverFilter::Cpu,
        SolverKind::Gpu => SolverFilter::Gpu,
        SolverKind::Matrix => return dense_methods(scene, texels),
    };
    let rows = METHOD_ROWS.iter().filter(|(solvers, _, short, _)| {
        (*solvers == SolverFilter::Both || *solvers == own_filter) && (*short || quality != SolveQuality::Draft)
    });
    for (_, sweep, _, change) in rows {
        let mut settings = base;
        change(&mut settings);
        settings.meshing.texels = settings.meshing.texels.max(1);
        settings.meshing.patches = settings.meshing.patches.clamp(1, settings.meshing.texels);
        if methods.iter().all(|m| m.settings != settings) {
            methods.push(SolveMethod {
                solver,
                sweep,
                options: format_options(&base, &settings),
                settings,
                target_error: None,
            });
        }
    }
    let errors = TARGET_ERRORS
        .iter()
        .filter(|(_, short)| *short || quality != SolveQuality::Draft);
    methods.extend(errors.map(|(error, _)| SolveMethod {
        solver,
        sweep: "error",
        options: format!("--error {}%", 100.0 * error),
        settings: base,
        target_error: Some(*error),
    }));
    methods
}

/// Returns the dense solver's methods on the resolutions that fit in memory.
fn dense_methods(scene: &Scene, texels: u32) -> Vec<SolveMethod> {
    let fits = |n: &u32| *n > 0 && matrix_bytes(scene.faces.len() as u64 * u64::from(*n).pow(2)) <= MAX_MATRIX_BYTES;
    let sides = [texels / 4, texels / 2, texels];
    let method = |texels| SolveMethod {
        solver: SolverKind::Matrix,
        sweep: "texels",
        options: format!("--texels {texels}"),
        settings: dense::dense_settings(texels),
        target_error: None,
    };
    sides.into_iter().filter(fits).map(method).collect()
}

/// Returns each setting in result.json as on the command line: name and value.
pub fn option_values(settings: &Value) -> impl Iterator<Item = (&str, String)> {
    let all = settings.as_object().into_iter().flatten();
    all.map(|(key, value)| {
        let name = if key == "cells" { "patches" } else { key };
        (name, value.to_string().trim_matches('"').to_owned())
    })
}

/// Formats the differences from the base as options, or "base" if there are none. An item buffer
/// that the base lacks is compared with the default one.
fn format_options(base: &Settings, settings: &Settings) -> String {
    let drawn = Visibility::ItemBuffer(ItemBufferSettings::DEFAULT);
    let drawn = serde_json::to_value(drawn).unwrap_or_default();
    let [old, new] = [base, settings].map(|s| serde_json::to_value(s).unwrap_or_default());
    let before: HashMap<&str, String> = option_values(&drawn).chain(option_values(&old)).collect();
    let changed = option_values(&new).filter(|(name, value)| before.get(name) != Some(value));
    let text = |(name, value): (&str, String)| match value.as_str() {
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
        for (faces, quality) in [
            (19, SolveQuality::Normal),
            (168, SolveQuality::Normal),
            (1, SolveQuality::Draft),
        ] {
            let scene = scene(faces);
            let n = truth_texels(&scene, quality);
            let mut all = 0;
            for solver in [SolverKind::Cpu, SolverKind::Gpu] {
                let methods = list_methods(&scene, solver, quality, n);
                all += methods.len();
                assert_eq!(methods[0].options, "base");
                for (k, method) in methods.iter().enumerate() {
                    let s = &method.settings;
                    assert!(s.meshing.patches >= 1 && s.meshing.patches <= s.meshing.texels && s.meshing.samples >= 1);
                    let twins = methods[..k].iter().filter(|m| m.options == method.options);
                    assert_eq!(twins.count(), 0, "{}", method.options);
                }
            }
            let expected = if quality == SolveQuality::Draft { 20..55 } else { 54..95 };
            assert!(expected.contains(&all), "{faces} faces: {all} points");
        }
    }

    #[test]
    fn large_scenes_get_fewer_texels_and_patches() {
        assert_eq!(truth_texels(&scene(19), SolveQuality::Normal), 16);
        assert_eq!(truth_texels(&scene(168), SolveQuality::Normal), 4);
        assert_eq!(
            base_settings(&scene(19), SolverKind::Cpu, SolveQuality::Normal, 16)
                .meshing
                .patches,
            4
        );
        assert_eq!(
            base_settings(&scene(168), SolverKind::Cpu, SolveQuality::Normal, 8)
                .meshing
                .patches,
            1
        );
        assert_eq!(
            base_settings(&scene(168), SolverKind::Cpu, SolveQuality::Normal, 4)
                .meshing
                .patches,
            2
        );
        // Too many faces for the dense solver at any of the resolutions.
        assert_eq!(truth_texels(&scene(5000), SolveQuality::Normal), 16);
    }
}
