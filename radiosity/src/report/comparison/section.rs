//! Renders one scene's section of the report: verdict, pictures, charts and tables.

use super::figures::{ComparisonFigures, shoots_singly};
use super::tables;
use crate::report::format::{format_count, format_number, format_percent};
use crate::report::page::{file_name, render_chart, render_colour_bar, render_figure, render_verdict};
use crate::report::viewer::{SceneViewer, ViewerLayer};
use common::settings::Visibility;
use maud::{Markup, html};
use oracle::compare::comparison::{Comparison, Preset, SceneComparison};

/// Differences up to this, relative to the rms of reflected radiosity, count as 32-bit rounding (6·10⁻⁸ each).
const ROUNDING_TOLERANCE: f64 = 1e-6;

/// Comparisons of a scene with their figures.
pub struct SceneSection<'a> {
    /// Comparisons of the scene.
    pub judged: &'a SceneComparison,
    figures: Vec<ComparisonFigures>,
}

impl<'a> SceneSection<'a> {
    /// Draws the figures of all comparisons.
    pub fn new(judged: &'a SceneComparison) -> Self {
        Self {
            judged,
            figures: judged.iter_comparisons().map(ComparisonFigures::new).collect(),
        }
    }

    /// Iterates over comparisons and figures.
    fn each_comparison(&self) -> impl Iterator<Item = (&Comparison, &ComparisonFigures)> {
        self.judged.iter_comparisons().zip(&self.figures)
    }

    /// Renders the opening pictures: a view per comparison with its error, and the interactive viewer.
    pub fn render_pictures(&self) -> Markup {
        html! {
            section.pictures {
                h2 { (file_name(&self.judged.first.scene.name)) }
                div.grid {
                    @for (c, f) in self.each_comparison() {
                        (render_figure("", &f.views[1], &format!("The scene, {}", c.preset.name()), html! {
                            b { (preset_heading(c.preset)) } ". "
                            @if c.truth.is_some() {
                                b.gpu { (format_error(c, 1)) " off" } " on the GPU, which this shows, and " b.cpu { (format_error(c, 0)) } " on the CPU."
                            } @else { "Its error is not known." }
                        }))
                    }
                }
                @if let Some((c, f)) = self.each_comparison().next() { (render_viewer(c, f)) }
            }
        }
    }

    /// Renders the section of scene `k`.
    pub fn render_section(&self, k: usize) -> Markup {
        let several = self.figures.len() > 1;
        let name = &self.judged.first.scene.name;
        html! {
            section #{ "scene-" (k + 1) } {
                h2 { (file_name(name)) }
                @if file_name(name) != name { p.facts { code { (name) } } }
                @for (c, figures) in self.each_comparison() { (render_comparison(c, figures, several)) }
            }
        }
    }
}

/// Renders the interactive viewer of both solutions.
fn render_viewer(c: &Comparison, f: &ComparisonFigures) -> Markup {
    let layer = |name, field| ViewerLayer {
        name,
        mesh: &c.mesh,
        field,
    };
    let viewer = SceneViewer {
        scene: &c.scene,
        layers: vec![layer("CPU", &c.cpu.field), layer("GPU", &c.gpu.field)],
        difference: [1, 0],
        irradiance: true,
        reflected: false,
        texel_errors: c.error_map.as_deref(),
        camera: f.camera,
        exposure: f.exposure,
    };
    viewer.render_element()
}

/// Renders one comparison.
fn render_comparison(c: &Comparison, figures: &ComparisonFigures, several: bool) -> Markup {
    html! {
        @if several { h3.way { (preset_heading(c.preset)) } }
        (render_agreement(c))
        (render_accuracy(c))
        p.facts {
            (format_count(c.mesh.faces.len() as u64)) " faces · "
            @if c.error_target.is_none() { (format_count(c.mesh.patches.len() as u64)) " shooters · " }
            (format_count(c.mesh.texels.len() as u64)) " texels · " (c.adapter)
        }
        (render_scene_notes(c))
        h3 { "Views" }
        (render_views(figures, c))
        h3 { "Conditions of the verdict" }
        (tables::gate_table(&c.criteria))
        h3 { "Differences" }
        p { "Reflected radiosity B − E per texel, area-weighted; the worst channel counts." }
        (tables::difference_table(c))
        (render_visibility(c, figures))
        (render_links(c))
        (render_error_causes(c, figures))
        h3 { "Shaders against their twins" }
        p {
            "Each shader and its counterpart in plain Rust get the same input"
            @if c.error_target.is_none() { ", that of the GPU at this stage; one ulp is a unit in the last place of a 32-bit float" }
            "."
        }
        (tables::stage_table(&c.stages))
        h3 { "Energy balance" }
        (tables::energy_bars(&c.cpu_energy, &c.gpu_energy))
        (tables::energy_table(&[("CPU", &c.cpu_energy), ("GPU", &c.gpu_energy)]))
        (render_convergence(figures, c))
        (render_textures(figures))
        h3 { "Settings in force" }
        (tables::settings_table(c))
    }
}

fn preset_heading(way: Preset) -> &'static str {
    match way {
        Preset::SolveDefault => "The default of solve: adaptive, to an error",
        Preset::Paper => "The paper's method: whole faces, discs, one sample, an item buffer",
        Preset::Requested => "The given options",
    }
}

/// Renders the errors of both solutions and the findings about the method.
fn render_accuracy(c: &Comparison) -> Markup {
    html! {
        @if let Some(asked) = c.error_target {
            p.accuracy {
                "Requested error: at most " (format_percent(asked.error)) ". Estimated error: " b.cpu { (format_estimate(c, 0)) }
                " on the CPU, " b.gpu { (format_estimate(c, 1)) } " on the GPU."
            }
        }
        @match &c.truth {
            Some(truth) => p.accuracy {
                "The solutions are " b.cpu { (format_error(c, 0)) } " off on the CPU and " b.gpu { (format_error(c, 1)) }
                " off on the GPU (relative RMS of reflected radiosity, against " (truth.name)
                ", itself off by less than " (format_percent(truth.own_error)) ")."
            },
            None => p.accuracy {
                "The error of the solutions is not known: the scene has too many faces for a reference solution in a "
                "few seconds. " code { "chart" } " computes one."
            },
        }
        @for finding in &c.findings {
            p.finding { b { (finding.name) ": " (format_percent(finding.value)) ". " } (finding.message) "." }
        }
    }
}

fn render_scene_notes(c: &Comparison) -> Markup {
    let notes: Vec<&String> = c.scene.notes.iter().chain(&c.notes).collect();
    html! {
        @if !notes.is_empty() {
            details {
                summary { (notes.len()) @if notes.len() == 1 { " note" } @else { " notes" } }
                ul { @for note in notes { li { (note) } } }
            }
        }
    }
}

/// Renders the verdict with the failed conditions.
fn render_agreement(c: &Comparison) -> Markup {
    let failed: Vec<&str> = c.criteria.iter().filter(|g| !g.pass).map(|g| g.name.as_str()).collect();
    let all = c.criteria.len();
    if c.solvers_agree() {
        render_verdict(Some(true), "Agree", html! { "all " (all) " conditions hold" })
    } else if all == 0 {
        render_verdict(Some(false), "Not compared", html! { "there are no conditions" })
    } else {
        let fail = html! { (failed.len()) " of " (all) " conditions fail: " (failed.join(", ")) };
        render_verdict(Some(false), "Disagree", fail)
    }
}

fn render_views(f: &ComparisonFigures, c: &Comparison) -> Markup {
    let white = format_number(f64::from(f.exposure.white));
    let by = match (c.error_target, c.gpu_settings.transport.visibility) {
        (Some(_), _) => ["visibility by shafts and rays", "visibility by rays"],
        (None, Visibility::Rays) => ["visibility by rays", "visibility by rays as well"],
        (None, _) => ["visibility by rays", "visibility by item buffer"],
    };
    let runs = [("CPU", "cpu", by[0]), ("GPU", "gpu", by[1])];
    let differences = match c.error_target {
        Some(_) => [
            ("free", "independent solves"),
            ("lockstep", "the CPU decides by rays too"),
        ],
        None => [
            ("free", "each with its own choice of shooters"),
            ("lockstep", "the same shooters"),
        ],
    };
    // NaN does not count as alike.
    let apart = [&c.free_difference, &c.lockstep_difference];
    let alike = apart
        .iter()
        .all(|difference| difference.max_relative <= ROUNDING_TOLERANCE);
    let eye = f.camera.eye.to_array().map(|x| format_number(f64::from(x))).join(", ");
    html! {
        div.grid {
            @for ((name, class, how), source) in runs.into_iter().zip(&f.views) {
                (render_figure("", source, &format!("The scene as the {name} solved it"), html! {
                    b class=(class) { (name) } " · radiosity, " (how) ". White is " (white)
                    " W/m²; emitters clip."
                }))
            }
            @for ((name, how), source) in differences.into_iter().zip(&f.differences).filter(|_| !alike) {
                (render_figure("", source, &format!("Difference of the {name} runs in false colours"), html! {
                    b { "GPU − CPU, " (name) } " · " (how) ". Luminance of reflected radiosity, relative to "
                    "its rms on the CPU (" (format_number(f.rms)) " W/m²); clipped beyond the range." (render_colour_bar(f.range))
                }))
            }
        }
        @if alike {
            p { "The two solutions differ at most by rounding: there is no difference to draw." }
        }
        p.small {
            "All from one automatic camera (at " (eye) " in the mesh's unit; back faces are transparent). Both "
            "views share one exposure: the 90th percentile of the CPU's reflected radiosity is at 80 % of white. "
            "Magenta stands for “not a number”. Irradiance is interpolated between texels: the mean over a texel "
            "deviates by " (format_percent(f.quality.relative_rms)) " RMS (shadow edges are blurred over a texel), and the "
            "largest step between coplanar faces is " (format_percent(f.quality.max_step)) " of the rms irradiance, at "
            (format_count(f.quality.border_samples)) " sampled points."
        }
    }
}

fn render_visibility(c: &Comparison, f: &ComparisonFigures) -> Markup {
    let Some(shot) = &f.item_buffer else {
        return html! {};
    };
    let size = shot.size;
    html! {
        h3 { "Visibility: item buffer against rays" }
        p {
            "The visibility of every pair of shooter and texel is computed by both. Where they differ, the texel's "
            "projection must lie next to a boundary between two faces in the item buffer; a mismatch elsewhere is a bug."
        }
        (tables::visibility_table(&c.pairs))
        (tables::list_examples(c))
        div.grid {
            (render_figure("", &shot.pictures[0], "Item buffer in false colours", html! {
                b { "Item buffer" } " · view of " (shot.shooter) " (patch " (shot.patch) "), "
                (size) "×" (size) " pixels, projection " (visibility_name(c))
                ". One colour per face, black: nothing."
            }))
            (render_figure("", &shot.pictures[1], "The scene in the item buffer's colours", html! {
                b { "The same colours in the scene" }
                " · the front of the shooter is white."
            }))
        }
        (render_chart(f.histogram.as_deref(), "No mismatch at all.", html! {
            b { "Mismatches by distance" } " · pairs on which item buffer and rays disagree, against the distance "
            "of the texel's projection to the nearest boundary between two faces, in item buffer pixels."
        }))
    }
}

/// Renders the comparison of links, for adaptive solves.
fn render_links(c: &Comparison) -> Markup {
    html! {
        @if c.error_target.is_some() {
            h3 { "Links: the GPU's against the CPU's" }
            p {
                "Both compute the same links, block by block: the irradiance over them, and stored links themselves. "
                "Where rounding decides whether a node is subdivided or a ray passes an edge, the two may differ, and "
                "the solutions then differ by at most the requested error."
            }
            (tables::link_table(&c.pairs))
        }
    }
}

/// Renders the attribution of the remaining error to causes and texels, for adaptive solves.
fn render_error_causes(c: &Comparison, f: &ComparisonFigures) -> Markup {
    html! {
        @if c.error_target.is_some() {
            h3 { "Remaining error by cause" }
            p {
                "The difference between the last two of successive solves. A sample of texels is gathered again, each "
                "time with one threshold lowered, to attribute the error to its causes. Squares add up."
            }
            (tables::cause_table(&c.estimates))
            @if let Some((picture, range)) = &f.texel_errors {
                div.grid {
                    (render_figure("", picture, "Error estimate per texel", html! {
                        b { "Error estimate" } " · of each texel of the CPU's solution, relative to the rms of "
                        "reflected luminance; clipped beyond the range." (render_colour_bar(*range))
                    }))
                }
            }
        }
    }
}

fn visibility_name(c: &Comparison) -> String {
    match c.gpu_settings.transport.visibility {
        Visibility::Rays => "stereographic (for illustration: the GPU used rays)".to_owned(),
        drawn => drawn.name().to_owned(),
    }
}

fn render_convergence(f: &ComparisonFigures, c: &Comparison) -> Markup {
    if c.error_target.is_some() {
        return html! {};
    }
    let none = if c.cpu.shots.is_empty() || shoots_singly(c) {
        "Nothing was shot.".to_owned()
    } else {
        let passes = [&c.cpu, &c.gpu].map(|run| run.passes);
        format!(
            "Many patches shot at once: {} passes on the CPU, {} on the GPU.",
            passes[0], passes[1]
        )
    };
    html! {
        h3 { "Convergence" }
        (render_chart(f.convergence.as_deref(), &none, html! {
            b { "Unshot power" } " after each shot, as a share of the emitted power, free runs; the dotted line "
            "is the stopping threshold."
        }))
    }
}

fn render_textures(f: &ComparisonFigures) -> Markup {
    let white = format_number(f64::from(f.exposure.white));
    html! {
        h3 { "All textures" }
        div.grid {
            @for ((name, class), source) in [("CPU", "cpu"), ("GPU", "gpu")].into_iter().zip(&f.atlases) {
                (render_figure("pixels", source, &format!("Atlas of all faces, {name}"), html! {
                    b class=(class) { (name) } " · radiosity of every texel, all faces side by side in file "
                    "order. White is " (white) " W/m², as above."
                }))
            }
        }
    }
}

/// Formats a solver's own error estimate (0: CPU, 1: GPU).
fn format_estimate(c: &Comparison, side: usize) -> String {
    c.estimated_error(side).map_or("–".into(), format_percent)
}

/// Formats a solution's error (0: CPU, 1: GPU); – without a reference.
pub fn format_error(c: &Comparison, side: usize) -> String {
    c.truth_error[side].map_or("–".into(), format_percent)
}
