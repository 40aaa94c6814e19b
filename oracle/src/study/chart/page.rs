//! `chart.html`: a chart per scene, what wins, and every point.

use super::front::fastest;
use super::plot::svg;
use super::study::{LONG, Point, Study};
use super::{Measurement, Solver};
use crate::plan::fits::size;
use crate::show::number::{count, duration, number, percent};
use crate::show::page::{Page, chart, scenes, short, table};
use maud::{Markup, html};

/// Errors that the summary asks for.
pub const LEVELS: [f64; 3] = [0.05, 0.02, 0.01];
/// Of the summary: as many as there are levels.
const HEADS: [&str; 4] = [
    "Solver",
    "Fastest to 5 %",
    "Fastest to 2 %",
    "Fastest to 1 %",
];
const STYLE: &str = "main{max-width:84rem}figure,figure.wide{max-width:none}.table td.o{min-width:15rem}tr.front td{font-weight:600}";

impl Study {
    /// Who has points.
    pub fn solvers(&self) -> Vec<Solver> {
        let has = |s: &Solver| self.points.iter().any(|p| p.method.solver == *s);
        let all = [Solver::Cpu, Solver::Gpu, Solver::Matrix];
        all.into_iter().filter(has).collect()
    }
}

/// The fastest of a solver's points with at most this error.
pub fn winner(study: &Study, solver: Solver, error: f64) -> Option<&Point> {
    let of = |p: &&Point| p.method.solver == solver;
    let points: Vec<&Point> = study.points.iter().filter(of).collect();
    let places: Vec<(f64, f64)> = points.iter().map(|p| p.place()).collect();
    Some(points[fastest(&places, error)?])
}

/// The page.
pub fn html(studies: &[Study]) -> String {
    Page {
        title: "Radiosity: speed against accuracy",
        bar: ("Scenes", scenes(studies.iter().map(|study| &study.scene))),
        verdict: html! {},
        style: STYLE,
        body: html! {
            (explanation())
            @for (k, study) in studies.iter().enumerate() { (section(k, study)) }
        },
    }
    .html()
}

fn explanation() -> Markup {
    html! {
        p {
            "Each mark is one way to solve the scene: its time is what a user waits for (mesh, engine, solve), the median "
            "of its runs, which take turns; its error is the relative RMS of the reflected radiosity B − E against the "
            "truth, area-weighted, the worst channel. All are asked for the mean radiosity of the same texels: an answer "
            "on fewer is constant over each of them. A point is on the front when no other is both faster and more accurate. "
            "One parameter of the base is varied at a time, and a few together. Point at a mark to read its settings."
        }
    }
}

fn section(k: usize, study: &Study) -> Markup {
    let n = study.texels;
    html! {
        section #{ "scene-" (k + 1) } {
            h2 { (short(&study.scene)) }
            p.facts {
                (count(study.faces as u64)) " faces, asked for " (n) "×" (n) " texels on each · truth: " (study.truth)
                " · GPU: " (study.adapter.as_deref().unwrap_or("none"))
                @if study.software { " (software: the CPU draws; its times say nothing about a GPU)" }
            }
            @if study.missing > 0 {
                p.notes { (study.missing) " points were not measured: run it again with the same --out to continue." }
            }
            (chart(svg(study).as_deref(), "Nothing measured.", html! {
                b { "Error against time" } " · down is more accurate, left is faster. A thin line through a mark goes from its "
                "fastest to its slowest run; above the dotted line is what failed, and after what time. The thick line at the "
                "foot is the truth that all are judged by."
            }))
            (wins(study))
            (points(study))
        }
    }
}

fn wins(study: &Study) -> Markup {
    html! {
        h3 { "What wins" }
        (table("cards", &HEADS, html! {
            @for solver in study.solvers() { tr {
                td { (solver.name()) }
                @for level in LEVELS { td {
                    @match winner(study, solver, level) {
                        Some(point) => {
                            b { (duration(point.seconds())) } " " code { (point.method.options) }
                            " (" (percent(point.place().1)) ")"
                        }
                        None => "none",
                    }
                } }
            } }
        }))
    }
}

/// By time; what failed comes last.
fn points(study: &Study) -> Markup {
    let mut points: Vec<&Point> = study.points.iter().collect();
    points.sort_by(|a, b| {
        let key = |p: &Point| (p.failure().is_some(), p.seconds());
        let ((fa, a), (fb, b)) = (key(a), key(b));
        fa.cmp(&fb).then(a.total_cmp(&b))
    });
    html! {
        h3 { "All points" }
        p.small {
            "Options are those that differ from the solver's base. Runs longer than " (number(LONG)) " s are not repeated. "
            "Prepare: mesh and engine. Bias: how much too bright or too dark on the whole. Imbalance: emitted power that nothing "
            "accounts for. Rays: at most, one per sample of each link. Memory: by the sizes of the records, where it is kept. Own: "
            "the error on the solve's own texels, where they are coarser. ★ front of all: no other is both faster and more "
            "accurate; ☆ front of its solver."
        }
        (table("table", &["", "Solver", "Options", "#Time|least – most", "#Prepare|+ solve", "#Error",
            "#Bias", "#Energy|imbalance", "#Shots|in passes", "#Rays|pixels", "#Memory"], html! {
            @for point in points { (row(point)) }
        }))
        @if !study.peers.is_empty() { (peers(study)) }
    }
}

fn row(point: &Point) -> Markup {
    let [median, least, most] = point.spread(Measurement::seconds);
    let part = |what: fn(&Measurement) -> f64| duration(point.spread(what)[0]);
    html! { tr.front[point.on_front] {
        td {
            @if point.on_front { span title="front" { "★" } }
            @else if point.on_solver_front { span title="front of its solver" { "☆" } }
        }
        td { (point.method.solver.name()) }
        td.o { code { (point.method.options) } }
        td.n { (duration(median)) @if point.runs.len() > 1 { br; span.facts { (duration(least)) " – " (duration(most)) } } }
        @match (point.figures(), point.failure()) {
            (Some(f), _) => {
                td.n { (part(|m| m.prepare)) br; "+ " (part(|m| m.solve)) }
                td.n {
                    (percent(f.error))
                    @if f.own_error != f.error { br; span.facts title="on its own, coarser texels" { "own " (percent(f.own_error)) } }
                }
                td.n { (percent(f.bias)) }
                td.n { (number(f.imbalance)) }
                td.n { (count(f.shots)) br; span.facts { @if f.one_by_one { "one by one" } @else { (count(f.passes.into())) } } }
                td.n {
                    @if point.rays_at_most > 0 { "≤ " (count(point.rays_at_most)) " rays" }
                    @if point.pixels > 0 { (count(point.pixels)) " pixels" }
                }
                td.n { @if point.bytes > 0 { (size(point.bytes)) } @else { "–" } }
            }
            (None, failure) => { td colspan="7" { span.fail { "■ " } (failure.unwrap_or_default()) } }
        }
    } }
}

fn peers(study: &Study) -> Markup {
    html! {
        h3 { "Other programs" }
        (table("", &["Program", "#Time", "#of it setup", "#Error"], html! {
            @for peer in &study.peers { tr {
                td { (peer.about()) }
                td.n { (duration(peer.waited())) }
                td.n { (peer.setup_seconds.map_or("–".into(), duration)) }
                td.n { (percent(peer.error)) }
            } }
        }))
    }
}
