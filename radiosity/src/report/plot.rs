//! Plots as data: lines, marks, areas and notes over linear or logarithmic axes, rendered as inline SVG.
//!
//! plotters draws the axes; everything else is an element of its own, with a tooltip where it has one. An SVG needs no
//! files, fonts or network; text takes the page's colour. Whatever lies beyond an axis is drawn at its end.

use maud::{Markup, PreEscaped, html};
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::prelude::*;
use std::ops::Range;

/// Placeholder colour of text and axes, replaced by the page's own colour.
const INK_COLOUR: RGBColor = RGBColor(1, 2, 3);
/// Colour of CPU results.
pub const CPU_COLOUR: &str = "#2b7bba";
/// Colour of GPU results.
pub const GPU_COLOUR: &str = "#e07b00";
/// Colours of curves, distinguishable on white and on black; each goes with a mark of [`CURVE_MARKS`].
pub const CURVE_COLOURS: [&str; 8] = [
    CPU_COLOUR, GPU_COLOUR, "#2c9650", "#a05abe", "#b8860b", "#e8459c", "#19a3a8", "#828282",
];
/// Marks of curves, one per colour of [`CURVE_COLOURS`].
pub const CURVE_MARKS: [MarkShape; 8] = [
    MarkShape::Circle,
    MarkShape::Square,
    MarkShape::Triangle,
    MarkShape::Diamond,
    MarkShape::DownTriangle,
    MarkShape::Cross,
    MarkShape::Ring,
    MarkShape::Bar,
];
/// Style sheet of plots, inside a page or alone.
pub const PLOT_STYLE: &str = ".mark:hover path,.mark:focus path{stroke:currentColor;stroke-width:2.5;fill-opacity:1}\
    .mark path{stroke-linejoin:round}.upon text{font:12.5px sans-serif;fill:currentColor}\
    .over{paint-order:stroke;stroke:var(--card);stroke-width:3px;stroke-linejoin:round}";
/// Right margin of a plot whose legend is not beside it, CSS pixels.
const RIGHT_MARGIN: u32 = 24;
/// Height of a row of the legend, CSS pixels.
const LEGEND_ROW_HEIGHT: f64 = 20.0;
/// Least distance of names at curve ends, CSS pixels.
const NAME_HEIGHT: f64 = 17.0;
/// Maximum number of ticks of a linear axis.
const MAX_LINEAR_TICKS: f64 = 10.0;

/// Plot: axes, and what is drawn over them from back to front.
#[derive(Clone)]
pub struct Plot {
    /// Width and height in CSS pixels; a page scales them.
    pub size: [u32; 2],
    /// Horizontal and vertical axis.
    pub axes: [Axis; 2],
    /// Filled rectangles.
    pub areas: Vec<PlotArea>,
    /// Lines and marks.
    pub series: Vec<Series>,
    /// Texts.
    pub notes: Vec<PlotNote>,
    /// Place of the series' names.
    pub legend: Legend,
}

/// Place of the names of series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Legend {
    /// Nowhere.
    None,
    /// In the upper right corner of the plot.
    Inside,
    /// In a column of this width, CSS pixels.
    Beside(u32),
    /// Beside each series' last point, in a column of this width, CSS pixels.
    CurveEnds(u32),
}

/// Axis of a plot.
#[derive(Clone)]
pub struct Axis {
    /// Title.
    pub title: String,
    /// Lowest and highest value.
    pub ends: [f64; 2],
    /// True for a logarithmic scale.
    pub is_logarithmic: bool,
    /// Labelled values.
    pub ticks: Vec<(f64, String)>,
}

/// Rectangle; infinite coordinates are the axes' ends.
#[derive(Clone)]
pub struct PlotArea {
    /// Left and right end.
    pub x: [f64; 2],
    /// Lower and upper end.
    pub y: [f64; 2],
    /// CSS colour.
    pub colour: &'static str,
    /// Opacity, 0…1.
    pub opacity: f64,
}

/// Text at a point.
#[derive(Clone)]
pub struct PlotNote {
    /// Point in axis values.
    pub at: [f64; 2],
    /// Distance from that point in CSS pixels, right and down.
    pub shift: [f64; 2],
    /// SVG text anchor: start, middle or end.
    pub anchor: &'static str,
    /// Text.
    pub text: String,
}

/// Points joined by a line, marked, or both.
#[derive(Clone, Default)]
pub struct Series {
    /// Name in the legend; empty for none.
    pub name: String,
    /// CSS colour.
    pub colour: &'static str,
    /// Line through the points.
    pub line: Option<LineStyle>,
    /// Mark of each point.
    pub mark: Option<MarkStyle>,
    /// Points.
    pub points: Vec<PlotPoint>,
}

/// Style of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineStyle {
    /// Width in CSS pixels.
    pub width: f64,
    /// Opacity, 0…1.
    pub opacity: f64,
    /// SVG dash pattern.
    pub dashes: Option<&'static str>,
}

/// Style of a mark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarkStyle {
    /// Outline.
    pub shape: MarkShape,
    /// Radius in CSS pixels.
    pub radius: f64,
    /// Opacity of the filling, 0…1.
    pub opacity: f64,
    /// Colour of the outline.
    pub outline: Option<&'static str>,
}

/// Point of a series.
#[derive(Clone, Default)]
pub struct PlotPoint {
    /// Axis values.
    pub at: [f64; 2],
    /// Tooltip; empty for none.
    pub title: String,
    /// Name beside the mark, left out where there is no room; empty for none.
    pub label: String,
    /// True to leave the mark unfilled.
    pub is_hollow: bool,
    /// Ends of a horizontal line through the mark.
    pub whisker: Option<[f64; 2]>,
}

impl From<[f64; 2]> for PlotPoint {
    fn from(at: [f64; 2]) -> Self {
        Self { at, ..Self::default() }
    }
}

impl LineStyle {
    /// Creates the style of a solid, opaque line.
    pub fn with_width(width: f64) -> Self {
        Self {
            width,
            opacity: 1.0,
            dashes: None,
        }
    }
}

impl Series {
    /// Creates a line through points, without a name.
    pub fn through_points(
        colour: &'static str,
        line: LineStyle,
        points: impl IntoIterator<Item = impl Into<PlotPoint>>,
    ) -> Self {
        Self {
            colour,
            line: Some(line),
            points: points.into_iter().map(Into::into).collect(),
            ..Self::default()
        }
    }

    /// Draws a sample for a legend, about 24 pixels wide, centred at the origin.
    pub fn draw_sample(&self) -> Markup {
        html! {
            @if let Some(line) = &self.line { (draw_line(&[[-12.0, 0.0], [12.0, 0.0]], self.colour, line)) }
            @if let Some(mark) = &self.mark { (draw_mark(self.colour, mark, [0.0, 0.0], false)) }
        }
    }
}

impl Axis {
    /// Creates a linear axis with about ten ticks.
    pub fn linear_scale(title: impl Into<String>, ends: [f64; 2], label: impl Fn(f64) -> String) -> Self {
        let ticks = linear_ticks(ends).into_iter().map(|tick| (tick, label(tick)));
        Self {
            title: title.into(),
            ends,
            is_logarithmic: false,
            ticks: ticks.collect(),
        }
    }

    /// Creates a logarithmic axis with ticks at 1, 2 and 5 × 10ⁿ.
    pub fn logarithmic_scale(title: impl Into<String>, ends: [f64; 2], label: impl Fn(f64) -> String) -> Self {
        let ticks = logarithmic_ticks(ends).into_iter().map(|tick| (tick, label(tick)));
        Self {
            title: title.into(),
            ends,
            is_logarithmic: true,
            ticks: ticks.collect(),
        }
    }

    /// Returns whether the ends are in order and on the scale.
    fn is_drawable(&self) -> bool {
        let [low, high] = self.ends;
        low < high && high.is_finite() && low.is_finite() && (low > 0.0 || !self.is_logarithmic)
    }

    /// Returns the position of a value as a share of the axis; NaN lies at the upper end.
    fn axis_share(&self, value: f64) -> f64 {
        let [low, high] = self.ends;
        let value = if value.is_nan() { high } else { value.clamp(low, high) };
        if self.is_logarithmic {
            (value / low).ln() / (high / low).ln()
        } else {
            (value - low) / (high - low)
        }
    }

    /// Returns the label of the tick at a share of the axis.
    fn tick_label(&self, share: f64) -> String {
        let tick = self.ticks.iter().find(|(value, _)| self.axis_share(*value) == share);
        tick.map_or(String::new(), |(_, label)| label.clone())
    }
}

/// plotters' scale of shares 0…1 with ticks at given ones.
struct UnitScale(Vec<f64>);

impl Ranged for UnitScale {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, share: &f64, (low, high): (i32, i32)) -> i32 {
        low + (share * f64::from(high - low)).round() as i32
    }

    fn key_points<H: KeyPointHint>(&self, hint: H) -> Vec<f64> {
        match hint.weight().allow_light_points() {
            true => Vec::new(),
            false => self.0.clone(),
        }
    }

    fn range(&self) -> Range<f64> {
        0.0..1.0
    }
}

/// Returns round numbers between two ends, at most about ten.
fn linear_ticks([low, high]: [f64; 2]) -> Vec<f64> {
    let least_step = (high - low) / MAX_LINEAR_TICKS;
    if !(least_step > 0.0 && least_step.is_finite()) {
        return Vec::new();
    }
    let decade = 10f64.powf(least_step.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|m| m * decade);
    let step = steps.into_iter().find(|step| *step >= least_step).unwrap_or(least_step);
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    // Adding 0.0 avoids −0.
    (first..=last).map(|k| k as f64 * step + 0.0).collect()
}

/// Returns logarithmic ticks: 1, 2 and 5 × 10ⁿ, or powers of ten alone over more than four decades.
pub fn logarithmic_ticks([low, high]: [f64; 2]) -> Vec<f64> {
    if !(low > 0.0 && high.is_finite()) {
        return Vec::new();
    }
    let decades = (high / low).log10();
    let steps: &[f64] = if decades > 4.0 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    // Parsed from text, so that each tick is the number nearest to its label.
    let all = (first..=last).flat_map(|n| steps.iter().filter_map(move |m| format!("{m}e{n}").parse().ok()));
    all.filter(|t| (low..=high).contains(t)).collect()
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

/// Formats a share in per cent for an axis.
pub fn format_share(y: f64) -> String {
    let digits = (-(100.0 * y).log10().floor()).clamp(0.0, 10.0) as usize;
    format!("{:.digits$} %", 100.0 * y)
}

/// Returns an SVG file with all plots below each other, each with its title.
pub fn svg_file(plots: &[(String, Plot)]) -> String {
    const TITLE_HEIGHT: u32 = 30;
    let width = plots.iter().map(|(_, plot)| plot.size[0]).max().unwrap_or(1);
    let mut height = 0;
    let mut parts = String::new();
    for (name, plot) in plots {
        let Some(svg) = plot.render_svg() else { continue };
        let title = html! { text x="20" y=(height + 22) style="font:600 16px sans-serif" { (name) } };
        let place = format!(
            "<svg y=\"{}\" width=\"{}\" height=\"{}\" ",
            height + TITLE_HEIGHT,
            plot.size[0],
            plot.size[1]
        );
        parts += &title.into_string();
        parts += &svg.replacen("<svg ", &place, 1);
        height += TITLE_HEIGHT + plot.size[1];
    }
    let style = ":root{color:#1c1e21;background:#fff}@media(prefers-color-scheme:dark){:root{color:#e6e7e8;background:#202327}}text{fill:currentColor}";
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\"><style>{style}{PLOT_STYLE}</style>{parts}</svg>"
    )
}

/// Drawing area of a plot in CSS pixels.
struct PlotFrame<'a> {
    plot: &'a Plot,
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

impl Plot {
    /// Renders the plot as an SVG element; none if there is nothing to draw.
    pub fn render_svg(&self) -> Option<String> {
        let is_empty = self.areas.is_empty() && self.series.iter().all(|series| series.points.is_empty());
        if is_empty || !self.axes.iter().all(Axis::is_drawable) {
            return None;
        }
        let mut text = String::new();
        let [left, top, right, bottom] = self.draw_axes(&mut text)?;
        let frame = PlotFrame {
            plot: self,
            left,
            top,
            right,
            bottom,
        };
        let axes = &text[text.find('>')? + 1..text.rfind("</svg>")?];
        let axes = axes.replace("#010203", "currentColor");
        let [w, h] = self.size;
        let svg = html! {
            svg role="img" class="chart" viewBox=(format!("0 0 {w} {h}")) {
                (PreEscaped(axes))
                g.upon {
                    @for area in &self.areas { (frame.draw_area(area)) }
                    @for series in &self.series { (frame.draw_curve(series)) }
                    @for series in &self.series { (frame.draw_points(series)) }
                    @for note in &self.notes { (frame.draw_note(note)) }
                    (frame.draw_labels())
                    (frame.draw_legend())
                }
            }
        };
        Some(svg.into_string())
    }

    /// Draws axes, titles and a faint grid; returns left, top, right and bottom of the drawing area.
    fn draw_axes(&self, text: &mut String) -> Option<[f64; 4]> {
        let right = match self.legend {
            Legend::Beside(width) | Legend::CurveEnds(width) => width,
            Legend::None | Legend::Inside => RIGHT_MARGIN,
        };
        let [x, y] = self.axes.each_ref().map(|axis| {
            let ticks = axis
                .ticks
                .iter()
                .filter(|(value, _)| *value >= axis.ends[0] && *value <= axis.ends[1]);
            let ticks: Vec<f64> = ticks.map(|(value, _)| axis.axis_share(*value)).collect();
            UnitScale(ticks)
        });
        let [x_axis, y_axis] = &self.axes;
        let area = SVGBackend::with_string(text, (self.size[0], self.size[1])).into_drawing_area();
        let mut chart = ChartBuilder::on(&area)
            .margin(10)
            .margin_right(right)
            .x_label_area_size(44)
            .y_label_area_size(78)
            .build_cartesian_2d(x, y)
            .ok()?;
        chart
            .configure_mesh()
            .x_desc(&x_axis.title)
            .y_desc(&y_axis.title)
            .x_label_formatter(&|share| x_axis.tick_label(*share))
            .y_label_formatter(&|share| y_axis.tick_label(*share))
            .axis_style(INK_COLOUR.mix(0.7))
            .bold_line_style(INK_COLOUR.mix(0.15))
            .light_line_style(INK_COLOUR.mix(0.04))
            .axis_desc_style(("sans-serif", 15).into_font().color(&INK_COLOUR))
            .label_style(("sans-serif", 13).into_font().color(&INK_COLOUR))
            .draw()
            .ok()?;
        let (left, bottom) = chart.backend_coord(&(0.0, 0.0));
        let (right, top) = chart.backend_coord(&(1.0, 1.0));
        area.present().ok()?;
        Some([left, top, right, bottom].map(f64::from))
    }
}

impl PlotFrame<'_> {
    /// Returns the pixel of a point in axis values.
    fn pixel_at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [x_axis, y_axis] = &self.plot.axes;
        [
            self.left + x_axis.axis_share(x) * (self.right - self.left),
            self.bottom + y_axis.axis_share(y) * (self.top - self.bottom),
        ]
    }

    /// Returns the pixels of a series' points.
    fn series_pixels(&self, series: &Series) -> Vec<[f64; 2]> {
        series.points.iter().map(|point| self.pixel_at(point.at)).collect()
    }

    fn draw_area(&self, area: &PlotArea) -> Markup {
        let [left, bottom] = self.pixel_at([area.x[0], area.y[0]]);
        let [right, top] = self.pixel_at([area.x[1], area.y[1]]);
        html! {
            rect x=(format_pixel(left)) y=(format_pixel(top)) width=(format_pixel((right - left).max(0.0)))
                height=(format_pixel((bottom - top).max(0.0))) fill=(area.colour) fill-opacity=(area.opacity) {}
        }
    }

    fn draw_curve(&self, series: &Series) -> Markup {
        html! {
            @if let Some(line) = series.line.as_ref().filter(|_| !series.points.is_empty()) {
                (draw_line(&self.series_pixels(series), series.colour, line))
            }
        }
    }

    fn draw_points(&self, series: &Series) -> Markup {
        let Some(mark) = &series.mark else {
            return html! {};
        };
        let draw_point = |point: &PlotPoint| {
            let whisker = point.whisker.map(|ends| ends.map(|x| self.pixel_at([x, point.at[1]])));
            html! {
                @if let Some(ends) = whisker { (draw_line(&ends, series.colour, &LineStyle::with_width(1.5))) }
                (draw_mark(series.colour, mark, self.pixel_at(point.at), point.is_hollow))
            }
        };
        html! {
            @for point in &series.points {
                @if point.title.is_empty() { (draw_point(point)) }
                @else { g.mark { title { (point.title) } (draw_point(point)) } }
            }
        }
    }

    fn draw_note(&self, note: &PlotNote) -> Markup {
        let [x, y] = self.pixel_at(note.at);
        let [x, y] = [x + note.shift[0], y + note.shift[1]].map(format_pixel);
        html! { text.over x=(x) y=(y) text-anchor=(note.anchor) { (note.text) } }
    }

    /// Writes the labels of points where they cover neither marks nor lines nor each other.
    fn draw_labels(&self) -> Markup {
        let mut taken: Vec<[f64; 2]> = Vec::new();
        let mut wanted = Vec::new();
        for series in &self.plot.series {
            let pixels = self.series_pixels(series);
            let labelled = series
                .points
                .iter()
                .zip(&pixels)
                .filter(|(point, _)| !point.label.is_empty());
            wanted.extend(labelled.map(|(point, at)| (*at, point.label.as_str())));
            if series.line.is_some() {
                taken.extend(sample_polyline(&pixels));
            }
            taken.extend(pixels);
        }
        let area = [self.left, self.top, self.right, self.bottom];
        html! {
            @for ([x, y], text) in place_labels(&wanted, area, &taken) {
                text x=(format_pixel(x)) y=(format_pixel(y)) { (text) }
            }
        }
    }

    fn draw_legend(&self) -> Markup {
        let [x, y] = match self.plot.legend {
            Legend::None => return html! {},
            Legend::CurveEnds(_) => return self.draw_names(),
            Legend::Inside => [self.right - 160.0, self.top + 16.0],
            Legend::Beside(width) => [f64::from(self.plot.size[0] - width) + 24.0, 30.0],
        };
        let named = self.plot.series.iter().filter(|series| !series.name.is_empty());
        html! {
            @for (k, series) in named.enumerate() {
                g transform=(format!("translate({x:.1} {:.1})", y + LEGEND_ROW_HEIGHT * k as f64)) {
                    (series.draw_sample()) text x="18" y="4" { (series.name) }
                }
            }
        }
    }

    /// Writes the series' names beside their last points, moved apart where they overlap.
    fn draw_names(&self) -> Markup {
        let named = self.plot.series.iter().filter(|series| !series.name.is_empty());
        let mut ends: Vec<(&Series, [f64; 2])> = named
            .filter_map(|series| Some((series, self.pixel_at(series.points.last()?.at))))
            .collect();
        ends.sort_by(|a, b| a.1[1].total_cmp(&b.1[1]));
        let heights: Vec<f64> = ends.iter().map(|(_, at)| at[1]).collect();
        let heights = spread_heights(&heights, [self.top + NAME_HEIGHT / 2.0, self.bottom]);
        let right = self.right;
        html! {
            @for ((series, [x, y]), at) in ends.iter().zip(heights) {
                @let leader = LineStyle { opacity: 0.6, ..LineStyle::with_width(1.0) };
                (draw_line(&[[x + 8.0, *y], [right + 6.0, at], [right + 14.0, at]], series.colour, &leader))
                @if let Some(mark) = &series.mark { (draw_mark(series.colour, mark, [right + 20.0, at], false)) }
                text x=(format_pixel(right + 29.0)) y=(format_pixel(at + 4.0)) { (series.name) }
            }
        }
    }
}

/// Moves rising positions at least [`NAME_HEIGHT`] apart, within `top` and `bottom`.
fn spread_heights(wanted: &[f64], [top, bottom]: [f64; 2]) -> Vec<f64> {
    let mut at: Vec<f64> = Vec::new();
    for y in wanted {
        let least = at.last().map_or(top, |last| last + NAME_HEIGHT);
        at.push(y.max(least));
    }
    let mut limit = bottom;
    for y in at.iter_mut().rev() {
        *y = y.min(limit);
        limit = *y - NAME_HEIGHT;
    }
    at
}

/// Width of a wide letter of the labels' font, pixels.
const LETTER_WIDTH: f64 = 6.4;
/// Height of a label, pixels.
const LABEL_HEIGHT: f64 = 13.0;
/// Distance from a mark to its label, pixels.
const LABEL_GAP: f64 = 9.0;
/// Half the side of the square that a mark occupies, pixels.
const MARK_HALF_WIDTH: f64 = 5.0;

/// Places each text of `wanted` beside its mark, trying below left first, where a Pareto front has no points; returns
/// the left ends of the baselines. A label that would leave `area` or cover another or one of `marks` is left out.
fn place_labels<'a>(wanted: &[([f64; 2], &'a str)], area: [f64; 4], marks: &[[f64; 2]]) -> Vec<([f64; 2], &'a str)> {
    let half = MARK_HALF_WIDTH;
    let mut taken: Vec<[f64; 4]> = marks
        .iter()
        .map(|[x, y]| [x - half, y - half, x + half, y + half])
        .collect();
    let mut placed = Vec::new();
    for ([x, y], text) in wanted {
        let width = LETTER_WIDTH * text.chars().count() as f64;
        let (left, right) = (x - LABEL_GAP - width, x + LABEL_GAP);
        let (above, below) = (y - LABEL_GAP, y + LABEL_GAP + 0.8 * LABEL_HEIGHT);
        let beside = y + 0.3 * LABEL_HEIGHT;
        let places = [
            [left, below],
            [left, beside],
            [right, below],
            [x - width / 2.0, below + 2.0],
            [right, beside],
            [left, above],
            [right, above],
        ];
        let label_box = |[x, y]: [f64; 2]| [x, y - 0.8 * LABEL_HEIGHT, x + width, y + 0.2 * LABEL_HEIGHT];
        let is_free = |place: &[f64; 2]| {
            let own = label_box(*place);
            let inside = own[0] >= area[0] && own[1] >= area[1] && own[2] <= area[2] && own[3] <= area[3];
            inside && !taken.iter().any(|other| boxes_overlap(own, *other))
        };
        if let Some(place) = places.into_iter().find(is_free) {
            taken.push(label_box(place));
            placed.push((place, *text));
        }
    }
    placed
}

/// Returns whether two boxes (left, top, right, bottom) overlap.
fn boxes_overlap(a: [f64; 4], b: [f64; 4]) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// Samples a polyline so densely that no label fits between two samples.
fn sample_polyline(corners: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let part = |ends: &[[f64; 2]]| {
        let [[x, y], [to_x, to_y]] = [ends[0], ends[1]];
        let steps = ((to_x - x).hypot(to_y - y) / MARK_HALF_WIDTH).ceil().max(1.0) as usize;
        (0..=steps).map(move |k| {
            let t = k as f64 / steps as f64;
            [x + t * (to_x - x), y + t * (to_y - y)]
        })
    };
    corners.windows(2).flat_map(part).collect()
}

/// Formats a pixel coordinate for SVG.
fn format_pixel(x: f64) -> String {
    format!("{x:.1}")
}

/// Returns SVG path data through pixels.
fn path_data(pixels: &[[f64; 2]]) -> String {
    let points: Vec<String> = pixels.iter().map(|[x, y]| format!("{x:.1} {y:.1}")).collect();
    format!("M{}", points.join("L"))
}

fn draw_line(pixels: &[[f64; 2]], colour: &str, line: &LineStyle) -> Markup {
    html! {
        path d=(path_data(pixels)) stroke=(colour) stroke-width=(line.width) stroke-opacity=(line.opacity)
            stroke-dasharray=[line.dashes] stroke-linejoin="round" fill="none" {}
    }
}

fn draw_mark(colour: &str, mark: &MarkStyle, at: [f64; 2], is_hollow: bool) -> Markup {
    let (fill, opacity) = if is_hollow {
        ("var(--card)", 1.0)
    } else {
        (colour, mark.opacity)
    };
    let outline = mark.outline.or(is_hollow.then_some(colour));
    html! {
        path d=(mark.shape.outline_path(at, mark.radius)) fill=(fill) fill-opacity=(opacity) stroke=[outline]
            stroke-width=[outline.map(|_| "1.5")] {}
    }
}

/// Outline of a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkShape {
    /// ●
    Circle,
    /// ■
    Square,
    /// ▲
    Triangle,
    /// ◆
    Diamond,
    /// ▼
    DownTriangle,
    /// ✖
    Cross,
    /// ○, a filled ring.
    Ring,
    /// ▬
    Bar,
}

impl MarkShape {
    /// Returns SVG path data of the mark with radius `r` about (x, y).
    pub fn outline_path(self, at: impl Into<[f64; 2]>, r: f64) -> String {
        let [x, y] = at.into();
        let corners: &[[f64; 2]] = match self {
            Self::Circle => return circle_path([x, y], r, 0),
            // The hole has the opposite orientation.
            Self::Ring => return circle_path([x, y], 1.1 * r, 0) + &circle_path([x, y], 0.5 * r, 1),
            Self::Bar => &[[-1.3, -0.5], [1.3, -0.5], [1.3, 0.5], [-1.3, 0.5]],
            Self::Square => &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
            Self::Triangle => &[[0.0, -1.2], [1.1, 0.8], [-1.1, 0.8]],
            Self::Diamond => &[[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]],
            Self::DownTriangle => &[[0.0, 1.2], [1.1, -0.8], [-1.1, -0.8]],
            Self::Cross => &[
                [0.0, -0.3],
                [0.7, -1.0],
                [1.0, -0.7],
                [0.3, 0.0],
                [1.0, 0.7],
                [0.7, 1.0],
                [0.0, 0.3],
                [-0.7, 1.0],
                [-1.0, 0.7],
                [-0.3, 0.0],
                [-1.0, -0.7],
                [-0.7, -1.0],
            ],
        };
        let corners: Vec<[f64; 2]> = corners.iter().map(|[i, j]| [x + i * r, y + j * r]).collect();
        path_data(&corners) + "Z"
    }
}

fn circle_path([x, y]: [f64; 2], r: f64, turn: u8) -> String {
    let (left, across) = (x - r, 2.0 * r);
    format!("M{left:.1} {y:.1}a{r} {r} 0 1 {turn} {across} 0a{r} {r} 0 1 {turn} -{across} 0Z")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_plot(series: Vec<Series>) -> Plot {
        Plot {
            size: [400, 300],
            axes: [
                Axis::linear_scale("x <m>", [0.0, 1.0], |x| format!("{x:.1}")),
                Axis::logarithmic_scale("y", [1e-3, 1.0], format_share),
            ],
            areas: Vec::new(),
            series,
            notes: Vec::new(),
            legend: Legend::CurveEnds(80),
        }
    }

    #[test]
    fn values_beyond_axes_are_drawn_at_their_ends() {
        let mark = MarkStyle {
            shape: MarkShape::Circle,
            radius: 4.0,
            opacity: 1.0,
            outline: None,
        };
        let points = [[0.5, f64::NAN], [f64::INFINITY, 1e9], [-7.0, 0.0]];
        let point = |at: [f64; 2]| PlotPoint {
            title: "a & b".into(),
            ..at.into()
        };
        let series = Series {
            name: "one".into(),
            colour: CPU_COLOUR,
            mark: Some(mark),
            points: points.map(point).into(),
            ..Series::default()
        };
        let svg = unit_plot(vec![series]).render_svg().unwrap();
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert_eq!(svg.matches("<g class=\"mark\"><title>a &amp; b</title>").count(), 3);
        assert!(svg.contains("x &lt;m&gt;") && svg.contains(">one</text>") && svg.contains("0.1 %"));
    }

    #[test]
    fn nothing_to_draw_is_no_plot() {
        let line = || {
            vec![Series::through_points(
                CPU_COLOUR,
                LineStyle::with_width(1.0),
                [[0.0, 1.0]],
            )]
        };
        assert_eq!(unit_plot(Vec::new()).render_svg(), None);
        for ends in [[1.0, 1.0], [0.0, 1.0], [f64::NAN, 1.0], [1.0, f64::INFINITY]] {
            let mut plot = unit_plot(line());
            plot.axes[1] = Axis::logarithmic_scale("y", ends, format_share);
            assert_eq!(plot.render_svg(), None, "{ends:?}");
        }
    }

    #[test]
    fn ticks_are_round_numbers() {
        let near = |ticks: Vec<f64>, expected: &[f64]| {
            assert_eq!(ticks.len(), expected.len(), "{ticks:?}");
            assert!(
                ticks.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12),
                "{ticks:?}"
            );
        };
        near(
            linear_ticks([-1.0, 7.5]),
            &[-1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0],
        );
        near(linear_ticks([0.0, 0.31]), &[0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3]);
        near(logarithmic_ticks([0.3, 20.0]), &[0.5, 1.0, 2.0, 5.0, 10.0, 20.0]);
        near(logarithmic_ticks([1e-6, 0.1]), &[1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1]);
    }

    #[test]
    fn names_are_at_least_a_line_apart() {
        let places = spread_heights(&[5.0, 6.0, 7.0, 100.0, 199.0, 200.0], [8.0, 200.0]);
        assert!(places.windows(2).all(|w| w[1] - w[0] >= NAME_HEIGHT - 1e-9));
        assert!(places[0] >= 8.0 && places[5] <= 200.0);
        assert_eq!(places[3], 100.0);
    }

    #[test]
    fn labels_stay_apart_and_inside_the_area() {
        let area = [0.0, 0.0, 300.0, 200.0];
        let texts: Vec<String> = (0..40).map(|k| "x".repeat(5 + k % 9)).collect();
        let place = |k: usize| [(k * 67 % 300) as f64, (k * 41 % 200) as f64];
        let wanted: Vec<([f64; 2], &str)> = (0..40).map(|k| (place(k), texts[k].as_str())).collect();
        let marks: Vec<[f64; 2]> = (0..40).map(place).collect();
        let labels = place_labels(&wanted, area, &marks);
        assert!(labels.len() > 5);
        let label_box = |([x, y], text): &([f64; 2], &str)| {
            let width = LETTER_WIDTH * text.len() as f64;
            [*x, y - 0.8 * LABEL_HEIGHT, x + width, y + 0.2 * LABEL_HEIGHT]
        };
        for (k, label) in labels.iter().enumerate() {
            let own = label_box(label);
            assert!(own[0] >= 0.0 && own[1] >= 0.0 && own[2] <= 300.0 && own[3] <= 200.0);
            assert!(labels[..k].iter().all(|other| !boxes_overlap(own, label_box(other))));
            assert!(marks.iter().all(|[x, y]| !boxes_overlap(own, [*x, *y, *x, *y])));
        }
        let alone = place_labels(&[([150.0, 100.0], "ab")], area, &[[150.0, 100.0]]);
        assert!(alone[0].0[0] < 150.0 - LABEL_GAP && alone[0].0[1] > 100.0);
    }
}
