//! `trace.html` of a solve to an error: the steps, and the links of a texel that is pointed at, as an offline page
//! ([`oracle::trace::links`]).
//!
//! [`data`] packs the arrays, and the scripts add to the viewer: `links_data.js` reads a step's links, `links_viewer.js` draws
//! those of a texel, `links_page.js` moves through steps and their parts and writes the numbers.

pub mod data;

use self::data::PackedStep;
use super::super::document::{Blocks, Row, Table, render_document};
use super::super::format::{count_noun, file_name, format_count, format_percent};
use super::super::solution_view::RenderedPreview;
use super::super::view::interpolation::{CarriedLight, InterpolationSurface};
use super::super::viewer::{SceneViewer, ViewerLayer, viewer_assets};
use super::algorithm::{AlgorithmStep, CodePlace};
use super::{MAX_PAGE_BYTES, SHARED_SCRIPTS, STYLE, describe_limit, render_algorithm, render_panel};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use common::shooting::RadiosityField;
use common::solution::Solution;
use maud::{Markup, PreEscaped, html};
use oracle::trace::TraceLimit;
use oracle::trace::links::{LinkTrace, TracedStep};

/// Maximum links from nodes to blocks of a record: 200 bytes each, of which a page takes about ten.
pub const MAX_RECORDED_LINKS: usize = 1 << 19;

const PAGE_SCRIPTS: [&str; 3] = [
    include_str!("links_data.js"),
    include_str!("links_viewer.js"),
    include_str!("links_page.js"),
];
const LINK_HELP: &str = "Keys: ← → steps, n next part. In the picture: drag to orbit, drag with Shift or the right button to pan, wheel or pinch to zoom; point at a texel or tap it; ↑ ↓, + −, [ ] exposure, 1 radiosity, 2 irradiance, g texels, f false colours, r.";

/// Parts of a step: name in the script, text of the button.
const STEP_PARTS: [(&str, &str); 3] = [
    ("direct", "direct light"),
    ("coarse", "coarse links"),
    ("final", "final gather"),
];

/// The page of a solve, and how many of its steps it has.
pub struct LinkPage {
    /// The file.
    pub html: String,
    /// Number of steps on the page.
    pub steps: usize,
    /// Number of steps of the solve.
    pub step_count: usize,
}

impl LinkPage {
    /// Renders the page of a solve with its record and the camera and exposure of its picture. If not all steps fit into
    /// [`MAX_PAGE_BYTES`] it has the first.
    pub fn new(solution: &Solution, trace: &LinkTrace, preview: &RenderedPreview) -> Self {
        let renderer = LinkPageRenderer { solution, trace };
        let elements = trace.steps.iter().map(|step| render_step(solution, step, preview));
        let mut shown = Vec::new();
        let mut bytes = renderer.render_page(&[]).len();
        for element in elements {
            bytes += element.0.len();
            if bytes > MAX_PAGE_BYTES {
                break;
            }
            shown.push(element);
        }
        Self {
            html: renderer.render_page(&shown),
            steps: shown.len(),
            step_count: trace.step_count,
        }
    }

    /// Returns a note if the page has not all steps.
    pub fn describe_missing_steps(&self) -> Option<String> {
        let limit = describe_limit(TraceLimit::Bytes);
        match self.steps {
            shown if shown == self.step_count => None,
            0 => Some(format!(
                "no trace.html is written, since not one step fits into {limit}: give fewer --texels or a larger --error"
            )),
            shown => Some(format!(
                "trace.html has the first {} of {}: more do not fit into {limit}; with fewer --texels or a larger --error they do",
                count_noun(shown, "step", "steps"),
                self.step_count,
            )),
        }
    }
}

struct LinkPageRenderer<'a> {
    solution: &'a Solution<'a>,
    trace: &'a LinkTrace,
}

impl LinkPageRenderer<'_> {
    /// Renders the page with the elements of its first steps.
    fn render_page(&self, steps: &[Markup]) -> String {
        let Solution { scene, adapter, .. } = *self.solution;
        let mut opening = Blocks::default();
        opening.add_remark(format!(
            "{}, solved on {} in {}, each on finer texels or to a smaller error. A face is a tree of nodes down to its texels. A \
             link carries light from a node to a receiver; a node is divided where one link would be less accurate than the step \
             asks for.",
            count_noun(scene.faces.len(), "face", "faces"),
            adapter.unwrap_or("the CPU"),
            count_noun(self.trace.step_count, "step", "steps"),
        ));
        if steps.len() < self.trace.step_count {
            opening.add_warning(format!(
                "This page has the first {} of {} steps: more do not fit into {}.",
                steps.len(),
                self.trace.step_count,
                describe_limit(TraceLimit::Bytes)
            ));
        }
        opening
            .add_element(html! {
                div.trace.links {
                    (render_player(steps.len()))
                    div.trace-columns {
                        div.trace-scene { @for (k, step) in steps.iter().enumerate() {
                            div.step data-step=(k + 1) hidden[k > 0] { (step) }
                        } }
                        div.trace-panels {
                            (render_panel("texel", "The links of this texel"))
                            (render_algorithm("A step of the method", &METHOD_STEPS))
                        }
                    }
                }
            })
            .add_table(self.tabulate_steps())
            .add_remark(
                "Links are counted from a node to a block of up to 16 receivers. w is rounded by 0.05 % at most (half floats).",
            )
            .add_element(viewer_assets(STYLE, &[&SHARED_SCRIPTS[..], &PAGE_SCRIPTS].concat()));
        let title = format!("{}, link by link", file_name(&scene.name));
        render_document(&title, &opening, &[], "")
    }

    fn tabulate_steps(&self) -> Table {
        let row = |(k, step): (usize, &TracedStep)| {
            let links = &step.links;
            let gathers = [&links.direct, &links.coarse, &links.fine].map(|gather| gather.link_count());
            let counts = [step.mesh.texels.len(), links.nodes.len()].into_iter().chain(gathers);
            let cells = [(k + 1).to_string(), format_percent(step.goal)];
            let counts = counts
                .chain([links.corrections])
                .map(|count| format_count(count as u64));
            Row::new(cells.into_iter().chain(counts))
        };
        Table::new(
            "step;to an error of;texels;nodes;links of direct light;coarse links;links of the final gather;corrections",
            self.trace.steps.iter().enumerate().map(row),
        )
    }
}

/// Renders the viewer of a step with its links.
fn render_step(solution: &Solution, step: &TracedStep, preview: &RenderedPreview) -> Markup {
    let (scene, mesh) = (solution.scene, &step.mesh);
    let irradiance = step.irradiance.iter().map(|h| h.extend(0.0)).collect::<Vec<_>>();
    let texels = mesh.texels.iter().zip(&step.irradiance);
    let radiosity = texels.map(|(texel, h)| (texel.emission + texel.reflectance * *h).extend(0.0));
    let field = RadiosityField {
        origin: solution.solver.into(),
        radiosity: radiosity.collect(),
        residual: Vec::new(),
        irradiance,
    };
    let surface = InterpolationSurface::new(scene, mesh);
    let viewer = SceneViewer {
        scene,
        surface: &surface,
        layers: vec![ViewerLayer {
            name: solution.solver,
            mesh,
            field: Some(&field),
        }],
        irradiance: true,
        carried: CarriedLight::Irradiance,
        texel_errors: None,
        camera: preview.camera,
        exposure: preview.exposure,
    };
    let packed = PackedStep::new(step);
    html! {
        (viewer.render_quantities(&[("radiosity", "radiosity B"), ("irradiance", "irradiance H")], LINK_HELP))
        script.links-head type="application/json" { (PreEscaped(packed.head.to_string())) }
        script.links-data type="text/plain" { (PreEscaped(STANDARD.encode(&packed.deflated))) }
    }
}

/// Renders the buttons of the steps and of their parts.
fn render_player(steps: usize) -> Markup {
    html! {
        div.player {
            span.buttons role="group" aria-label="Step" { @for step in 1..=steps {
                button type="button" data-go=(step) title="← →" { "step " (step) }
            } }
            span.buttons role="group" aria-label="Part of the step" { @for (part, text) in STEP_PARTS {
                button type="button" data-show=(part) title="next part: n" { (text) }
            } }
            output.position aria-live="off" {}
        }
    }
}

/// The parts of a step, and the functions that do them.
pub const METHOD_STEPS: [AlgorithmStep; 6] = [
    inner(
        "divide a node where a link’s error is above its threshold",
        Some(CodePlace {
            file: "cpu/src/hierarchy/refinement_steps.rs",
            function: "refine_by_source",
        }),
        Some(CodePlace {
            file: "gpu/src/shaders/refine.wgsl",
            function: "refine_by_source",
        }),
    ),
    inner(
        "else w ← F · V, by pairs of points",
        Some(CodePlace {
            file: "cpu/src/hierarchy/link.rs",
            function: "sample_links",
        }),
        Some(CodePlace {
            file: "gpu/src/shaders/sample_links.wgsl",
            function: "sample_links",
        }),
    ),
    part(
        "H_d ← K E: links from lamps to texels",
        "direct",
        "cpu/src/hierarchy/final_gather.rs",
        "refine_node",
    ),
    part(
        "x ← K ρ(H_d + x): links between coarse nodes, iterated",
        "coarse",
        "cpu/src/hierarchy/iterate.rs",
        "iterate_until",
    ),
    part(
        "H_f ← K ρ(H_d + x): final gather at texels",
        "final",
        "cpu/src/hierarchy/final_gather.rs",
        "refine_node",
    ),
    AlgorithmStep {
        text: "δ ← H_f − x, whose light is iterated and gathered in turn",
        is_inner: false,
        quantity: None,
        rust: Some(CodePlace {
            file: "cpu/src/hierarchy/defect_correction.rs",
            function: "correct_defects",
        }),
        wgsl: None,
    },
];

const fn inner(text: &'static str, rust: Option<CodePlace>, wgsl: Option<CodePlace>) -> AlgorithmStep {
    AlgorithmStep {
        text,
        is_inner: true,
        quantity: None,
        rust,
        wgsl,
    }
}

const fn part(text: &'static str, name: &'static str, file: &'static str, function: &'static str) -> AlgorithmStep {
    AlgorithmStep {
        text,
        is_inner: false,
        quantity: Some(name),
        rust: Some(CodePlace { file, function }),
        wgsl: None,
    }
}
