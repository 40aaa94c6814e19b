//! Error against seconds, both logarithmic.

use super::labels::{along, place};
use super::marks::{FAMILIES, Family, MATRIX, PEERS, SHAPES, family, shape};
use super::peers::Peer;
use super::study::{Point, Study};
use super::words::{about, short};
use super::{Measurement, Solver};
use crate::show::chart::{Axis, CPU, Frame, GPU, STYLE, Shape, line, path, px, share, ticks};
use crate::show::number::{number, percent};
use maud::{Markup, html};

/// CSS pixels; the page scales them.
const SIZE: (u32, u32) = (1040, 640);
/// The legend's share of the width.
const LEGEND: u32 = 190;
/// The height of the strips for what failed and for the paper's times, as a share of the axis.
const STRIP: f64 = 0.08;
/// The height of the truth's name, pixels.
const TRUTH: f64 = 18.0;
/// The paper's Table 4, seconds: composites from … to …, and the references.
const COMPOSITE: [f64; 2] = [11.0, 24.0];
const REFERENCE: [f64; 2] = [34.0, 41.0];

/// What is drawn, and where.
struct Plot<'a> {
    study: &'a Study,
    frame: &'a Frame<'a>,
    x: [f64; 2],
    y: [f64; 2],
    /// Without the strips.
    errors: [f64; 2],
}

impl Plot<'_> {
    /// The pixel of a place, moved onto the axes' ends where it lies beyond them.
    fn at(&self, (seconds, error): (f64, f64)) -> (f64, f64) {
        // What is not a number is slow and wrong.
        let within =
            |v: f64, [low, high]: [f64; 2]| if v.is_nan() { high } else { v.clamp(low, high) };
        let error = error.max(self.errors[0]);
        (
            self.frame.x(within(seconds, self.x)),
            self.frame.y(within(error, self.y)),
        )
    }

    /// The pixel of a point; what failed lies in the strip on top.
    fn place(&self, point: &Point) -> (f64, f64) {
        match point.failure() {
            Some(_) => self.at((point.seconds(), (self.errors[1] * self.y[1]).sqrt())),
            None => self.at(point.place()),
        }
    }

    fn peer(&self, peer: &Peer) -> (f64, f64) {
        self.at((peer.waited(), peer.error))
    }

    /// Pixels of the points that are `on`, from the fastest.
    fn corners(&self, on: impl Fn(&Point) -> bool) -> Vec<(f64, f64)> {
        let on = self.study.points.iter().filter(|p| on(p));
        let mut places: Vec<(f64, f64)> = on.map(Point::place).collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        places.into_iter().map(|place| self.at(place)).collect()
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
    let (points, peers) = (&study.points, &study.peers);
    let papers = if study.paper { &REFERENCE[1..] } else { &[] };
    let seconds = points.iter().map(Point::seconds);
    let seconds = seconds.chain(peers.iter().map(Peer::waited));
    let ends = range(
        seconds.chain(papers.iter().copied()),
        [0.7, 1.5],
        [0.1, 10.0],
    );
    let errors = points.iter().map(|p| p.place().1);
    let errors = errors.chain(peers.iter().map(|p| p.error));
    let errors = range(errors, [0.7, 1.4], [0.001, 1.0]);
    let strip = (errors[1] / errors[0]).powf(STRIP);
    let failed = points.iter().any(|p| p.failure().is_some());
    let [bottom, top] = [study.paper, failed].map(|has| if has { strip } else { 1.0 });
    let of_seconds = |x: &f64| number(*x);
    let x = Axis::log("seconds: mesh, engine and solve (log)", ends, &of_seconds);
    let y = Axis {
        ticks: Some(ticks(errors[0], errors[1])),
        ..Axis::log(
            "relative RMS of B − E (log)",
            [errors[0] / bottom, errors[1] * top],
            &share,
        )
    };
    crate::show::chart::svg(SIZE, LEGEND + 10, [&x, &y], |frame| {
        let plot = Plot {
            study,
            frame,
            x: x.ends,
            y: y.ends,
            errors,
        };
        html! { (strips(&plot)) (truth(&plot)) (fronts(&plot)) (marks(&plot)) (labels(&plot)) (legend(study)) }
    })
}

/// What failed is above this line; the paper's times stand below the other.
fn strips(plot: &Plot) -> Markup {
    let Frame {
        left,
        top,
        right,
        bottom,
        ..
    } = *plot.frame;
    let border = |error: f64| {
        let y = plot.frame.y(error);
        line(
            &path([(left, y), (right, y)]),
            "currentColor",
            1.0,
            0.35,
            Some("2 4"),
        )
    };
    let x = |seconds: f64| plot.at((seconds, plot.y[0])).0;
    html! {
        @if plot.y[1] > plot.errors[1] {
            (border(plot.errors[1]))
            text x=(left + 6.0) y=(top + 15.0) opacity=".7" { "failed" }
        }
        @if plot.study.paper {
            (border(plot.errors[0]))
            (line(&path(COMPOSITE.map(|s| (x(s), bottom - 7.0))), "currentColor", 6.0, 0.6, None))
            @for s in REFERENCE { (line(&path([(x(s), bottom), (x(s), bottom - 16.0)]), "currentColor", 2.5, 1.0, None)) }
            text x=(px(x(COMPOSITE[0]) - 8.0)) y=(bottom - 5.0) text-anchor="end" {
                "the paper in 2006: composite 11–24 s, reference 34 and 41 s"
            }
        }
    }
}

/// What all are judged by: its own error is 0, below any logarithmic axis, so it is the axis' foot.
fn truth(plot: &Plot) -> Markup {
    let Frame { left, right, .. } = *plot.frame;
    let y = plot.frame.y(plot.errors[0]);
    html! {
        (line(&path([(left, y), (right, y)]), "currentColor", 3.0, 0.55, None))
        text.over x=(left + 8.0) y=(px(y - TRUTH / 3.0)) { "▼ truth, error 0: " (plot.study.truth) }
    }
}

/// Through the points of each solver's front, thin, and of all, thick.
fn fronts(plot: &Plot) -> Markup {
    let solver = |of| plot.corners(|p| p.on_solver_front && p.method.solver == of);
    let all = plot.corners(|p| p.on_front);
    html! {
        @for (corners, colour) in [(solver(Solver::Cpu), CPU), (solver(Solver::Gpu), GPU)] {
            @if !corners.is_empty() { (line(&path(corners), colour, 1.5, 1.0, Some("6 4"))) }
        }
        @if !all.is_empty() { (line(&path(all), "currentColor", 5.0, 0.35, None)) }
    }
}

fn marks(plot: &Plot) -> Markup {
    html! {
        @for peer in &plot.study.peers {
            g.mark {
                title { (peer.about()) "\n" (number(peer.waited())) " s, error " (percent(peer.error)) }
                path d=(Shape::Circle.path(plot.peer(peer), 4.5)) fill=(PEERS.1) fill-opacity=".8" {}
            }
        }
        @for point in &plot.study.points {
            @let size = if point.method.sweep == "base" { 8.0 } else { 5.0 };
            g.mark {
                title { (about(point)) }
                @if point.failure().is_none() { (whisker(point, plot)) }
                @let (reference, colour) = (family(&point.method) == MATRIX, family(&point.method).1);
                path d=(shape(point).path(plot.place(point), size)) fill=(colour) fill-opacity=(if reference { 0.0 } else { 0.85 })
                    stroke=[(point.on_front || reference).then_some("currentColor")] stroke-width="1.5" {}
            }
        }
    }
}

/// From the fastest run to the slowest.
fn whisker(point: &Point, plot: &Plot) -> Markup {
    let [_, least, most] = point.spread(Measurement::seconds);
    let (_, error) = point.place();
    let ends = [least, most].map(|seconds| plot.at((seconds, error)));
    line(&path(ends), family(&point.method).1, 1.5, 1.0, None)
}

/// The bases and the front are named where there is room.
fn labels(plot: &Plot) -> Markup {
    let points = || plot.study.points.iter();
    let named = |p: &&Point| (p.on_front || p.method.sweep == "base") && p.failure().is_none();
    let wanted: Vec<(f64, f64, String)> = points()
        .filter(named)
        .map(|p| (plot.place(p), short(p)))
        .map(|((x, y), text)| (x, y, text))
        .collect();
    let own = points().map(|p| plot.place(p));
    let others = plot.study.peers.iter().map(|p| plot.peer(p));
    let front = along(&plot.corners(|p| p.on_front));
    let taken: Vec<(f64, f64)> = own.chain(others).chain(front).collect();
    let Frame {
        left, top, right, ..
    } = *plot.frame;
    let area = [left, top, right, plot.frame.y(plot.errors[0]) - TRUTH];
    html! {
        @for label in place(&wanted, area, &taken) { text x=(px(label.x)) y=(px(label.y)) { (label.text) } }
    }
}

fn legend(study: &Study) -> Markup {
    let points = || study.points.iter();
    let has = |of: &Family| {
        *of == PEERS && !study.peers.is_empty() || points().any(|p| family(&p.method) == *of)
    };
    let used = |of: &Shape| points().any(|p| shape(p) == *of);
    let dot = |shape: Shape, size: f64, (colour, opacity): (&str, &str)| {
        html! { path d=(shape.path((0.0, 0.0), size)) fill=(colour) fill-opacity=(opacity) {} }
    };
    let dash = |width, opacity, dashes| {
        let across = path([(-8.0, 0.0), (10.0, 0.0)]);
        line(&across, "currentColor", width, opacity, dashes)
    };
    let (ink, gap) = (("currentColor", ".6"), (html! {}, ""));
    let families = FAMILIES.iter().filter(|f| has(f));
    let families = families.map(|family| {
        let sample = match *family == MATRIX {
            true => html! {
                path d=(Shape::Circle.path((0.0, 0.0), 5.0)) fill="none" stroke="currentColor" stroke-width="1.5" {}
            },
            false => dot(Shape::Circle, 6.0, (family.1, "1")),
        };
        (sample, family.0)
    });
    let shapes = SHAPES.iter().filter(|(shape, _)| used(shape));
    let shapes = shapes.map(|(shape, name)| (dot(*shape, 5.0, ink), *name));
    let rows = families.chain([gap.clone()]).chain(shapes).chain([
        gap,
        (dash(5.0, 0.35, None), "front of all"),
        (dash(1.0, 1.0, Some("6 4")), "front of a solver"),
        (dot(Shape::Circle, 8.0, ink), "large: base"),
    ]);
    crate::show::chart::legend((f64::from(SIZE.0 - LEGEND) + 14.0, 30.0), 14.0, rows)
}

/// All charts below each other, as a file of its own.
pub fn file(charts: &[(String, String)]) -> String {
    let (w, h) = (SIZE.0, SIZE.1 + 30);
    let all = h * charts.len().max(1) as u32;
    let parts = charts.iter().enumerate().map(|(k, (name, svg))| {
        let y = h * k as u32;
        let title = html! { text x="20" y=(y + 22) style="font:600 16px sans-serif" { (name) } };
        let place = format!(
            r#"<svg y="{}" width="{}" height="{}" "#,
            y + 30,
            SIZE.0,
            SIZE.1
        );
        title.into_string() + &svg.replacen("<svg ", &place, 1)
    });
    let style = ":root{color:#1c1e21;background:#fff}@media(prefers-color-scheme:dark){:root{color:#e6e7e8;background:#202327}}text{fill:currentColor}";
    format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="{w}" height="{all}" viewBox="0 0 {w} {all}"><style>{style}{STYLE}</style>{}</svg>"#,
        parts.collect::<String>()
    )
}
