//! Plots as data: lines and marks over linear or logarithmic axes, rendered as inline SVG.
//!
//! plotters draws the axes; everything else is an element of its own, with a tooltip where it has one. An SVG needs no
//! files, fonts or network; text takes the page's colour. Whatever lies beyond an axis is drawn at its end.

use maud::{Markup, PreEscaped, html};
use plotters::coord::ranged1d::Ranged;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

/// Placeholder colour of text and axes, replaced by the page's own colour.
const INK_COLOUR: RGBColor = RGBColor(1, 2, 3);
/// Colour of CPU results.
pub const CPU_COLOUR: &str = "#2b7bba";
/// Colour of GPU results.
pub const GPU_COLOUR: &str = "#e07b00";
/// Colours of curves, distinguishable on white and on black.
pub const CURVE_COLOURS: [&str; 8] = [
    CPU_COLOUR, GPU_COLOUR, "#2c9650", "#a05abe", "#b8860b", "#e8459c", "#19a3a8", "#828282",
];
/// Marks of curves.
pub const CURVE_MARKS: [MarkShape; 6] = [
    MarkShape::Circle,
    MarkShape::Square,
    MarkShape::Triangle,
    MarkShape::Diamond,
    MarkShape::DownTriangle,
    MarkShape::Cross,
];
/// Style sheet of plots, inside a page or alone.
pub const PLOT_STYLE: &str = ".mark:hover path,.mark:focus path{stroke:currentColor;stroke-width:2.5;fill-opacity:1}\
    .mark path{stroke-linejoin:round}.upon text{font:12.5px sans-serif;fill:currentColor}";
/// Radius of marks, CSS pixels.
const MARK_RADIUS: f64 = 5.0;
/// Opacity of the filling of marks.
const MARK_OPACITY: f64 = 0.85;
/// Height of a row of the legend, CSS pixels.
const LEGEND_ROW_HEIGHT: f64 = 20.0;
/// Height of a plot's title in an SVG file, CSS pixels.
const TITLE_HEIGHT: u32 = 30;
/// Length of plotters' axes, which are linear.
const AXIS_STEPS: i32 = 1_000_000;
/// Maximum number of ticks of a linear axis.
const MAX_LINEAR_TICKS: usize = 10;

/// Plot: axes, and what is drawn over them from back to front.
#[derive(Clone)]
pub struct Plot {
    /// Width and height in CSS pixels; a page scales them.
    pub size: [u32; 2],
    /// Horizontal and vertical axis.
    pub axes: [Axis; 2],
    /// Lines and marks.
    pub series: Vec<Series>,
    /// Width of the column of the series' names beside the plot, CSS pixels.
    pub legend_width: u32,
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
    pub mark: Option<MarkShape>,
    /// Points.
    pub points: Vec<PlotPoint>,
}

/// Style of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineStyle {
    /// Width in CSS pixels.
    pub width: f64,
    /// SVG dash pattern; none for a solid line.
    pub dashes: Option<&'static str>,
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
}

/// Point of a series.
#[derive(Clone, Default)]
pub struct PlotPoint {
    /// Axis values.
    pub at: [f64; 2],
    /// Tooltip; empty for none.
    pub title: String,
}

impl From<[f64; 2]> for PlotPoint {
    fn from(at: [f64; 2]) -> Self {
        Self { at, ..Self::default() }
    }
}

impl LineStyle {
    /// Creates the style of a solid line.
    pub fn with_width(width: f64) -> Self {
        Self { width, dashes: None }
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
            @if let Some(mark) = self.mark { (draw_mark(self.colour, mark, [0.0, 0.0])) }
        }
    }
}

impl Axis {
    /// Creates a linear axis with about ten ticks.
    pub fn linear_scale(title: impl Into<String>, ends: [f64; 2], label: impl Fn(f64) -> String) -> Self {
        let mut axis = Self {
            title: title.into(),
            ends,
            is_logarithmic: false,
            ticks: Vec::new(),
        };
        if axis.is_drawable() {
            let ticks = RangedCoordf64::from(ends[0]..ends[1]).key_points(MAX_LINEAR_TICKS);
            axis.ticks = ticks.into_iter().map(|tick| (tick, label(tick))).collect();
        }
        axis
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

    /// Returns the place of a value on plotters' axis of [`AXIS_STEPS`].
    fn axis_place(&self, value: f64) -> i32 {
        (self.axis_share(value) * f64::from(AXIS_STEPS)).round() as i32
    }

    /// Returns the places of the ticks within the ends.
    fn tick_places(&self) -> Vec<i32> {
        let is_within = |value: &f64| *value >= self.ends[0] && *value <= self.ends[1];
        let values = self.ticks.iter().map(|(value, _)| *value).filter(is_within);
        values.map(|value| self.axis_place(value)).collect()
    }

    /// Returns the label of the tick at a place.
    fn tick_label(&self, place: i32) -> String {
        let tick = self.ticks.iter().find(|(value, _)| self.axis_place(*value) == place);
        tick.map_or(String::new(), |(_, label)| label.clone())
    }
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
    let width = plots.iter().map(|(_, plot)| plot.size[0]).max().unwrap_or(1);
    let mut height = 0;
    let mut parts = String::new();
    for (name, plot) in plots {
        let Some(svg) = plot.render_svg() else { continue };
        let [w, h] = plot.size;
        let title = html! { text x="20" y=(height + 22) style="font:600 16px sans-serif" { (name) } };
        let place = format!("<svg y=\"{}\" width=\"{w}\" height=\"{h}\" ", height + TITLE_HEIGHT);
        parts += &title.into_string();
        parts += &svg.replacen("<svg ", &place, 1);
        height += TITLE_HEIGHT + h;
    }
    let style = ":root{color:#1c1e21;background:#fff}@media(prefers-color-scheme:dark){:root{color:#e6e7e8;background:#202327}}text{fill:currentColor}";
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\"><style>{style}{PLOT_STYLE}</style>{parts}</svg>"
    )
}

impl Plot {
    /// Renders the plot as an SVG element; none if there is nothing to draw.
    pub fn render_svg(&self) -> Option<String> {
        let is_empty = self.series.iter().all(|series| series.points.is_empty());
        if is_empty || !self.axes.iter().all(Axis::is_drawable) {
            return None;
        }
        let (axes, [left, top, right, bottom]) = self.draw_axes()?;
        let pixel_at = |[x, y]: [f64; 2]| {
            [
                left + self.axes[0].axis_share(x) * (right - left),
                bottom + self.axes[1].axis_share(y) * (top - bottom),
            ]
        };
        let curve = |series: &Series| -> Vec<[f64; 2]> { series.points.iter().map(|p| pixel_at(p.at)).collect() };
        let [w, h] = self.size;
        let svg = html! {
            svg role="img" class="chart" viewBox=(format!("0 0 {w} {h}")) {
                (PreEscaped(axes))
                g.upon {
                    @for series in &self.series {
                        @if let Some(line) = &series.line { (draw_line(&curve(series), series.colour, line)) }
                    }
                    @for series in &self.series { @if let Some(mark) = series.mark {
                        @for point in &series.points { g.mark {
                            @if !point.title.is_empty() { title { (point.title) } }
                            (draw_mark(series.colour, mark, pixel_at(point.at)))
                        } }
                    } }
                    (self.draw_legend())
                }
            }
        };
        Some(svg.into_string())
    }

    /// Draws axes, titles and a faint grid; returns them with left, top, right and bottom of the drawing area.
    fn draw_axes(&self) -> Option<(String, [f64; 4])> {
        let mut text = String::new();
        let area = SVGBackend::with_string(&mut text, (self.size[0], self.size[1])).into_drawing_area();
        let [x, y] = self
            .axes
            .each_ref()
            .map(|axis| (0..AXIS_STEPS).with_key_points(axis.tick_places()));
        let mut chart = ChartBuilder::on(&area)
            .margin(10)
            .margin_right(self.legend_width)
            .x_label_area_size(44)
            .y_label_area_size(78)
            .build_cartesian_2d(x, y)
            .ok()?;
        let [x_axis, y_axis] = &self.axes;
        chart
            .configure_mesh()
            .x_desc(&x_axis.title)
            .y_desc(&y_axis.title)
            .x_label_formatter(&|place| x_axis.tick_label(*place))
            .y_label_formatter(&|place| y_axis.tick_label(*place))
            .axis_style(INK_COLOUR.mix(0.7))
            .bold_line_style(INK_COLOUR.mix(0.15))
            .axis_desc_style(("sans-serif", 15).into_font().color(&INK_COLOUR))
            .label_style(("sans-serif", 13).into_font().color(&INK_COLOUR))
            .draw()
            .ok()?;
        let (left, bottom) = chart.backend_coord(&(0, 0));
        let (right, top) = chart.backend_coord(&(AXIS_STEPS, AXIS_STEPS));
        area.present().ok()?;
        drop((chart, area));
        let axes = text[text.find('>')? + 1..text.rfind("</svg>")?].replace("#010203", "currentColor");
        Some((axes, [left, top, right, bottom].map(f64::from)))
    }

    /// Draws the names of the series below each other.
    fn draw_legend(&self) -> Markup {
        let x = f64::from(self.size[0] - self.legend_width) + 24.0;
        let named = self.series.iter().filter(|series| !series.name.is_empty());
        html! {
            @for (k, series) in named.enumerate() {
                g transform=(format!("translate({x:.1} {:.1})", 30.0 + LEGEND_ROW_HEIGHT * k as f64)) {
                    (series.draw_sample()) text x="18" y="4" { (series.name) }
                }
            }
        }
    }
}

/// Draws a line through pixels; nothing without a pixel.
fn draw_line(pixels: &[[f64; 2]], colour: &str, line: &LineStyle) -> Markup {
    let points: Vec<String> = pixels.iter().map(|[x, y]| format!("{x:.1} {y:.1}")).collect();
    html! { @if !points.is_empty() {
        path d={ "M" (points.join("L")) } stroke=(colour) stroke-width=(line.width)
            stroke-dasharray=[line.dashes] stroke-linejoin="round" fill="none" {}
    } }
}

fn draw_mark(colour: &str, mark: MarkShape, [x, y]: [f64; 2]) -> Markup {
    html! {
        path d=(mark.unit_path()) transform=(format!("translate({x:.1} {y:.1}) scale({MARK_RADIUS})"))
            fill=(colour) fill-opacity=(MARK_OPACITY) vector-effect="non-scaling-stroke" {}
    }
}

impl MarkShape {
    /// Returns SVG path data of the mark with radius 1 about the origin.
    fn unit_path(self) -> &'static str {
        match self {
            Self::Circle => "M-1 0a1 1 0 1 0 2 0a1 1 0 1 0-2 0Z",
            Self::Square => "M-.9-.9H.9V.9H-.9Z",
            Self::Triangle => "M0-1.2L1.1.8H-1.1Z",
            Self::Diamond => "M0-1.3L1.3 0L0 1.3L-1.3 0Z",
            Self::DownTriangle => "M0 1.2L1.1-.8H-1.1Z",
            Self::Cross => "M0-.3L.7-1L1-.7L.3 0L1 .7L.7 1L0 .3L-.7 1L-1 .7L-.3 0L-1-.7L-.7-1Z",
        }
    }
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
            series,
            legend_width: 80,
        }
    }

    #[test]
    fn values_beyond_axes_are_drawn_at_their_ends() {
        let points = [[0.5, f64::NAN], [f64::INFINITY, 1e9], [-7.0, 0.0]];
        let point = |at: [f64; 2]| PlotPoint {
            title: "a & b".into(),
            ..at.into()
        };
        let series = Series {
            name: "one".into(),
            mark: Some(MarkShape::Circle),
            points: points.map(point).into(),
            ..Series::through_points(CPU_COLOUR, LineStyle::with_width(1.0), [[0.0; 2]; 0])
        };
        let svg = unit_plot(vec![series]).render_svg().unwrap();
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert_eq!(svg.matches("<g class=\"mark\"><title>a &amp; b</title>").count(), 3);
        // The drawing area lies between (88, 10) and (319, 245).
        for place in ["203.5 10.0", "319.0 10.0", "88.0 245.0"] {
            assert!(svg.contains(&format!("translate({place})")), "{place}");
        }
        assert!(svg.contains("x &lt;m&gt;") && svg.contains(">one</text>") && svg.contains("0.1 %"));
    }

    #[test]
    fn nothing_to_draw_is_no_plot() {
        assert_eq!(unit_plot(Vec::new()).render_svg(), None);
        let line = Series::through_points(CPU_COLOUR, LineStyle::with_width(1.0), [[0.0, 1.0]]);
        for ends in [[1.0, 1.0], [0.0, 1.0], [f64::NAN, 1.0], [1.0, f64::INFINITY]] {
            let mut plot = unit_plot(vec![line.clone()]);
            plot.axes[1] = Axis::logarithmic_scale("y", ends, format_share);
            assert_eq!(plot.render_svg(), None, "{ends:?}");
        }
        let endless = Axis::linear_scale("x", [0.0, f64::NAN], |x| x.to_string());
        assert!(endless.ticks.is_empty());
    }

    #[test]
    fn ticks_are_round_numbers() {
        let linear = |ends| Axis::linear_scale("", ends, |_| String::new()).ticks;
        let linear = |ends| linear(ends).into_iter().map(|(tick, _)| tick).collect();
        let cases: [(Vec<f64>, &[f64]); 4] = [
            (linear([-1.0, 7.5]), &[-1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]),
            (linear([0.0, 0.31]), &[0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3]),
            (logarithmic_ticks([0.3, 20.0]), &[0.5, 1.0, 2.0, 5.0, 10.0, 20.0]),
            (logarithmic_ticks([1e-6, 0.1]), &[1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1]),
        ];
        for (ticks, expected) in cases {
            let near = ticks.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12);
            assert!(near && ticks.len() == expected.len(), "{ticks:?} {expected:?}");
        }
    }
}
