//! The chart of a scene: error against seconds, both axes logarithmic. A mark's colour shows solver and
//! visibility, its shape form factor or iteration.

use super::labels::{place_labels, sample_polyline};
use super::methods::{SolveMethod, option_values};
use super::peers::Peer;
use super::points::{ChartPoint, SceneChart};
use super::{Measurement, SolverKind};
use crate::plan::memory_limit::format_bytes;
use crate::report::chart::{
    Axis, CHART_STYLE, CPU_COLOUR, ChartFrame, GPU_COLOUR, MarkShape, draw_path, format_pixel, format_share,
    logarithmic_ticks, path_data,
};
use crate::report::format::{format_count, format_duration, format_number, format_percent};
use common::form_factor::FormFactor;
use common::settings::{ItemBufferProjection, Iteration};
use maud::{Markup, html};
use serde_json::Value;

/// Size of the chart, CSS pixels; the page scales it.
const CHART_SIZE: (u32, u32) = (1040, 640);
/// Width of the legend, CSS pixels.
const LEGEND_WIDTH: u32 = 190;
/// Height of the strips for failures and for the paper's times, as a share of the axis.
const STRIP_HEIGHT: f64 = 0.08;
/// Height of the truth's label, CSS pixels.
const TRUTH_LABEL_HEIGHT: f64 = 18.0;
/// Range of the composites' times in the paper's Table 4, seconds.
const COMPOSITE_SECONDS: [f64; 2] = [11.0, 24.0];
const REFERENCE_SECONDS: [f64; 2] = [34.0, 41.0];

/// Most characters of a label.
const MAX_LABEL_CHARS: usize = 38;

/// Name in the legend and CSS colour, distinguishable on white and on black.
pub type MarkFamily = (&'static str, &'static str);

/// Measurements of other programs.
pub const PEER_FAMILY: MarkFamily = ("other programs", "#828282");

/// The dense solver on fewer texels than the truth: outlined marks, no series of its own.
pub const DENSE_FAMILY: MarkFamily = ("matrix, fewer texels", "currentColor");

/// All families, in the legend's order.
pub const MARK_FAMILIES: [MarkFamily; 11] = [
    ("CPU, rays", "#2b7bba"),
    ("CPU, item buffer", "#19a3a8"),
    ("GPU, rays", "#7a4fd0"),
    ("GPU, stereographic", "#e07b00"),
    ("GPU, hemisphere", "#c4a000"),
    ("GPU, hemicube", "#b06ac8"),
    ("GPU, paper", "#9a6a4a"),
    DENSE_FAMILY,
    ("CPU, to an error", "#e8459c"),
    ("GPU, to an error", "#5f9e2f"),
    PEER_FAMILY,
];

/// Returns the family of a method by its solver and visibility.
pub fn mark_family(method: &SolveMethod) -> MarkFamily {
    if method.target_error.is_some() {
        return MARK_FAMILIES[if method.solver == SolverKind::Gpu { 9 } else { 8 }];
    }
    let drawing = method.settings.transport.visibility.item_buffer();
    MARK_FAMILIES[match (method.solver, drawing.map(|drawing| drawing.projection)) {
        (SolverKind::Cpu, None) => 0,
        (SolverKind::Cpu, Some(_)) => 1,
        (SolverKind::Gpu, None) => 2,
        (SolverKind::Gpu, Some(ItemBufferProjection::Stereographic(_))) => 3,
        (SolverKind::Gpu, Some(ItemBufferProjection::Hemisphere(_))) => 4,
        (SolverKind::Gpu, Some(ItemBufferProjection::Hemicube)) => 5,
        (SolverKind::Gpu, Some(ItemBufferProjection::Paper)) => 6,
        (SolverKind::Matrix, _) => 7,
    }]
}

/// Mark shapes and their names in the legend.
pub const SHAPE_LEGEND: [(MarkShape, &str); 6] = [
    (MarkShape::Circle, "polygon, cg"),
    (MarkShape::Square, "disc"),
    (MarkShape::Triangle, "paper's factor"),
    (MarkShape::Diamond, "southwell"),
    (MarkShape::DownTriangle, "other iteration"),
    (MarkShape::Cross, "failed: point at it"),
];

/// Returns a point's mark shape: by its form factor, or by its iteration if the form factor is
/// `polygon`. The iteration is the one that ran, not the one requested.
pub fn mark_shape(point: &ChartPoint) -> MarkShape {
    let (Some(figures), settings) = (point.first_figures(), &point.method.settings) else {
        return MarkShape::Cross;
    };
    match (settings.transport.form_factor, settings.schedule.iteration) {
        _ if point.method.solver == SolverKind::Matrix || point.method.target_error.is_some() => MarkShape::Circle,
        (FormFactor::Disc, _) => MarkShape::Square,
        (FormFactor::Paper, _) => MarkShape::Triangle,
        (FormFactor::Polygon, _) if figures.one_by_one => MarkShape::Diamond,
        (FormFactor::Polygon, Iteration::Cg) => MarkShape::Circle,
        (FormFactor::Polygon, Iteration::Southwell) => MarkShape::Diamond,
        (FormFactor::Polygon, _) => MarkShape::DownTriangle,
    }
}

/// The study drawn and its axes.
struct Plot<'a> {
    study: &'a SceneChart,
    frame: &'a ChartFrame<'a>,
    x: [f64; 2],
    y: [f64; 2],
    /// Error range without the strips.
    errors: [f64; 2],
}

impl Plot<'_> {
    /// Returns the pixel of (seconds, error), clamped to the axes.
    fn pixel_of(&self, (seconds, error): (f64, f64)) -> (f64, f64) {
        // NaN is drawn at the upper end.
        let within = |v: f64, [low, high]: [f64; 2]| if v.is_nan() { high } else { v.clamp(low, high) };
        let error = error.max(self.errors[0]);
        (
            self.frame.x_pixel(within(seconds, self.x)),
            self.frame.y_pixel(within(error, self.y)),
        )
    }

    /// Returns the pixel of a point; a failed one lies in the strip on top.
    fn point_pixel(&self, point: &ChartPoint) -> (f64, f64) {
        match point.first_failure() {
            Some(_) => self.pixel_of((point.median_seconds(), (self.errors[1] * self.y[1]).sqrt())),
            None => self.pixel_of(point.time_and_error()),
        }
    }

    fn peer_pixel(&self, peer: &Peer) -> (f64, f64) {
        self.pixel_of((peer.total_seconds(), peer.error))
    }

    /// Returns the pixels of the points that satisfy `on`, fastest first.
    fn front_pixels(&self, on: impl Fn(&ChartPoint) -> bool) -> Vec<(f64, f64)> {
        let on = self.study.points.iter().filter(|p| on(p));
        let mut places: Vec<(f64, f64)> = on.map(ChartPoint::time_and_error).collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        places.into_iter().map(|place| self.pixel_of(place)).collect()
    }
}

/// Lists settings in result.json, without the options `left_out`.
pub fn describe_settings(settings: &Value, left_out: &[&str]) -> String {
    let shown = option_values(settings).filter(|(name, _)| !left_out.contains(name));
    let words: Vec<String> = shown.map(|(name, value)| format!("{name} {value}")).collect();
    words.join(", ")
}

/// Returns the range of the positive values times `room`, or `otherwise` if there are none.
pub fn positive_range(values: impl Iterator<Item = f64>, room: [f64; 2], otherwise: [f64; 2]) -> [f64; 2] {
    let usable = values.filter(|v| v.is_finite() && *v > 0.0);
    let (low, high) = usable.fold((f64::INFINITY, 0.0f64), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        otherwise
    } else {
        [low * room[0], high * room[1]]
    }
}

/// Returns the chart of a scene, or none if it has no points.
pub fn draw_scene(study: &SceneChart) -> Option<String> {
    if study.points.is_empty() {
        return None;
    }
    let (points, peers) = (&study.points, &study.peers);
    let papers = if study.is_paper_room {
        &REFERENCE_SECONDS[1..]
    } else {
        &[]
    };
    let seconds = points.iter().map(ChartPoint::median_seconds);
    let seconds = seconds.chain(peers.iter().map(Peer::total_seconds));
    let ends = positive_range(seconds.chain(papers.iter().copied()), [0.7, 1.5], [0.1, 10.0]);
    let errors = points.iter().map(|p| p.time_and_error().1);
    let errors = errors.chain(peers.iter().map(|p| p.error));
    let errors = positive_range(errors, [0.7, 1.4], [0.001, 1.0]);
    let strip = (errors[1] / errors[0]).powf(STRIP_HEIGHT);
    let failed = points.iter().any(|p| p.first_failure().is_some());
    let [bottom, top] = [study.is_paper_room, failed].map(|has| if has { strip } else { 1.0 });
    let of_seconds = |x: &f64| format_number(*x);
    let x = Axis::logarithmic_scale("seconds: mesh, engine and solve (log)", ends, &of_seconds);
    let y = Axis {
        ticks: Some(logarithmic_ticks(errors[0], errors[1])),
        ..Axis::logarithmic_scale(
            "relative RMS of B − E (log)",
            [errors[0] / bottom, errors[1] * top],
            &format_share,
        )
    };
    crate::report::chart::render_svg(CHART_SIZE, LEGEND_WIDTH + 10, [&x, &y], |frame| {
        let plot = Plot {
            study,
            frame,
            x: x.ends,
            y: y.ends,
            errors,
        };
        html! { (draw_strips(&plot)) (draw_truth(&plot)) (draw_fronts(&plot)) (draw_marks(&plot)) (draw_labels(&plot)) (draw_legend(study)) }
    })
}

/// Draws the strip of failures on top and the strip of the paper's times at the foot.
fn draw_strips(plot: &Plot) -> Markup {
    let ChartFrame {
        left,
        top,
        right,
        bottom,
        ..
    } = *plot.frame;
    let border = |error: f64| {
        let y = plot.frame.y_pixel(error);
        draw_path(
            &path_data([(left, y), (right, y)]),
            "currentColor",
            1.0,
            0.35,
            Some("2 4"),
        )
    };
    let x = |seconds: f64| plot.pixel_of((seconds, plot.y[0])).0;
    html! {
        @if plot.y[1] > plot.errors[1] {
            (border(plot.errors[1]))
            text x=(left + 6.0) y=(top + 15.0) opacity=".7" { "failed" }
        }
        @if plot.study.is_paper_room {
            (border(plot.errors[0]))
            (draw_path(&path_data(COMPOSITE_SECONDS.map(|s| (x(s), bottom - 7.0))), "currentColor", 6.0, 0.6, None))
            @for s in REFERENCE_SECONDS { (draw_path(&path_data([(x(s), bottom), (x(s), bottom - 16.0)]), "currentColor", 2.5, 1.0, None)) }
            text x=(format_pixel(x(COMPOSITE_SECONDS[0]) - 8.0)) y=(bottom - 5.0) text-anchor="end" {
                "the paper in 2006: composite 11–24 s, reference 34 and 41 s"
            }
        }
    }
}

/// Draws the truth at the foot of the axis, since its error 0 has no place on a logarithmic one.
fn draw_truth(plot: &Plot) -> Markup {
    let ChartFrame { left, right, .. } = *plot.frame;
    let y = plot.frame.y_pixel(plot.errors[0]);
    html! {
        (draw_path(&path_data([(left, y), (right, y)]), "currentColor", 3.0, 0.55, None))
        text.over x=(left + 8.0) y=(format_pixel(y - TRUTH_LABEL_HEIGHT / 3.0)) { "▼ truth, error 0: " (plot.study.truth) }
    }
}

/// Draws the Pareto front of each solver (thin) and of all points (thick).
fn draw_fronts(plot: &Plot) -> Markup {
    let solver = |of| plot.front_pixels(|p| p.on_solver_front && p.method.solver == of);
    let all = plot.front_pixels(|p| p.on_front);
    html! {
        @for (corners, colour) in [(solver(SolverKind::Cpu), CPU_COLOUR), (solver(SolverKind::Gpu), GPU_COLOUR)] {
            @if !corners.is_empty() { (draw_path(&path_data(corners), colour, 1.5, 1.0, Some("6 4"))) }
        }
        @if !all.is_empty() { (draw_path(&path_data(all), "currentColor", 5.0, 0.35, None)) }
    }
}

fn draw_marks(plot: &Plot) -> Markup {
    html! {
        @for peer in &plot.study.peers {
            g.mark {
                title { (peer.describe_peer()) "\n" (format_number(peer.total_seconds())) " s, error " (format_percent(peer.error)) }
                path d=(MarkShape::Circle.outline_path(plot.peer_pixel(peer), 4.5)) fill=(PEER_FAMILY.1) fill-opacity=".8" {}
            }
        }
        @for point in &plot.study.points {
            @let size = if point.method.sweep == "base" { 8.0 } else { 5.0 };
            g.mark {
                title { (point_tooltip(point)) }
                @if point.first_failure().is_none() { (draw_whisker(point, plot)) }
                @let (reference, colour) = (mark_family(&point.method) == DENSE_FAMILY, mark_family(&point.method).1);
                path d=(mark_shape(point).outline_path(plot.point_pixel(point), size)) fill=(colour) fill-opacity=(if reference { 0.0 } else { 0.85 })
                    stroke=[(point.on_front || reference).then_some("currentColor")] stroke-width="1.5" {}
            }
        }
    }
}

/// Draws a line from the fastest run to the slowest.
fn draw_whisker(point: &ChartPoint, plot: &Plot) -> Markup {
    let [_, min, max] = point.median_and_range(Measurement::total_seconds);
    let (_, error) = point.time_and_error();
    let ends = [min, max].map(|seconds| plot.pixel_of((seconds, error)));
    draw_path(&path_data(ends), mark_family(&point.method).1, 1.5, 1.0, None)
}

/// Labels the bases and the front where there is room.
fn draw_labels(plot: &Plot) -> Markup {
    let points = || plot.study.points.iter();
    let named = |p: &&ChartPoint| (p.on_front || p.method.sweep == "base") && p.first_failure().is_none();
    let wanted: Vec<(f64, f64, String)> = points()
        .filter(named)
        .map(|p| (plot.point_pixel(p), point_label(p)))
        .map(|((x, y), text)| (x, y, text))
        .collect();
    let points_taken = points().map(|p| plot.point_pixel(p));
    let peers_taken = plot.study.peers.iter().map(|p| plot.peer_pixel(p));
    let front = sample_polyline(&plot.front_pixels(|p| p.on_front));
    let taken: Vec<(f64, f64)> = points_taken.chain(peers_taken).chain(front).collect();
    let ChartFrame { left, top, right, .. } = *plot.frame;
    let area = [
        left,
        top,
        right,
        plot.frame.y_pixel(plot.errors[0]) - TRUTH_LABEL_HEIGHT,
    ];
    html! {
        @for label in place_labels(&wanted, area, &taken) { text x=(format_pixel(label.x)) y=(format_pixel(label.y)) { (label.text) } }
    }
}

fn draw_legend(study: &SceneChart) -> Markup {
    let points = || study.points.iter();
    let has = |of: &MarkFamily| {
        *of == PEER_FAMILY && !study.peers.is_empty() || points().any(|p| mark_family(&p.method) == *of)
    };
    let used = |of: &MarkShape| points().any(|p| mark_shape(p) == *of);
    let dot = |shape: MarkShape, size: f64, (colour, opacity): (&str, &str)| {
        html! { path d=(shape.outline_path((0.0, 0.0), size)) fill=(colour) fill-opacity=(opacity) {} }
    };
    let dash = |width, opacity, dashes| {
        let across = path_data([(-8.0, 0.0), (10.0, 0.0)]);
        draw_path(&across, "currentColor", width, opacity, dashes)
    };
    let (ink, gap) = (("currentColor", ".6"), (html! {}, ""));
    let families = MARK_FAMILIES.iter().filter(|f| has(f));
    let families = families.map(|family| {
        let sample = match *family == DENSE_FAMILY {
            true => html! {
                path d=(MarkShape::Circle.outline_path((0.0, 0.0), 5.0)) fill="none" stroke="currentColor" stroke-width="1.5" {}
            },
            false => dot(MarkShape::Circle, 6.0, (family.1, "1")),
        };
        (sample, family.0)
    });
    let shapes = SHAPE_LEGEND.iter().filter(|(shape, _)| used(shape));
    let shapes = shapes.map(|(shape, name)| (dot(*shape, 5.0, ink), *name));
    let rows = families.chain([gap.clone()]).chain(shapes).chain([
        gap,
        (dash(5.0, 0.35, None), "front of all"),
        (dash(1.0, 1.0, Some("6 4")), "front of a solver"),
        (dot(MarkShape::Circle, 8.0, ink), "large: base"),
    ]);
    crate::report::chart::draw_legend((f64::from(CHART_SIZE.0 - LEGEND_WIDTH) + 14.0, 30.0), 14.0, rows)
}

/// Returns an SVG file with all charts below each other.
pub fn svg_file(charts: &[(String, String)]) -> String {
    let (w, h) = (CHART_SIZE.0, CHART_SIZE.1 + 30);
    let all = h * charts.len().max(1) as u32;
    let parts = charts.iter().enumerate().map(|(k, (name, svg))| {
        let y = h * k as u32;
        let title = html! { text x="20" y=(y + 22) style="font:600 16px sans-serif" { (name) } };
        let place = format!(
            r#"<svg y="{}" width="{}" height="{}" "#,
            y + 30,
            CHART_SIZE.0,
            CHART_SIZE.1
        );
        title.into_string() + &svg.replacen("<svg ", &place, 1)
    });
    let style = ":root{color:#1c1e21;background:#fff}@media(prefers-color-scheme:dark){:root{color:#e6e7e8;background:#202327}}text{fill:currentColor}";
    format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="{w}" height="{all}" viewBox="0 0 {w} {all}"><style>{style}{CHART_STYLE}</style>{}</svg>"#,
        parts.collect::<String>()
    )
}

/// Returns a point's label on the chart.
pub fn point_label(point: &ChartPoint) -> String {
    let text = format!(
        "{} {}",
        point.method.solver.name(),
        point.method.options.replace("--", "")
    );
    if text.chars().count() <= MAX_LABEL_CHARS {
        text
    } else {
        text.chars().take(MAX_LABEL_CHARS - 1).chain(['…']).collect()
    }
}

/// Formats the seconds with their spread.
fn format_seconds(point: &ChartPoint) -> String {
    let [median, min, max] = point.median_and_range(Measurement::total_seconds);
    match point.runs.len() {
        1 => format_duration(median),
        n => format!(
            "{} ({} – {}, {n} runs)",
            format_duration(median),
            format_duration(min),
            format_duration(max)
        ),
    }
}

/// Returns the tooltip of a mark.
pub fn point_tooltip(point: &ChartPoint) -> String {
    let mut lines = vec![format!("{} {}", point.method.solver.name(), point.method.options)];
    match (point.first_figures(), point.first_failure()) {
        (Some(figures), _) => {
            let (error, bias) = (format_percent(figures.error), format_percent(figures.bias));
            lines.push(format!("{}, error {error}, bias {bias}", format_seconds(point)));
            lines.push(format!(
                "{} shots in {} passes{}, {}",
                format_count(figures.shots),
                format_count(figures.passes.into()),
                if figures.one_by_one { " (one by one)" } else { "" },
                format_bytes(point.bytes)
            ));
        }
        (None, failure) => lines.push(format!(
            "failed after {}: {}",
            format_seconds(point),
            failure.unwrap_or_default()
        )),
    }
    let settings = serde_json::to_value(point.method.settings).unwrap_or_default();
    lines.push(describe_settings(&settings, &["quality", "max-shots"]));
    lines.join("\n")
}
