//! `trace.html`: progressive refinement shot by shot, as an offline page that repeats the shots from their record
//! ([`oracle::trace`]).
//!
//! [`algorithm`] lists the steps with the files that do them, [`data`] packs the arrays, and the scripts add to the viewer:
//! `trace_data.js` reads the arrays and accumulates shots, `trace_viewer.js` displays texels, `trace_panels.js` draws the
//! figures beside it, `trace_hemisphere.js` what the shooter sees, `trace_page.js` moves through the shots. [`links`] is the
//! page of a solve to an error; both use `elements.js` and `outlines.js`.

pub mod algorithm;
pub mod data;
pub mod links;

use self::algorithm::{AlgorithmStep, algorithm_steps};
use self::data::{PART_BYTES, ShownPart, energy_parts, pack_arrays};
use super::document::{Blocks, render_document};
use super::format::{count_noun, file_name};
use super::picture::Exposure;
use super::solution_view::RenderedPreview;
use super::view::camera::Camera;
use super::view::interpolation::{CarriedLight, InterpolationSurface};
use super::viewer::{SceneViewer, ViewerLayer, viewer_assets};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use common::settings::{Schedule, Settings};
use common::shooting::SolveRun;
use common::solution::Solution;
use common::{Error, Result};
use maud::{Markup, PreEscaped, Render, html};
use oracle::trace::hemisphere::hemisphere_settings;
use oracle::trace::packing::HALF_ROUNDING;
use oracle::trace::recorder::TraceLimits;
use oracle::trace::{ShotTrace, TraceLimit};
use serde_json::json;

/// Maximum bytes of the page.
pub const MAX_PAGE_BYTES: usize = 5_000_000;
/// Limits of a record that a page can hold: three quarters of its bytes, since base 64 adds a third, and 192 MB of links in the
/// browser's memory, with visible shares and occluders.
pub const TRACE_LIMITS: TraceLimits = TraceLimits {
    bytes: MAX_PAGE_BYTES / 4 * 3,
    links: 1 << 25,
    each: PART_BYTES,
};
/// Maximum texels of a scene with a trace: a browser draws them all at each shot.
pub const MAX_TRACED_TEXELS: u64 = 1 << 18;
/// Maximum faces of a scene with a trace: their geometry takes two of the page's five million bytes.
pub const MAX_TRACED_FACES: u64 = 15_000;

/// Scripts of all pages of records.
const SHARED_SCRIPTS: [&str; 2] = [include_str!("elements.js"), include_str!("outlines.js")];
const PAGE_SCRIPTS: [&str; 5] = [
    include_str!("trace_data.js"),
    include_str!("trace_viewer.js"),
    include_str!("trace_panels.js"),
    include_str!("trace_hemisphere.js"),
    include_str!("trace_page.js"),
];
const STYLE: &str = include_str!("trace.css");

/// Displayed quantities: name in the script, text of the button; the last of item buffers alone.
const SHOWN_QUANTITIES: [(&str, &str); 7] = [
    ("radiosity", "radiosity B"),
    ("residual", "residual r"),
    ("change", "ΔB of this shot"),
    ("visibility", "visibility V"),
    ("form_factor", "form factor F"),
    ("before", "r before"),
    ("error", "B − B by rays"),
];
const SHOT_HELP: &str = "Keys: ← → step, Home End, space plays, n next line. In the picture: drag to orbit, drag with Shift or the right button to pan, wheel or pinch to zoom; point at a texel or tap it; ↑ ↓, + −, [ ] exposure, 1 to 7, g texels, f false colours, r.";

/// A page, and how many shots it has.
pub struct TracePage {
    /// The file.
    pub html: String,
    /// Number of shots on the page.
    pub shots: usize,
    /// Number of shots of the solve.
    pub shot_count: usize,
    /// Limit beyond which the page has no shots; none if it has all.
    pub reached_limit: Option<TraceLimit>,
}

/// Renders the record of a solve with a camera and an exposure, for a page that has the [assets](trace_assets) already: what is
/// said before and after it, and its element with all recorded shots.
pub fn render_record(solution: &Solution, trace: &ShotTrace, view: (Camera, Exposure)) -> String {
    let shown = ShownPart {
        shots: trace.shots.len(),
        links: trace.links.len(),
    };
    let renderer = PageRenderer::new(solution, trace, view);
    renderer.render_blocks(shown).render().into_string()
}

/// Returns the style sheet and the scripts of records, which a page includes once, with more scripts of the page.
pub fn trace_assets(more: &[&str]) -> Markup {
    viewer_assets(STYLE, &[&SHARED_SCRIPTS[..], &PAGE_SCRIPTS, more].concat())
}

impl TracePage {
    /// Renders the page of a solve with its record and the camera and exposure of its picture. If not all shots fit into
    /// [`MAX_PAGE_BYTES`] it has the first.
    pub fn new(solution: &Solution, trace: &ShotTrace, preview: &RenderedPreview) -> Self {
        let renderer = PageRenderer::new(solution, trace, (preview.camera, preview.exposure));
        let frame = renderer.render_part(ShownPart::default()).len();
        let room = MAX_PAGE_BYTES.saturating_sub(frame) / 4 * 3;
        let (shots, links) = trace.count_fitting(room, PART_BYTES);
        let shown = ShownPart { shots, links };
        Self {
            html: renderer.render_part(shown),
            shots,
            shot_count: trace.shot_count,
            reached_limit: renderer.reached_limit(shown),
        }
    }

    /// Returns a note if the page has not all shots.
    pub fn describe_missing_shots(&self) -> Option<String> {
        let limit = describe_limit(self.reached_limit?);
        if self.shots == 0 {
            return Some(format!(
                "no trace.html is written, since not one shot fits into {limit}: give fewer --texels or --patches"
            ));
        }
        Some(format!(
            "trace.html has the first {} of {}: more do not fit into {limit}; with fewer --texels or --patches they do",
            count_noun(self.shots, "shot", "shots"),
            self.shot_count,
        ))
    }
}

/// Returns a limit of the page in words.
fn describe_limit(limit: TraceLimit) -> String {
    match limit {
        TraceLimit::Bytes => format!("{} MB", MAX_PAGE_BYTES / 1_000_000),
        TraceLimit::Links => format!(
            "the {} million links (shooters × texels) for which a browser has memory",
            TRACE_LIMITS.links / 1_000_000
        ),
    }
}

/// Checks that a page can show a scene of so many faces and texels.
///
/// Errors: [`Error::Usage`], which names the scene.
pub fn check_trace_limits(name: &str, faces: u64, texels: u64) -> Result<()> {
    let refuse = |count: u64, most: u64, what: &str, help: &str| {
        Err(Error::Usage(format!(
            "{name}: --trace is for at most {most} {what}, and here are {count}: {help}"
        )))
    };
    if faces > MAX_TRACED_FACES {
        return refuse(
            faces,
            MAX_TRACED_FACES,
            "faces",
            "leave it out, or trace a smaller scene",
        );
    }
    if texels > MAX_TRACED_TEXELS {
        return refuse(texels, MAX_TRACED_TEXELS, "texels", "give fewer --texels");
    }
    Ok(())
}

/// Returns the reason for which a solve ended.
pub fn describe_end(run: &SolveRun, schedule: &Schedule) -> String {
    let threshold = format!("ε = {} % (dashed)", 100.0 * schedule.epsilon);
    match run.shots.len() {
        _ if run.converged => format!("the solve ended at {threshold}"),
        count if count >= schedule.max_shots as usize => {
            format!("the solve was ended by --max-shots {count}, before {threshold}")
        }
        count => format!("the solve was interrupted after {count} shots, before {threshold}"),
    }
}

/// Returns whether a record has the errors of visible shares against rays.
fn is_compared_with_rays(solution: &Solution, trace: &ShotTrace) -> bool {
    trace.relight.is_none() && solution.settings.transport.visibility.item_buffer().is_some()
}

/// Renders the viewer without light: the page computes it. `is_compared` with rays.
fn render_viewer(solution: &Solution, (camera, exposure): (Camera, Exposure), is_compared: bool) -> Markup {
    let (scene, mesh) = (solution.scene, solution.mesh);
    let surface = InterpolationSurface::new(scene, mesh);
    let viewer = SceneViewer {
        scene,
        surface: &surface,
        layers: vec![ViewerLayer {
            name: solution.solver,
            mesh,
            field: None,
        }],
        irradiance: false,
        carried: CarriedLight::Irradiance,
        texel_errors: None,
        camera,
        exposure,
    };
    viewer.render_quantities(
        &SHOWN_QUANTITIES[..SHOWN_QUANTITIES.len() - usize::from(!is_compared)],
        SHOT_HELP,
    )
}

struct PageRenderer<'a> {
    solution: &'a Solution<'a>,
    trace: &'a ShotTrace,
    viewer: Markup,
}

impl<'a> PageRenderer<'a> {
    fn new(solution: &'a Solution<'a>, trace: &'a ShotTrace, view: (Camera, Exposure)) -> Self {
        Self {
            solution,
            trace,
            viewer: render_viewer(solution, view, is_compared_with_rays(solution, trace)),
        }
    }

    /// Renders the page with a part of the trace.
    fn render_part(&self, shown: ShownPart) -> String {
        let mut opening = self.render_blocks(shown);
        opening.add_element(trace_assets(&[]));
        let title = format!("{}, shot by shot", file_name(&self.solution.scene.name));
        render_document(&title, &opening, &[], "")
    }

    /// Renders a part of the trace without the assets of a page.
    fn render_blocks(&self, shown: ShownPart) -> Blocks {
        let settings = self.solution.settings;
        let is_covered = self.solution.mesh.patches.iter().any(|patch| patch.open_share < 1.0);
        let relight = self.trace.relight.as_ref();
        let mut opening = Blocks::default();
        opening.add_remark(self.describe_solve());
        if let Some(limit) = self.reached_limit(shown) {
            opening.add_warning(format!(
                "This page has the first {} of {} shots: more do not fit into {}.",
                shown.shots,
                self.trace.shot_count,
                describe_limit(limit)
            ));
        }
        opening
            .add_element(html! {
                div.trace data-shots=(shown.shots) {
                    (render_player(shown.shots))
                    div.trace-columns {
                        div.trace-scene { (self.viewer) }
                        div.trace-panels {
                            (render_panel("choice", "Why this patch shoots"))
                            (render_panel("hemisphere", "What the shooter sees"))
                            (render_algorithm(
                                match relight {
                                    Some(_) => "The algorithm (Table 2, corrected)",
                                    None => "The algorithm (Table 1, corrected)",
                                },
                                &algorithm_steps(&settings.transport, is_covered, relight),
                            ))
                            (render_panel("energy", match relight {
                                Some(_) => "What the objects change",
                                None => "Where the emitted power is",
                            }))
                            (render_panel("curve", "Unshot power"))
                        }
                    }
                    (self.render_data(shown))
                }
            })
            .add_remark(self.describe_precision());
        opening
    }

    /// Returns the limit beyond which the shown part has no shots; none if it has all.
    fn reached_limit(&self, shown: ShownPart) -> Option<TraceLimit> {
        match shown.shots < self.trace.shots.len() {
            true => Some(TraceLimit::Bytes),
            false => self.trace.reached_limit,
        }
    }

    fn describe_solve(&self) -> String {
        let solution = self.solution;
        let Settings { meshing, transport, .. } = solution.settings;
        let order = match self.trace.relight {
            Some(_) => {
                "First every patch of the room shoots its captured light: objects receive it, and the room loses what they hide. \
                 Then the change is shot, of either sign."
            }
            None => "Of the patches the one with the most unshot power shoots next.",
        };
        format!(
            "{}, {}, {}; visibility {}, form factor {}, {}; {} on {}. {order}",
            count_noun(solution.mesh.faces.len(), "face", "faces"),
            count_noun(solution.mesh.patches.len(), "patch", "patches"),
            count_noun(solution.mesh.texels.len(), "texel", "texels"),
            transport.visibility.name(),
            json!(transport.form_factor).as_str().unwrap_or_default(),
            count_noun(meshing.samples as usize, "sample", "samples"),
            count_noun(self.trace.shot_count, "shot", "shots"),
            solution.adapter.unwrap_or("the CPU"),
        )
    }

    fn describe_precision(&self) -> String {
        format!(
            "The page repeats the solver’s shots from its form factors F and visible shares V, each rounded by {:.2} % at most \
             (half floats); B − E is therefore within {:.1} % of the solver’s.",
            100.0 * HALF_ROUNDING,
            200.0 * HALF_ROUNDING
        )
    }

    /// Renders the data for the scripts.
    fn render_data(&self, shown: ShownPart) -> Markup {
        let Solution { mesh, settings, .. } = *self.solution;
        let trace = self.trace;
        let drawing = hemisphere_settings(settings.transport.visibility);
        let emitted = f64::from(self.solution.run.emitted);
        let unshot = trace
            .relight
            .map_or(emitted, |relight| f64::from(relight.captured_power));
        let head = json!({
            "shots": shown.shots,
            "shot_count": trace.shot_count,
            "links": shown.links,
            "patches": mesh.patches.len(),
            "ranked": oracle::trace::RANKED_PATCHES,
            "unit": mesh.unit,
            "epsilon": settings.schedule.epsilon * emitted / unshot.max(f64::MIN_POSITIVE),
            "end": describe_end(self.solution.run, &settings.schedule),
            "hemisphere": { "size": drawing.size, "projection": drawing.projection.name() },
            "form_factor": settings.transport.form_factor,
            "samples": settings.meshing.samples,
            "item_buffer": is_compared_with_rays(self.solution, trace),
            "emitted": trace.initial_energy.map(|energy| energy.emitted.iter().sum::<f64>()),
            "initial": energy_parts(trace.initial_energy.as_ref()),
            "unshot": unshot * mesh.area_unit(),
            "relight": trace.relight.map(|relight| json!({
                "room_faces": mesh.room_faces,
                "reshoot": relight.reshoot,
            })),
        });
        let shooters = trace.links[..shown.links].iter().zip(&trace.hemispheres);
        let parts = shooters.flat_map(|(links, hemisphere)| [&links.deflated, &hemisphere.deflated]);
        let links: Vec<u8> = parts.flatten().copied().collect();
        html! {
            script.trace-head type="application/json" { (PreEscaped(head.to_string())) }
            script.trace-arrays type="text/plain" { (PreEscaped(STANDARD.encode(pack_arrays(trace, mesh, shown)))) }
            script.trace-links type="text/plain" { (PreEscaped(STANDARD.encode(links))) }
        }
    }
}

/// Renders the buttons and the slider that move through the shots.
fn render_player(shots: usize) -> Markup {
    let button = |act: &str, name: &str, sign: &str| {
        html! { button type="button" data-act=(act) title=(name) aria-label=(name) { (sign) } }
    };
    html! {
        div.player role="group" aria-label="Shots" {
            span.buttons {
                (button("first", "Before the first shot (Home)", "|◀"))
                (button("back", "Back one shot (←)", "◀"))
                (button("play", "Play (space)", "▶ play"))
                (button("forward", "Forward one shot (→)", "▶"))
                (button("last", "After the last shot (End)", "▶|"))
                (button("line", "Next line of the algorithm (n)", "next line"))
            }
            input.shot type="range" min="0" max=(shots) value="0" step="1" aria-label="Shot";
            output.position aria-live="off" { "before the first shot" }
            label.speed { "speed" select aria-label="Speed" {
                option value="lines" { "line by line" }
                option value="1" { "1 shot a second" }
                option value="5" selected { "5 shots a second" }
                option value="25" { "25 shots a second" }
            } }
        }
    }
}

/// Renders an empty figure, which the scripts fill.
fn render_panel(name: &str, title: &str) -> Markup {
    html! { section.panel data-panel=(name) { h2 { (title) } div.content {} } }
}

/// Renders an algorithm with a button for each line that the picture can show.
fn render_algorithm(title: &str, steps: &[AlgorithmStep]) -> Markup {
    html! { section.panel data-panel="algorithm" {
        h2 { (title) }
        ol.algorithm { @for step in steps {
            li.inner[step.is_inner] data-line=[step.quantity] {
                @match step.quantity {
                    Some(quantity) => button type="button" data-show=(quantity) { (step.text) },
                    None => span { (step.text) },
                }
                @if step.rust.is_some() { span.files { @for place in [step.rust, step.wgsl].into_iter().flatten() {
                    code title=(format!("{}: fn {}", place.file, place.function)) { (file_name(place.file)) } " "
                } } }
            }
        } }
    } }
}
