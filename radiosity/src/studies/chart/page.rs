//! Content of `chart.html`: per scene a chart, the fastest methods and all points.

use super::pareto::fastest_within;
use super::plot::draw_scene;
use super::points::{ChartPoint, MAX_REPEATED_SECONDS, SceneChart};
use super::{Measurement, SolverKind};
use crate::plan::memory_limit::format_bytes;
use crate::report::format::{format_count, format_duration, format_number, format_percent};
use crate::report::page::{Page, file_name, render_chart, scene_links};
use crate::report::table::{TableRow, number_cell, render_table, text_cell};
use maud::{Markup, html};

/// Error levels of the summary.
pub const ERROR_LEVELS: [f64; 3] = [0.05, 0.02, 0.01];
/// Column heads of the summary, one per level after the first.
const SUMMARY_HEADS: [&str; 4] = ["Solver", "Fastest to 5 %", "Fastest to 2 %", "Fastest to 1 %"];
const PAGE_STYLE: &str =
    "main{max-width:84rem}figure,figure.wide{max-width:none}.table td.o{min-width:15rem}tr.front td{font-weight:600}";

impl SceneChart {
    /// Returns the solvers that have points.
    pub fn measured_solvers(&self) -> Vec<SolverKind> {
        let has = |s: &SolverKind| self.points.iter().any(|p| p.method.solver == *s);
        let all = [SolverKind::Cpu, SolverKind::Gpu, SolverKind::Matrix];
        all.into_iter().filter(has).collect()
    }
}

/// Returns the fastest of a solver's points with at most this error.
pub fn fastest_point(study: &SceneChart, solver: SolverKind, error: f64) -> Option<&ChartPoint> {
    let of = |p: &&ChartPoint| p.method.solver == solver;
    let points: Vec<&ChartPoint> = study.points.iter().filter(of).collect();
    let places: Vec<(f64, f64)> = points.iter().map(|p| p.time_and_error()).collect();
    Some(points[fastest_within(&places, error)?])
}

/// Returns the page.
pub fn render_page(studies: &[SceneChart]) -> String {
    let sections = studies.iter().map(scene_section).collect();
    let names = studies.iter().map(|study| &study.scene).collect();
    let title = "Radiosity: speed against accuracy";
    page_of_scenes([title, PAGE_STYLE], explanation(), names, sections)
}

/// Returns a page with title and style, `head`, and a section for each scene.
pub fn page_of_scenes([title, style]: [&str; 2], head: Markup, names: Vec<&String>, sections: Vec<Markup>) -> String {
    let body = html! {
        (head)
        @for (k, (name, section)) in names.iter().zip(sections).enumerate() {
            section #{ "scene-" (k + 1) } { h2 { (file_name(name)) } (section) }
        }
    };
    let (bar, verdict) = (("Scenes", scene_links(names.into_iter())), html! {});
    Page {
        title,
        bar,
        verdict,
        style,
        body,
    }
    .to_html()
}

fn explanation() -> Markup {
    html! {
        p {
            "Each mark is one method: its time is mesh, engine and solve by wall clock, the median "
            "of its runs, which take turns; its error is the relative RMS of the reflected radiosity B − E against the "
            "truth, area-weighted, the worst channel. All compute the mean radiosity of the same texels: a solution "
            "on fewer is constant over each of them. A point is on the front when no other is both faster and more accurate. "
            "One parameter of the base is varied at a time, and a few together. Point at a mark to read its settings."
        }
    }
}

fn scene_section(study: &SceneChart) -> Markup {
    let n = study.texels;
    html! {
        p.facts {
            (format_count(study.faces as u64)) " faces, " (n) "×" (n) " texels on each · truth: " (study.truth)
            " · GPU: " (study.adapter.as_deref().unwrap_or("none"))
            @if study.software { " (software: the CPU draws; its times say nothing about a GPU)" }
        }
        @if study.missing > 0 {
            p.notes { (study.missing) " points were not measured: run it again with the same --out to continue." }
        }
        (render_chart(draw_scene(study).as_deref(), "Nothing measured.", html! {
            b { "Error against time" } " · down is more accurate, left is faster. A thin line through a mark goes from its "
            "fastest to its slowest run; above the dotted line are the failures with their times. The thick line at the "
            "foot is the truth."
        }))
        (winners_table(study))
        (points_table(study))
    }
}

fn winners_table(study: &SceneChart) -> Markup {
    let row = |solver: SolverKind| {
        let levels = ERROR_LEVELS.map(|level| {
            text_cell(html! {
                @match fastest_point(study, solver, level) {
                    Some(point) => {
                        b { (format_duration(point.median_seconds())) } " " code { (point.method.options) }
                        " (" (format_percent(point.time_and_error().1)) ")"
                    }
                    None => "none",
                }
            })
        });
        TableRow::new([text_cell(solver.name())].into_iter().chain(levels))
    };
    html! {
        h3 { "Fastest methods" }
        (render_table("cards", &SUMMARY_HEADS, study.measured_solvers().into_iter().map(row)))
    }
}

/// Table of all points by time, failed ones last.
fn points_table(study: &SceneChart) -> Markup {
    let mut points: Vec<&ChartPoint> = study.points.iter().collect();
    points.sort_by(|a, b| {
        let key = |p: &ChartPoint| (p.first_failure().is_some(), p.median_seconds());
        let ((fa, a), (fb, b)) = (key(a), key(b));
        fa.cmp(&fb).then(a.total_cmp(&b))
    });
    html! {
        h3 { "All points" }
        p.small {
            "Options are those that differ from the solver's base. Runs longer than " (format_number(MAX_REPEATED_SECONDS)) " s are not repeated. "
            "Prepare: mesh and engine. Bias: relative error of the mean. Imbalance: share of the emitted power that is not "
            "accounted for. Rays: at most, one per sample of each link. Memory: by the sizes of the records. Own: "
            "the error on the solve's own texels, if they are coarser. ★ front of all: no other is both faster and more "
            "accurate; ☆ front of its solver."
        }
        (render_table("table", &["", "Solver", "Options", "#Time|least – most", "#Prepare|+ solve", "#Error",
            "#Bias", "#Energy|imbalance", "#Shots|in passes", "#Rays|pixels", "#Memory"], points.into_iter().map(point_row)))
        @if !study.peers.is_empty() { (peers_table(study)) }
    }
}

fn point_row(point: &ChartPoint) -> TableRow {
    let [median, min, max] = point.median_and_range(Measurement::total_seconds);
    let part = |what: fn(&Measurement) -> f64| format_duration(point.median_and_range(what)[0]);
    let star = html! {
        @if point.on_front { span title="front" { "★" } }
        @else if point.on_solver_front { span title="front of its solver" { "☆" } }
    };
    let time = html! {
        (format_duration(median))
        @if point.runs.len() > 1 { br; span.facts { (format_duration(min)) " – " (format_duration(max)) } }
    };
    let mut cells = vec![
        text_cell(star),
        text_cell(point.method.solver.name()),
        text_cell(html! { code { (point.method.options) } }).with_class("o"),
        number_cell(time),
    ];
    match (point.first_figures(), point.first_failure()) {
        (Some(f), _) => cells.extend(
            [
                html! { (part(|m| m.prepare)) br; "+ " (part(|m| m.solve)) },
                html! {
                    (format_percent(f.error))
                    @if f.own_error != f.error { br; span.facts title="on its own, coarser texels" { "own " (format_percent(f.own_error)) } }
                },
                html! { (format_percent(f.bias)) },
                html! { (format_number(f.imbalance)) },
                html! { (format_count(f.shots)) br; span.facts { @if f.one_by_one { "one by one" } @else { (format_count(f.passes.into())) } } },
                html! {
                    @if point.rays_at_most > 0 { "≤ " (format_count(point.rays_at_most)) " rays" }
                    @if point.pixels > 0 { (format_count(point.pixels)) " pixels" }
                },
                html! { @if point.bytes > 0 { (format_bytes(point.bytes)) } @else { "–" } },
            ]
            .map(number_cell),
        ),
        (None, failure) => {
            let message = html! { span.fail { "■ " } (failure.unwrap_or_default()) };
            cells.push(text_cell(message).with_column_span(7));
        }
    }
    TableRow::new(cells).with_class_if(point.on_front, "front")
}

fn peers_table(study: &SceneChart) -> Markup {
    let rows = study.peers.iter().map(|peer| {
        TableRow::new([
            text_cell(peer.describe_peer()),
            number_cell(format_duration(peer.total_seconds())),
            number_cell(peer.setup_seconds.map_or("–".into(), format_duration)),
            number_cell(format_percent(peer.error)),
        ])
    });
    html! {
        h3 { "Other programs" }
        (render_table("", &["Program", "#Time", "#of it setup", "#Error"], rows))
    }
}
