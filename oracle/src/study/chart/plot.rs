//! Error against seconds, both logarithmic: axes by plotters, marks and legend upon them, so that
//! each mark can say what it is.

use super::labels::{Frame, Label, along, place};
use super::marks::{FAMILIES, PEERS, Shape, family};
use super::page::{about, short};
use super::study::{Point, Study};
use super::{Measurement, Solver};
use crate::show::chart::{Drawn, mesh, share, svg_of};
use crate::show::report::number::{number, percent};
use crate::study::converge::chart::ticks;
use maud::{Markup, PreEscaped, html};
use plotters::prelude::*;

/// CSS pixels; the page scales them.
const SIZE: (u32, u32) = (1040, 640);
/// The legend's share of the width.
const LEGEND: u32 = 190;
/// The height of the strips for what failed and for the paper's times, as a share of the axis.
const STRIP: f64 = 0.08;
/// The paper's Table 4, seconds: composites from … to …, and the references.
const COMPOSITE: [f64; 2] = [11.0, 24.0];
const REFERENCE: [f64; 2] = [34.0, 41.0];
const STYLE: &str = ".mark:hover path,.mark:focus path{stroke:currentColor;stroke-width:2.5;fill-opacity:1}\
    .mark path{stroke-linejoin:round}text{font:12px sans-serif;fill:currentColor}";

/// The axes' ranges and where they lie.
struct Plot {
    x: [f64; 2],
    y: [f64; 2],
    /// Without the strips.
    errors: [f64; 2],
    frame: Frame,
}

impl Plot {
    fn new(study: &Study) -> Self {
        let (points, peers) = (&study.points, &study.peers);
        let papers = if study.paper { &REFERENCE[1..] } else { &[] };
        let seconds = points.iter().map(Point::seconds);
        let seconds = seconds.chain(peers.iter().map(super::peers::Peer::waited));
        let x = range(
            seconds.chain(papers.iter().copied()),
            [0.7, 1.5],
            [0.1, 10.0],
        );
        let errors = points.iter().map(|p| p.place().1);
        let errors = range(
            errors.chain(peers.iter().map(|p| p.error)),
            [0.7, 1.4],
            [0.001, 1.0],
        );
        let strip = (errors[1] / errors[0]).powf(STRIP);
        let failed = points.iter().any(|p| p.failure().is_some());
        let [bottom, top] = [study.paper, failed].map(|has| if has { strip } else { 1.0 });
        Self {
            x,
            y: [errors[0] / bottom, errors[1] * top],
            errors,
            frame: [0.0; 4],
        }
    }

    /// The pixel of a place, moved onto the axes' ends where it lies beyond them.
    fn at(&self, (seconds, error): (f64, f64)) -> (f64, f64) {
        let part = |v: f64, [low, high]: [f64; 2]| {
            // What is not a number is slow and wrong.
            let v = if v.is_nan() { high } else { v.clamp(low, high) };
            (v / low).ln() / (high / low).ln()
        };
        let [left, top, right, bottom] = self.frame;
        let y = error.max(self.errors[0]);
        (
            left + part(seconds, self.x) * (right - left),
            bottom + part(y, self.y) * (top - bottom),
        )
    }

    /// Where a failure is marked: in the strip on top.
    fn failed(&self, seconds: f64) -> (f64, f64) {
        let between = (self.errors[1] * self.y[1]).sqrt();
        self.at((seconds, between))
    }
}

/// The least and the greatest above 0, with room around them.
fn range(values: impl Iterator<Item = f64>, room: [f64; 2], otherwise: [f64; 2]) -> [f64; 2] {
    let usable = values.filter(|v| v.is_finite() && *v > 0.0);
    let (low, high) = usable.fold((f64::INFINITY, 0.0f64), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        otherwise
    } else {
        [low * room[0], high * room[1]]
    }
}

/// The chart of a scene; none when there is nothing to draw.
pub fn svg(study: &Study) -> Option<String> {
    if study.points.is_empty() {
        return None;
    }
    let mut plot = Plot::new(study);
    let axes = svg_of(SIZE, |area| axes(area, &mut plot))?;
    let inner = html! {
        style { (PreEscaped(STYLE)) }
        (strips(study, &plot))
        (fronts(study, &plot))
        (marks(study, &plot))
        (labels(study, &plot))
        (legend(study))
    };
    let body = axes
        .strip_suffix("</svg>\n")
        .or(axes.strip_suffix("</svg>"))?;
    Some(format!("{body}{}</svg>", inner.into_string()))
}

fn axes(area: &crate::show::chart::Area, plot: &mut Plot) -> Drawn {
    let ([x0, x1], [y0, y1]) = (plot.x, plot.y);
    let x = (x0..x1).log_scale().with_key_points(ticks(x0, x1));
    let [least, most] = plot.errors;
    let y = (y0..y1).log_scale().with_key_points(ticks(least, most));
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .margin_right(LEGEND + 10)
        .x_label_area_size(44)
        .y_label_area_size(74)
        .build_cartesian_2d(x, y)?;
    mesh(
        &mut chart,
        "seconds: mesh, engine and solve (log)",
        "relative RMS of B − E (log)",
        &|x| number(*x),
        &share,
    )?;
    let (left, bottom) = chart.backend_coord(&(x0, y0));
    let (right, top) = chart.backend_coord(&(x1, y1));
    plot.frame = [left, top, right, bottom].map(f64::from);
    Ok(())
}

/// What failed is above this line; the paper's times stand below the other.
fn strips(study: &Study, plot: &Plot) -> Markup {
    let [left, top, right, bottom] = plot.frame;
    let line = |y: f64| {
        html! {
            path d=(format!("M{left} {y:.1}H{right}")) stroke="currentColor" stroke-opacity=".35" stroke-dasharray="2 4" fill="none" {}
        }
    };
    html! {
        @if plot.y[1] > plot.errors[1] {
            (line(plot.at((1.0, plot.errors[1])).1))
            text x=(left + 6.0) y=(top + 15.0) opacity=".7" { "failed" }
        }
        @if study.paper {
            @let y = bottom - 7.0;
            @let x = |seconds: f64| plot.at((seconds, plot.y[0])).0;
            (line(plot.at((1.0, plot.errors[0])).1))
            path d=(format!("M{:.1} {y}H{:.1}", x(COMPOSITE[0]), x(COMPOSITE[1]))) stroke="currentColor" stroke-width="6" stroke-opacity=".6" fill="none" {}
            @for seconds in REFERENCE {
                path d=(format!("M{:.1} {bottom}V{:.1}", x(seconds), bottom - 16.0)) stroke="currentColor" stroke-width="2.5" fill="none" {}
            }
            text x=(format!("{:.1}", x(COMPOSITE[0]) - 8.0)) y=(bottom - 5.0) text-anchor="end" {
                "the paper in 2006: composite 11–24 s, reference 34 and 41 s"
            }
        }
    }
}

/// Through the points of each solver's front, thin, and of all, thick.
fn fronts(study: &Study, plot: &Plot) -> Markup {
    let line = |on: &dyn Fn(&&Point) -> bool| {
        let corners = corners(study, plot, on).into_iter();
        let texts: Vec<String> = corners.map(|(x, y)| format!("{x:.1} {y:.1}")).collect();
        format!("M{}", texts.join("L"))
    };
    let solver = |of: Solver| line(&move |p| p.on_solver_front && p.method.solver == of);
    html! {
        @for (of, colour) in [(Solver::Cpu, "#2b7bba"), (Solver::Gpu, "#e07b00")] {
            @if study.points.iter().any(|p| p.on_solver_front && p.method.solver == of) {
                path d=(solver(of)) stroke=(colour) stroke-width="1.5" stroke-dasharray="6 4" fill="none" {}
            }
        }
        @if study.points.iter().any(|p| p.on_front) {
            path d=(line(&|p| p.on_front)) stroke="currentColor" stroke-opacity=".35" stroke-width="5" stroke-linejoin="round" fill="none" {}
        }
    }
}

/// Pixels of the points that are `on`, from the fastest.
fn corners(study: &Study, plot: &Plot, on: &dyn Fn(&&Point) -> bool) -> Vec<(f64, f64)> {
    let mut places: Vec<(f64, f64)> = study.points.iter().filter(on).map(Point::place).collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    places.into_iter().map(|place| plot.at(place)).collect()
}

fn place_of(point: &Point, plot: &Plot) -> (f64, f64) {
    match point.failure() {
        Some(_) => plot.failed(point.seconds()),
        None => plot.at(point.place()),
    }
}

/// What it was, not what was asked for.
fn shape(point: &Point) -> Shape {
    match point.figures() {
        None => Shape::Cross,
        Some(figures) if figures.one_by_one => Shape::of_single_shots(&point.method),
        Some(_) => Shape::of(&point.method),
    }
}

fn marks(study: &Study, plot: &Plot) -> Markup {
    html! {
        @for peer in &study.peers {
            g.mark {
                title { (peer.about()) "\n" (number(peer.waited())) " s, error " (percent(peer.error)) }
                path d=(Shape::Circle.path(plot.at((peer.waited(), peer.error)), 4.5)) fill=(PEERS.1) fill-opacity=".8" {}
            }
        }
        @for point in &study.points {
            @let (failed, shape) = (point.failure().is_some(), shape(point));
            @let size = if point.method.sweep == "base" { 8.0 } else { 5.0 };
            g.mark {
                title { (about(point)) }
                @if !failed { (whisker(point, plot)) }
                path d=(shape.path(place_of(point, plot), size)) fill=(family(&point.method).1) fill-opacity=".85"
                    stroke=[point.on_front.then_some("currentColor")] stroke-width="1.5" {}
            }
        }
    }
}

/// From the fastest run to the slowest.
fn whisker(point: &Point, plot: &Plot) -> Markup {
    let [_, least, most] = point.spread(Measurement::seconds);
    let (_, error) = point.place();
    let [(from, y), (to, _)] = [least, most].map(|seconds| plot.at((seconds, error)));
    html! {
        path d=(format!("M{from:.1} {y:.1}H{to:.1}")) stroke=(family(&point.method).1) stroke-width="1.5" fill="none" {}
    }
}

/// The bases and the front are named where there is room.
fn labels(study: &Study, plot: &Plot) -> Markup {
    let named = |p: &&Point| (p.on_front || p.method.sweep == "base") && p.failure().is_none();
    let wanted: Vec<(f64, f64, String)> = study
        .points
        .iter()
        .filter(named)
        .map(|p| (place_of(p, plot), short(p)))
        .map(|((x, y), text)| (x, y, text))
        .collect();
    let others = study.peers.iter().map(|p| plot.at((p.waited(), p.error)));
    let own = study.points.iter().map(|p| place_of(p, plot));
    let front = along(&corners(study, plot, &|p| p.on_front));
    let taken: Vec<(f64, f64)> = own.chain(others).chain(front).collect();
    let [left, top, right, _] = plot.frame;
    let area = [left, top, right, plot.at((1.0, plot.errors[0])).1];
    let labels: Vec<Label> = place(&wanted, area, &taken);
    html! {
        @for label in labels {
            text x=(format!("{:.1}", label.x)) y=(format!("{:.1}", label.y)) { (label.text) }
        }
    }
}

fn legend(study: &Study) -> Markup {
    let families = study.points.iter().map(|p| family(&p.method));
    let peers = study.peers.iter().map(|_| PEERS);
    let mut families: Vec<_> = families.chain(peers).collect();
    families.sort_by_key(|f| FAMILIES.iter().position(|name| *name == f.0));
    families.dedup();
    let used = |shape: &Shape| study.points.iter().any(|p| self::shape(p) == *shape);
    let shapes: Vec<Shape> = Shape::ALL.into_iter().filter(used).collect();
    let x = f64::from(SIZE.0 - LEGEND) + 14.0;
    let row = |k: usize| 30.0 + 21.0 * k as f64;
    let after = families.len() + 1;
    let lines = after + shapes.len() + 1;
    html! {
        @for (k, (name, colour)) in families.iter().enumerate() {
            path d=(Shape::Circle.path((x, row(k)), 6.0)) fill=(colour) {}
            text x=(x + 14.0) y=(row(k) + 4.0) { (name) }
        }
        @for (k, shape) in shapes.iter().enumerate() {
            path d=(shape.path((x, row(after + k)), 5.0)) fill="currentColor" fill-opacity=".6" {}
            text x=(x + 14.0) y=(row(after + k) + 4.0) { (shape.name()) }
        }
        path d=(format!("M{} {}h18", x - 8.0, row(lines))) stroke="currentColor" stroke-opacity=".35" stroke-width="5" {}
        text x=(x + 14.0) y=(row(lines) + 4.0) { "front of all" }
        path d=(format!("M{} {}h18", x - 8.0, row(lines + 1))) stroke="currentColor" stroke-dasharray="6 4" {}
        text x=(x + 14.0) y=(row(lines + 1) + 4.0) { "front of a solver" }
        path d=(Shape::Circle.path((x, row(lines + 2)), 8.0)) fill="currentColor" fill-opacity=".6" {}
        text x=(x + 14.0) y=(row(lines + 2) + 4.0) { "large: base" }
    }
}

/// All charts below each other, as a file of its own.
pub fn file(charts: &[(String, String)]) -> String {
    let (w, h) = (SIZE.0, SIZE.1 + 30);
    let all = h * charts.len().max(1) as u32;
    let parts = charts.iter().enumerate().map(|(k, (name, svg))| {
        let y = h * k as u32;
        let title = html! { text x="20" y=(y + 22) style="font:600 16px sans-serif" { (name) } };
        let inner = svg.replacen(
            "<svg ",
            &format!(
                r#"<svg y="{}" width="{}" height="{}" "#,
                y + 30,
                SIZE.0,
                SIZE.1
            ),
            1,
        );
        title.into_string() + &inner
    });
    let style = ":root{color:#1c1e21;background:#fff}@media(prefers-color-scheme:dark){:root{color:#e6e7e8;background:#202327}}text{fill:currentColor}";
    format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="{w}" height="{all}" viewBox="0 0 {w} {all}"><style>{style}</style>{}</svg>"#,
        parts.collect::<String>()
    )
}
