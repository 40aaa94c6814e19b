//! Charts as inline SVG: axes by plotters, lines and marks upon them, so that each mark can say what
//! it is. No files, no fonts, no network; text takes the page's colour.

mod shape;

pub use shape::Shape;

use maud::{Markup, html};
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::prelude::*;
use std::ops::Range;

/// Drawn in this, text and axes become the page's own colour.
const INK: RGBColor = RGBColor(1, 2, 3);
/// The CPU's colour.
pub const CPU: &str = "#2b7bba";
/// The GPU's.
pub const GPU: &str = "#e07b00";
/// Curves' colours, told apart on white and on black, and the marks that go with them: no curve is told by
/// its colour alone.
pub const COLOURS: [&str; 8] = [
    CPU, GPU, "#2c9650", "#a05abe", "#b8860b", "#e8459c", "#19a3a8", "#828282",
];
/// The marks, one a colour.
pub const MARKS: [Shape; 8] = [
    Shape::Circle,
    Shape::Square,
    Shape::Triangle,
    Shape::Diamond,
    Shape::Down,
    Shape::Cross,
    Shape::Ring,
    Shape::Bar,
];
/// What every chart looks like, inside a page or alone.
pub const STYLE: &str = ".mark:hover path,.mark:focus path{stroke:currentColor;stroke-width:2.5;fill-opacity:1}\
    .mark path{stroke-linejoin:round}.upon text{font:12.5px sans-serif;fill:currentColor}\
    .over{paint-order:stroke;stroke:var(--card);stroke-width:3px;stroke-linejoin:round}";

/// What an axis writes at a value.
pub type Label<'a> = &'a dyn Fn(&f64) -> String;

/// An axis.
pub struct Axis<'a> {
    /// What it is of.
    pub name: &'a str,
    /// Its ends.
    pub ends: [f64; 2],
    /// Whether it is logarithmic.
    pub log: bool,
    /// Where it is labelled; none: at about ten round numbers.
    pub ticks: Option<Vec<f64>>,
    /// How.
    pub label: Label<'a>,
}

impl<'a> Axis<'a> {
    /// In even steps.
    pub fn even(name: &'a str, ends: [f64; 2], label: Label<'a>) -> Self {
        Self {
            name,
            ends,
            log: false,
            ticks: None,
            label,
        }
    }

    /// Logarithmic, labelled at 1, 2 and 5 × 10ⁿ.
    pub fn log(name: &'a str, ends: [f64; 2], label: Label<'a>) -> Self {
        Self {
            log: true,
            ticks: Some(ticks(ends[0], ends[1])),
            ..Self::even(name, ends, label)
        }
    }

    fn scale(&self) -> Scale {
        let [low, high] = self.ends;
        Scale {
            even: (low..high).into(),
            log: self.log.then(|| (low..high).log_scale().into()),
            ticks: self.ticks.clone(),
        }
    }

    /// The share of the axis at which a value lies.
    fn share(&self, value: f64) -> f64 {
        let [low, high] = self.ends;
        if self.log {
            (value / low).ln() / (high / low).ln()
        } else {
            (value - low) / (high - low)
        }
    }
}

/// An axis as plotters wants it.
struct Scale {
    even: plotters::coord::types::RangedCoordf64,
    log: Option<LogCoord<f64>>,
    ticks: Option<Vec<f64>>,
}

impl Ranged for Scale {
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

/// Where the axes lie, in pixels.
pub struct Frame<'a> {
    x: &'a Axis<'a>,
    y: &'a Axis<'a>,
    /// Left end.
    pub left: f64,
    /// Upper end.
    pub top: f64,
    /// Right end.
    pub right: f64,
    /// Lower end.
    pub bottom: f64,
}

impl Frame<'_> {
    /// The pixel of a value on the x axis.
    pub fn x(&self, value: f64) -> f64 {
        self.left + self.x.share(value) * (self.right - self.left)
    }

    /// The pixel of a value on the y axis.
    pub fn y(&self, value: f64) -> f64 {
        self.bottom + self.y.share(value) * (self.top - self.bottom)
    }

    /// Path data through places.
    pub fn path(&self, places: impl IntoIterator<Item = (f64, f64)>) -> String {
        path(places.into_iter().map(|(x, y)| (self.x(x), self.y(y))))
    }
}

/// Path data through pixels.
pub fn path(pixels: impl IntoIterator<Item = (f64, f64)>) -> String {
    let points = pixels.into_iter().map(|(x, y)| format!("{x:.1} {y:.1}"));
    format!("M{}", points.collect::<Vec<_>>().join("L"))
}

/// A line of a colour, width, opacity and dashes.
pub fn line(path: &str, colour: &str, width: f64, opacity: f64, dashes: Option<&str>) -> Markup {
    html! {
        path d=(path) stroke=(colour) stroke-width=(width) stroke-opacity=(opacity) stroke-dasharray=[dashes]
            stroke-linejoin="round" fill="none" {}
    }
}

/// Samples drawn about the origin and, so far to their right, what they are: a line each from (x, y).
pub fn legend<N: AsRef<str>>(
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

/// A pixel as SVG writes it.
pub fn px(x: f64) -> String {
    format!("{x:.1}")
}

/// The SVG element, scaled by the page and in its colours: `size` in CSS pixels, `right` of them
/// beside the axes, and what `draw` puts upon these.
pub fn svg(
    (w, h): (u32, u32),
    right: u32,
    [x, y]: [&Axis; 2],
    draw: impl FnOnce(&Frame) -> Markup,
) -> Option<String> {
    let mut text = String::new();
    let [left, top, right, bottom] = axes(&mut text, (w, h), right, [x, y])?;
    let frame = Frame {
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

/// Draws axes, their names and a faint grid; left, top, right and bottom.
fn axes(text: &mut String, size: (u32, u32), right: u32, [x, y]: [&Axis; 2]) -> Option<[f64; 4]> {
    let area = SVGBackend::with_string(text, size).into_drawing_area();
    let mut chart = ChartBuilder::on(&area)
        .margin(10)
        .margin_right(right)
        .x_label_area_size(44)
        .y_label_area_size(78)
        .build_cartesian_2d(x.scale(), y.scale())
        .ok()?;
    chart
        .configure_mesh()
        .x_desc(x.name)
        .y_desc(y.name)
        .x_label_formatter(x.label)
        .y_label_formatter(y.label)
        .y_labels(8)
        .axis_style(INK.mix(0.7))
        .bold_line_style(INK.mix(0.15))
        .light_line_style(INK.mix(0.04))
        .axis_desc_style(("sans-serif", 15).into_font().color(&INK))
        .label_style(("sans-serif", 13).into_font().color(&INK))
        .draw()
        .ok()?;
    let (left, bottom) = chart.backend_coord(&(x.ends[0], y.ends[0]));
    let (right, top) = chart.backend_coord(&(x.ends[1], y.ends[1]));
    area.present().ok()?;
    Some([left, top, right, bottom].map(f64::from))
}

/// A share as an axis names it.
pub fn share(y: &f64) -> String {
    let digits = (-(100.0 * y).log10().floor()).clamp(0.0, 10.0) as usize;
    format!("{:.digits$} %", 100.0 * y)
}

/// 1, 2 and 5 × 10ⁿ where they fit, powers of ten alone over many decades.
pub fn ticks(low: f64, high: f64) -> Vec<f64> {
    let decades = (high / low).log10();
    let steps: &[f64] = if decades > 4.0 {
        &[1.0]
    } else {
        &[1.0, 2.0, 5.0]
    };
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    // As text, so that a tick is the number nearest to what it says.
    let all = (first..=last).flat_map(|n| {
        steps
            .iter()
            .filter_map(move |m| format!("{m}e{n}").parse().ok())
    });
    all.filter(|t| (low..=high).contains(t)).collect()
}
