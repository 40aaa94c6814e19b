//! Draws charts as inline SVG: plotters draws the axes; lines and marks are added as elements with titles.
//! Needs no files, fonts or network; text takes the page's colour.

use maud::{Markup, html};
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
/// Style sheet of charts, inside a page or alone.
pub const CHART_STYLE: &str = ".mark:hover path,.mark:focus path{stroke:currentColor;stroke-width:2.5;fill-opacity:1}\
    .mark path{stroke-linejoin:round}.upon text{font:12.5px sans-serif;fill:currentColor}\
    .over{paint-order:stroke;stroke:var(--card);stroke-width:3px;stroke-linejoin:round}";

/// Formats the label of an axis value.
pub type AxisLabel<'a> = &'a dyn Fn(&f64) -> String;

/// Axis of a chart.
pub struct Axis<'a> {
    /// Title.
    pub name: &'a str,
    /// Lowest and highest value.
    pub ends: [f64; 2],
    /// True for a logarithmic scale.
    pub log: bool,
    /// Labelled values; none for about ten round numbers.
    pub ticks: Option<Vec<f64>>,
    /// Label formatter.
    pub label: AxisLabel<'a>,
}

impl<'a> Axis<'a> {
    /// Creates a linear axis.
    pub fn linear_scale(name: &'a str, ends: [f64; 2], label: AxisLabel<'a>) -> Self {
        Self {
            name,
            ends,
            log: false,
            ticks: None,
            label,
        }
    }

    /// Creates a logarithmic axis, labelled at 1, 2 and 5 × 10ⁿ.
    pub fn logarithmic_scale(name: &'a str, ends: [f64; 2], label: AxisLabel<'a>) -> Self {
        Self {
            log: true,
            ticks: Some(logarithmic_ticks(ends[0], ends[1])),
            ..Self::linear_scale(name, ends, label)
        }
    }

    /// Converts to a plotters coordinate.
    fn plotters_scale(&self) -> AxisScale {
        let [low, high] = self.ends;
        AxisScale {
            even: (low..high).into(),
            log: self.log.then(|| (low..high).log_scale().into()),
            ticks: self.ticks.clone(),
        }
    }

    /// Returns the position of a value as a share of the axis.
    fn axis_share(&self, value: f64) -> f64 {
        let [low, high] = self.ends;
        if self.log {
            (value / low).ln() / (high / low).ln()
        } else {
            (value - low) / (high - low)
        }
    }
}

/// Axis coordinate for plotters.
struct AxisScale {
    even: plotters::coord::types::RangedCoordf64,
    log: Option<LogCoord<f64>>,
    ticks: Option<Vec<f64>>,
}

impl Ranged for AxisScale {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        match &self.log {
            Some(log) => log.map(value, limit),
            None => self.even.map(value, limit),
        }
    }

    fn key_points<H: KeyPointHint>(&self, hint: H) -> Vec<f64> {
        match (&self.ticks, &self.log) {
            (Some(_), _) if hint.weight().allow_light_points() => Vec::new(),
            (Some(ticks), _) => ticks.clone(),
            (None, Some(log)) => log.key_points(hint),
            (None, None) => self.even.key_points(hint),
        }
    }

    fn range(&self) -> Range<f64> {
        self.even.range()
    }
}

/// Plot area of a chart in pixels.
pub struct ChartFrame<'a> {
    x: &'a Axis<'a>,
    y: &'a Axis<'a>,
    /// Left edge.
    pub left: f64,
    /// Upper edge.
    pub top: f64,
    /// Right edge.
    pub right: f64,
    /// Lower edge.
    pub bottom: f64,
}

impl ChartFrame<'_> {
    /// Returns the pixel coordinate of an x value.
    pub fn x_pixel(&self, value: f64) -> f64 {
        self.left + self.x.axis_share(value) * (self.right - self.left)
    }

    /// Returns the pixel coordinate of a y value.
    pub fn y_pixel(&self, value: f64) -> f64 {
        self.bottom + self.y.axis_share(value) * (self.top - self.bottom)
    }

    /// Returns SVG path data through points given in axis values.
    pub fn plot_path(&self, places: impl IntoIterator<Item = (f64, f64)>) -> String {
        path_data(places.into_iter().map(|(x, y)| (self.x_pixel(x), self.y_pixel(y))))
    }
}

/// Returns SVG path data through points given in pixels.
pub fn path_data(pixels: impl IntoIterator<Item = (f64, f64)>) -> String {
    let points = pixels.into_iter().map(|(x, y)| format!("{x:.1} {y:.1}"));
    format!("M{}", points.collect::<Vec<_>>().join("L"))
}

/// Draws a path with colour, width, opacity and dashes.
pub fn draw_path(path: &str, colour: &str, width: f64, opacity: f64, dashes: Option<&str>) -> Markup {
    html! {
        path d=(path) stroke=(colour) stroke-width=(width) stroke-opacity=(opacity) stroke-dasharray=[dashes]
            stroke-linejoin="round" fill="none" {}
    }
}

/// Draws a legend from (x, y) downwards: each row's sample, drawn about the origin, and its name `right` pixels
/// beside it.
pub fn draw_legend<N: AsRef<str>>(
    (x, y): (f64, f64),
    right: f64,
    rows: impl IntoIterator<Item = (Markup, N)>,
) -> Markup {
    html! {
        @for (k, (sample, name)) in rows.into_iter().enumerate() {
            g transform=(format!("translate({x} {})", y + 20.0 * k as f64)) {
                (sample) text x=(right) y="4" { (name.as_ref()) }
            }
        }
    }
}

/// Formats a pixel coordinate for SVG.
pub fn format_pixel(x: f64) -> String {
    format!("{x:.1}")
}

/// Renders a chart of `w`×`h` CSS pixels as an SVG element: axes with a right margin of `right` pixels, and the
/// content that `draw` returns. None if plotters fails.
pub fn render_svg(
    (w, h): (u32, u32),
    right: u32,
    [x, y]: [&Axis; 2],
    draw: impl FnOnce(&ChartFrame) -> Markup,
) -> Option<String> {
    let mut text = String::new();
    let [left, top, right, bottom] = draw_axes(&mut text, (w, h), right, [x, y])?;
    let frame = ChartFrame {
        x,
        y,
        left,
        top,
        right,
        bottom,
    };
    let inner = &text[text.find('>')? + 1..text.rfind("</svg>")?];
    let inner = inner.replace("#010203", "currentColor");
    let upon = html! { g.upon { (draw(&frame)) } }.into_string();
    let open = format!(r#"<svg role="img" class="chart" viewBox="0 0 {w} {h}">"#);
    Some(open + &inner + &upon + "</svg>")
}

/// Draws axes, titles and a faint grid; returns left, top, right and bottom of the plot area.
fn draw_axes(text: &mut String, size: (u32, u32), right: u32, [x, y]: [&Axis; 2]) -> Option<[f64; 4]> {
    let area = SVGBackend::with_string(text, size).into_drawing_area();
    let mut chart = ChartBuilder::on(&area)
        .margin(10)
        .margin_right(right)
        .x_label_area_size(44)
        .y_label_area_size(78)
        .build_cartesian_2d(x.plotters_scale(), y.plotters_scale())
        .ok()?;
    chart
        .configure_mesh()
        .x_desc(x.name)
        .y_desc(y.name)
        .x_label_formatter(x.label)
        .y_label_formatter(y.label)
        .y_labels(8)
        .axis_style(INK_COLOUR.mix(0.7))
        .bold_line_style(INK_COLOUR.mix(0.15))
        .light_line_style(INK_COLOUR.mix(0.04))
        .axis_desc_style(("sans-serif", 15).into_font().color(&INK_COLOUR))
        .label_style(("sans-serif", 13).into_font().color(&INK_COLOUR))
        .draw()
        .ok()?;
    let (left, bottom) = chart.backend_coord(&(x.ends[0], y.ends[0]));
    let (right, top) = chart.backend_coord(&(x.ends[1], y.ends[1]));
    area.present().ok()?;
    Some([left, top, right, bottom].map(f64::from))
}

/// Formats a share in per cent for an axis.
pub fn format_share(y: &f64) -> String {
    let digits = (-(100.0 * y).log10().floor()).clamp(0.0, 10.0) as usize;
    format!("{:.digits$} %", 100.0 * y)
}

/// Returns logarithmic ticks: 1, 2 and 5 × 10ⁿ, or powers of ten alone over more than four decades.
pub fn logarithmic_ticks(low: f64, high: f64) -> Vec<f64> {
    let decades = (high / low).log10();
    let steps: &[f64] = if decades > 4.0 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    // Parsed from text, so that each tick is the number nearest to its label.
    let all = (first..=last).flat_map(|n| steps.iter().filter_map(move |m| format!("{m}e{n}").parse().ok()));
    all.filter(|t| (low..=high).contains(t)).collect()
}

/// Outline of a chart mark.
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
    pub fn outline_path(self, (x, y): (f64, f64), r: f64) -> String {
        let polygon = |corners: &[(f64, f64)]| {
            let at = |(i, j): &(f64, f64)| (x + i * r, y + j * r);
            path_data(corners.iter().map(at)) + "Z"
        };
        match self {
            Self::Circle => {
                let (left, across) = (x - r, 2.0 * r);
                format!("M{left:.1} {y:.1}a{r} {r} 0 1 0 {across} 0a{r} {r} 0 1 0 -{across} 0Z")
            }
            Self::Ring => {
                let ring = |r: f64, turn: u8| {
                    let (left, across) = (x - r, 2.0 * r);
                    format!("M{left:.1} {y:.1}a{r} {r} 0 1 {turn} {across} 0a{r} {r} 0 1 {turn} -{across} 0Z")
                };
                // The hole has the opposite orientation.
                ring(1.1 * r, 0) + &ring(0.5 * r, 1)
            }
            Self::Bar => polygon(&[(-1.3, -0.5), (1.3, -0.5), (1.3, 0.5), (-1.3, 0.5)]),
            Self::Square => polygon(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]),
            Self::Triangle => polygon(&[(0.0, -1.2), (1.1, 0.8), (-1.1, 0.8)]),
            Self::Diamond => polygon(&[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)]),
            Self::DownTriangle => polygon(&[(0.0, 1.2), (1.1, -0.8), (-1.1, -0.8)]),
            Self::Cross => {
                // One arm, rotated by quarter turns.
                let arm = [(0.0, -0.3), (0.7, -1.0), (1.0, -0.7)];
                let turned = |(i, j): (f64, f64), k| match k {
                    0 => (i, j),
                    1 => (-j, i),
                    2 => (-i, -j),
                    _ => (j, -i),
                };
                let corners = (0..4).flat_map(|k| arm.map(|corner| turned(corner, k)));
                polygon(&corners.collect::<Vec<_>>())
            }
        }
    }
}
