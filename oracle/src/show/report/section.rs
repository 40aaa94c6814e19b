//! One scene's part of the page: verdict, pictures, charts, tables.

use super::figures::{Figures, singly};
use super::tables;
use crate::judge::comparison::{Comparison, Judged, Way};
use crate::show::number::{count, number, percent};
use crate::show::page::{chart, colour_bar, figure, short, verdict};
use crate::show::viewer::{Layer, Viewer};
use common::settings::Visibility;
use maud::{Markup, html};

/// Differences up to this, in the rms of what is reflected, are roundings of 32 bits, a few of 6·10⁻⁸ each.
const ROUNDING: f64 = 1e-6;

/// A scene, and its pictures as each way solves it.
pub struct Drawn<'a> {
    /// The scene.
    pub judged: &'a Judged,
    figures: Vec<Figures>,
}

impl<'a> Drawn<'a> {
    /// Draws all of it.
    pub fn new(judged: &'a Judged) -> Self {
        Self {
            judged,
            figures: judged.ways().map(Figures::new).collect(),
        }
    }

    fn ways(&self) -> impl Iterator<Item = (&Comparison, &Figures)> {
        self.judged.ways().zip(&self.figures)
    }

    /// What is looked at before anything is read: each way's picture with its error, and the scene to look
    /// around in.
    pub fn pictures(&self) -> Markup {
        html! {
            section.pictures {
                h2 { (short(&self.judged.first.scene.name)) }
                div.grid {
                    @for (c, f) in self.ways() {
                        (figure("", &f.views[1], &format!("The scene, {}", c.way.name()), html! {
                            b { (heading(c.way)) } ". "
                            @if c.truth.is_some() {
                                b.gpu { (error(c, 1)) " off" } " on the GPU, which this shows, and " b.cpu { (error(c, 0)) } " on the CPU."
                            } @else { "How far it is off is not known." }
                        }))
                    }
                }
                @if let Some((c, f)) = self.ways().next() { (around(c, f)) }
            }
        }
    }

    /// The section of scene `k`: what users get comes first.
    pub fn section(&self, k: usize) -> Markup {
        let several = self.figures.len() > 1;
        let name = &self.judged.first.scene.name;
        html! {
            section #{ "scene-" (k + 1) } {
                h2 { (short(name)) }
                @if short(name) != name { p.facts { code { (name) } } }
                @for (c, figures) in self.ways() { (way(c, figures, several)) }
            }
        }
    }
}

/// Both answers, to look around in.
fn around(c: &Comparison, f: &Figures) -> Markup {
    let layer = |name, field| Layer {
        name,
        mesh: &c.mesh,
        field,
    };
    let viewer = Viewer {
        scene: &c.scene,
        layers: vec![layer("CPU", &c.cpu.field), layer("GPU", &c.gpu.field)],
        difference: [1, 0],
        irradiance: true,
        reflected: false,
        off: c.off.as_deref(),
        camera: f.camera,
        exposure: f.exposure,
    };
    viewer.element()
}

/// One way of solving the scene.
fn way(c: &Comparison, figures: &Figures, several: bool) -> Markup {
    html! {
        @if several { h3.way { (heading(c.way)) } }
        (agreement(c))
        (accuracy(c))
        p.facts {
            (count(c.mesh.faces.len() as u64)) " faces · "
            @if c.asked.is_none() { (count(c.mesh.cells.len() as u64)) " shooters · " }
            (count(c.mesh.texels.len() as u64)) " texels · " (c.adapter)
        }
        (notes(c))
        h3 { "What they see" }
        (views(figures, c))
        h3 { "Conditions of the verdict" }
        (tables::gates(&c.gates))
        h3 { "How far apart" }
        p { "Reflected radiosity B − E per texel, area-weighted; the worst channel counts." }
        (tables::differences(c))
        (visibility(c, figures))
        (links(c))
        (certificate(c, figures))
        h3 { "Shaders against their twins" }
        p {
            "Each shader and its counterpart in plain Rust get the same input"
            @if c.asked.is_none() { ", which the GPU itself had there; one ulp is a unit in the last place of a 32-bit float" }
            "."
        }
        (tables::stages(&c.stages))
        h3 { "Where the power went" }
        (tables::energy_bars(&c.cpu_energy, &c.gpu_energy))
        (tables::energy(&[("CPU", &c.cpu_energy), ("GPU", &c.gpu_energy)]))
        (convergence(figures, c))
        (textures(figures))
        h3 { "Settings in force" }
        (tables::settings(c))
    }
}

fn heading(way: Way) -> &'static str {
    match way {
        Way::Solve => "What solve does by default: to an error",
        Way::Paper => "The paper's way: whole faces, discs, one sample, an item buffer",
        Way::Asked => "As asked for",
    }
}

/// How far the answers are off, and what the method errs by: beside the verdict, since agreement
/// says nothing of it.
fn accuracy(c: &Comparison) -> Markup {
    html! {
        @if let Some(asked) = c.asked {
            p.accuracy {
                "Asked: " (percent(asked.error)) " off at most. By its own estimate the CPU's answer is "
                b.cpu { (estimate(c, 0)) } " off, and the GPU's " b.gpu { (estimate(c, 1)) } "."
            }
        }
        @match &c.truth {
            Some(truth) => p.accuracy {
                "The answers are " b.cpu { (error(c, 0)) } " off on the CPU and " b.gpu { (error(c, 1)) }
                " off on the GPU (relative RMS of reflected radiosity, against " (truth.name)
                ", itself off by less than " (percent(truth.own_error)) ")."
            },
            None => p.accuracy {
                "How far the answers are off is not known: the scene has too many faces for a truth of a few "
                "seconds. " code { "chart" } " finds one."
            },
        }
        @for finding in &c.findings {
            p.finding { b { (finding.name) ": " (percent(finding.value)) ". " } (finding.message) "." }
        }
    }
}

fn notes(c: &Comparison) -> Markup {
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

/// Large and at once, with what failed.
fn agreement(c: &Comparison) -> Markup {
    let failed: Vec<&str> = c
        .gates
        .iter()
        .filter(|g| !g.pass)
        .map(|g| g.name.as_str())
        .collect();
    let all = c.gates.len();
    if c.agree() {
        verdict(
            Some(true),
            "Agree",
            html! { "all " (all) " conditions hold" },
        )
    } else if all == 0 {
        verdict(
            Some(false),
            "Not compared",
            html! { "there are no conditions" },
        )
    } else {
        let fail = html! { (failed.len()) " of " (all) " conditions fail: " (failed.join(", ")) };
        verdict(Some(false), "Disagree", fail)
    }
}

fn views(f: &Figures, c: &Comparison) -> Markup {
    let white = number(f64::from(f.exposure.white));
    let by = match (c.asked, c.gpu_settings.transport.visibility) {
        (Some(_), _) => ["visibility by shafts and rays", "visibility by rays"],
        (None, Visibility::Rays) => ["visibility by rays", "visibility by rays as well"],
        (None, _) => ["visibility by rays", "visibility by item buffer"],
    };
    let runs = [("CPU", "cpu", by[0]), ("GPU", "gpu", by[1])];
    let differences = match c.asked {
        Some(_) => [
            ("free", "each as it solves by itself"),
            ("lockstep", "the CPU decides by rays too"),
        ],
        None => [
            ("free", "each chose its own shooters"),
            ("lockstep", "the same shooters"),
        ],
    };
    // What is no number is not alike.
    let apart = [&c.free_difference, &c.lockstep_difference];
    let alike = apart
        .iter()
        .all(|difference| difference.max_relative <= ROUNDING);
    let eye = f
        .camera
        .eye
        .to_array()
        .map(|x| number(f64::from(x)))
        .join(", ");
    html! {
        div.grid {
            @for ((name, class, how), source) in runs.into_iter().zip(&f.views) {
                (figure("", source, &format!("The scene as the {name} solved it"), html! {
                    b class=(class) { (name) } " · radiosity, " (how) ". White is " (white)
                    " W/m²; emitters clip."
                }))
            }
            @for ((name, how), source) in differences.into_iter().zip(&f.differences).filter(|_| !alike) {
                (figure("", source, &format!("Difference of the {name} runs in false colours"), html! {
                    b { "GPU − CPU, " (name) } " · " (how) ". Luminance of reflected radiosity, relative to "
                    "its rms on the CPU (" (number(f.rms)) " W/m²); clipped beyond the range." (colour_bar(f.range))
                }))
            }
        }
        @if alike {
            p { "The two answers differ by rounding alone, or not at all: there is no difference to draw." }
        }
        p.small {
            "All from one automatic camera (at " (eye) " in the mesh's unit; backs are looked through). Both "
            "views share one exposure: the 90th percentile of what the CPU's surfaces reflect is at 80 % of white. "
            "Magenta would be “not a number”. Irradiance is interpolated between texels: the mean over a texel is "
            "off by " (percent(f.quality.relative_rms)) " RMS (shadow edges are drawn out over a texel), and where "
            "coplanar faces meet a step of " (percent(f.quality.max_step)) " of the rms irradiance is left, at "
            "most, at " (count(f.quality.border_samples)) " points looked at."
        }
    }
}

fn visibility(c: &Comparison, f: &Figures) -> Markup {
    let Some(shot) = &f.item_buffer else {
        return html! {};
    };
    let size = shot.size;
    html! {
        h3 { "Who sees whom: item buffer against rays" }
        p {
            "Every pair of a shooter and a texel is asked twice. Where the answers differ, the texel's projection "
            "must lie next to a boundary between two faces in the item buffer; a mismatch elsewhere is a bug."
        }
        (tables::pairs(&c.pairs))
        (tables::examples(c))
        div.grid {
            (figure("", &shot.pictures[0], "Item buffer in false colours", html! {
                b { "Item buffer" } " · what " (shot.shooter) " sees (cell " (shot.cell) "), "
                (size) "×" (size) " pixels, projection " (visibility_name(c))
                ". One colour per face, black: nothing."
            }))
            (figure("", &shot.pictures[1], "The scene in the item buffer's colours", html! {
                b { "The same colours in the scene" }
                " · the shooter is white, where the camera sees its front."
            }))
        }
        (chart(f.histogram.as_deref(), "No mismatch at all.", html! {
            b { "Mismatches by distance" } " · pairs on which item buffer and rays disagree, against the distance "
            "of the texel's projection to the nearest boundary between two faces, in item buffer pixels."
        }))
    }
}

/// To an error.
fn links(c: &Comparison) -> Markup {
    html! {
        @if c.asked.is_some() {
            h3 { "Links: the GPU's against the CPU's" }
            p {
                "Both are asked for the same links, block after block: what arrives over them, and for links that "
                "are kept what they are. Where rounding decides whether a node is cut, or whether a ray passes an "
                "edge, the two may differ, and the answer differs by what was asked at most."
            }
            (tables::blocks(&c.pairs))
        }
    }
}

/// To an error: what of it is due to what, and where it sits.
fn certificate(c: &Comparison, f: &Figures) -> Markup {
    html! {
        @if c.asked.is_some() {
            h3 { "What is left of the error" }
            p {
                "By how much the last of several solves still differed from the one before. Some texels then "
                "receive again, each time with one thing done more finely: that tells what of it is due to what. "
                "Squares add up."
            }
            (tables::causes(&c.estimates))
            @if let Some((picture, range)) = &f.off {
                div.grid {
                    (figure("", picture, "How far off each texel may be", html! {
                        b { "Where it sits" } " · how far each texel of the CPU's answer may be off, relative to the "
                        "rms of reflected luminance; clipped beyond the range." (colour_bar(*range))
                    }))
                }
            }
        }
    }
}

fn visibility_name(c: &Comparison) -> String {
    match c.gpu_settings.transport.visibility {
        Visibility::Rays => "stereographic (drawn for the eye: the GPU asked rays)".to_owned(),
        drawn => drawn.name().to_owned(),
    }
}

fn convergence(f: &Figures, c: &Comparison) -> Markup {
    if c.asked.is_some() {
        return html! {};
    }
    let none = if c.cpu.shots.is_empty() || singly(c) {
        "Nothing was shot.".to_owned()
    } else {
        let passes = [&c.cpu, &c.gpu].map(|run| run.passes);
        format!(
            "Many cells shot at once: {} passes on the CPU, {} on the GPU.",
            passes[0], passes[1]
        )
    };
    html! {
        h3 { "Shot by shot" }
        (chart(f.convergence.as_deref(), &none, html! {
            b { "Unshot power" } " after each shot, as a share of the emitted power, free runs; the dotted line "
            "is where they stop."
        }))
    }
}

fn textures(f: &Figures) -> Markup {
    let white = number(f64::from(f.exposure.white));
    html! {
        h3 { "All textures" }
        div.grid {
            @for ((name, class), source) in [("CPU", "cpu"), ("GPU", "gpu")].into_iter().zip(&f.atlases) {
                (figure("pixels", source, &format!("Atlas of all faces, {name}"), html! {
                    b class=(class) { (name) } " · radiosity of every texel, all faces side by side in file "
                    "order. White is " (white) " W/m², as above."
                }))
            }
        }
    }
}

fn estimate(c: &Comparison, side: usize) -> String {
    c.estimated(side).map_or("–".into(), percent)
}

/// The error of an answer, CPU's or GPU's; – where there is no truth.
pub fn error(c: &Comparison, side: usize) -> String {
    c.error[side].map_or("–".into(), percent)
}
