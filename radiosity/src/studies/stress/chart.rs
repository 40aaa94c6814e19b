//! Chart of a case: error against the parameter, both logarithmic, harder values to the right.

use super::outcome::{self, Processor, format_amount, format_error, format_value, swept_values};
use super::{AtlasRow, CaseStudy, LEAK_MEASURE, SolverSide};
use crate::report::chart::{
    Axis, CURVE_COLOURS, CURVE_MARKS, ChartFrame, MarkShape, draw_path, format_pixel, format_share, logarithmic_ticks,
    path_data, render_svg,
};
use maud::{Markup, html};

/// Size of the chart, CSS pixels; the page scales it.
const CHART_SIZE: (u32, u32) = (860, 470);
/// Width for the curves' names, CSS pixels.
const NAMES_WIDTH: u32 = 156;
/// Height of the strip on top for missing answers, as a share of the axis.
const STRIP_HEIGHT: f64 = 0.12;
/// Error range of the axis in units of the safe limit; errors beyond are drawn at its ends.
const ERROR_RANGE: [f64; 2] = [1e-5, 1e5];
/// Least factor between a limit and the end of the axis.
const LIMIT_MARGIN: f64 = 3.0;
/// Least distance of labels on the parameter's axis, as a share of it.
const MIN_TICK_DISTANCE: f64 = 0.085;
/// Height of a name, CSS pixels.
const NAME_HEIGHT: f64 = 17.0;

/// Returns the colour of method `k`; the first has the page's own.
pub fn method_colour(k: usize) -> &'static str {
    k.checked_sub(1)
        .map_or("currentColor", |k| CURVE_COLOURS[k % CURVE_COLOURS.len()])
}

/// Returns the mark of method `k`. There is one mark fewer than colours, so no two methods share
/// both; the cross is reserved for missing answers.
pub fn method_shape(k: usize) -> MarkShape {
    let marks = CURVE_MARKS.iter().filter(|mark| **mark != MarkShape::Cross);
    let marks: Vec<MarkShape> = marks.copied().collect();
    marks[k % marks.len()]
}

/// Values, error range and axes of a chart.
pub struct CasePlot<'a> {
    /// Values of the parameter, easy to hard.
    pub values: &'a [f64],
    places: &'a [f64],
    /// Error range without the strip.
    errors: [f64; 2],
    /// Largest errors of a safe and of a degraded result.
    limits: [f64; 2],
    /// Axes in pixels.
    pub frame: &'a ChartFrame<'a>,
}

impl CasePlot<'_> {
    /// Returns the pixel of a value.
    pub fn pixel_x(&self, value: f64) -> f64 {
        let at = self.values.iter().position(|v| *v == value).unwrap_or(0);
        self.frame.x_pixel(self.places.get(at).copied().unwrap_or(0.5))
    }

    /// Returns the pixel of an error.
    pub fn pixel_y(&self, error: f64) -> f64 {
        let [low, high] = self.errors;
        // NaN is drawn at the upper end.
        self.frame
            .y_pixel(if error.is_nan() { high } else { error.clamp(low, high) })
    }

    /// Returns the pixel of the middle of the strip.
    pub fn strip_middle(&self) -> f64 {
        (self.frame.top + self.pixel_y(self.errors[1])) / 2.0
    }
}

/// Ends of the parameter's axis; the values lie on 0…1, the limits' names beyond.
const AXIS_ENDS: [f64; 2] = [-0.04, 1.09];

/// Least distance of values on a logarithmic axis, in units of even steps.
const MIN_VALUE_DISTANCE: f64 = 0.25;

/// Maps the values to 0…1: logarithmically, or in even steps if some would be too close.
fn value_places(values: &[f64]) -> Vec<f64> {
    let usable = values.iter().all(|v| v.is_finite() && *v > 0.0);
    let (first, last) = (values.first(), values.last());
    let ordered = values.is_sorted() || values.iter().rev().is_sorted();
    let (Some(a), Some(b)) = (first, last) else {
        return Vec::new();
    };
    if a == b {
        return vec![0.5; values.len()];
    }
    let step = 1.0 / (values.len() - 1) as f64;
    let even = || (0..values.len()).map(|k| k as f64 * step).collect();
    if !usable || !ordered {
        return even();
    }
    let places: Vec<f64> = values.iter().map(|v| (v / a).ln() / (b / a).ln()).collect();
    if places.windows(2).any(|w| w[1] - w[0] < MIN_VALUE_DISTANCE * step) {
        return even();
    }
    places
}

/// Returns the error range of the axis: all errors and both limits, with a margin.
fn error_range<'a>(sides: impl Iterator<Item = &'a SolverSide>, limits: [f64; 2]) -> [f64; 2] {
    let errors = sides.filter_map(|side| side.error);
    let errors = errors.filter(|error| error.is_finite() && *error > 0.0);
    let shown = [limits[0] / LIMIT_MARGIN, limits[1] * LIMIT_MARGIN];
    let [low, high] = errors.fold(shown, |[low, high], error| {
        [low.min(error * 0.6), high.max(error * 1.7)]
    });
    let ends = ERROR_RANGE.map(|end| end * limits[0]);
    [low.max(ends[0]), high.min(ends[1])]
}

/// Returns the chart, or none without rows.
pub fn draw_case(study: &CaseStudy, methods: &[&'static str]) -> Option<String> {
    if study.rows.is_empty() {
        return None;
    }
    let (values, measure) = (swept_values(study), study.info.measure);
    let limits = super::error_limits(measure);
    let sides = study.rows.iter().flat_map(outcome::solver_sides);
    let errors = error_range(sides.map(|(_, side)| side), limits);
    let strip = (errors[1] / errors[0]).powf(STRIP_HEIGHT);
    let places = value_places(&values);
    let mut shown: Vec<f64> = Vec::new();
    for place in &places {
        if shown.last().is_none_or(|last| place - last > MIN_TICK_DISTANCE) {
            shown.push(*place);
        }
    }
    let named = |x: &f64| {
        let at = places.iter().position(|place| place == x);
        at.map_or(String::new(), |k| outcome::format_value(values[k]))
    };
    let parameter = format!("{} → harder", study.info.parameter);
    let error = format!("{measure} (log)");
    let error_label = |error: &f64| match measure {
        LEAK_MEASURE => outcome::format_value(*error),
        _ => format_share(error),
    };
    let x = Axis {
        ticks: Some(shown),
        ..Axis::linear_scale(&parameter, AXIS_ENDS, &named)
    };
    let y = Axis {
        ticks: Some(logarithmic_ticks(errors[0], errors[1])),
        ..Axis::logarithmic_scale(&error, [errors[0], errors[1] * strip], &error_label)
    };
    render_svg(CHART_SIZE, NAMES_WIDTH, [&x, &y], |frame| {
        let plot = CasePlot {
            values: &values,
            places: &places,
            errors,
            limits,
            frame,
        };
        html! { (draw_zones(&plot)) (draw_case_curves(study, methods, &plot)) (draw_limits(&plot, measure)) }
    })
}

/// Draws both limits, the shaded zones beyond them and the strip.
fn draw_zones(plot: &CasePlot) -> Markup {
    let ChartFrame { left, top, right, .. } = *plot.frame;
    let [safe, degraded] = plot.limits.map(|limit| plot.pixel_y(limit));
    let strip = plot.pixel_y(plot.errors[1]);
    let shade = |from: f64, to: f64, class: &str| {
        html! { rect class=(class) x=(left) y=(format_pixel(to)) width=(right - left) height=(format_pixel((from - to).max(0.0))) {} }
    };
    let across = |y: f64| path_data([(left, y), (right, y)]);
    html! {
        (shade(safe, degraded, "zone-degrades"))
        (shade(degraded, top, "zone-fails"))
        @for y in [safe, degraded] { (draw_path(&across(y), "currentColor", 1.2, 0.75, None)) }
        (draw_path(&across(strip), "currentColor", 1.0, 1.0, Some("2 4")))
        text x=(left - 8.0) y=(format_pixel((top + strip) / 2.0 + 4.0)) text-anchor="end" { "no answer" }
    }
}

/// Writes the limits, over everything else.
fn draw_limits(plot: &CasePlot, measure: &str) -> Markup {
    let x = plot.frame.right - 4.0;
    html! {
        @for limit in plot.limits {
            text.over x=(x) y=(format_pixel(plot.pixel_y(limit) - 4.0)) text-anchor="end" { (format_amount(measure, limit)) }
        }
    }
}

/// Draws all curves.
pub fn draw_case_curves(study: &CaseStudy, methods: &[&'static str], plot: &CasePlot) -> Markup {
    let both = |(k, method): (usize, &&'static str)| {
        let method = *method;
        Processor::BOTH.map(|processor| MethodCurve::new(study, k, method, processor))
    };
    let all = methods.iter().enumerate().flat_map(both);
    let curves: Vec<MethodCurve> = all.filter(|curve| !curve.points.is_empty()).collect();
    // The first method is drawn last, over the others; of each method the GPU over the CPU.
    let mut drawn: Vec<&MethodCurve> = curves.iter().collect();
    drawn.sort_by_key(|curve| std::cmp::Reverse(curve.place));
    html! {
        @for curve in &drawn { (draw_line(curve, plot)) }
        @for curve in &drawn { @for point in &curve.points { (draw_mark(curve, point, plot)) } }
        (draw_missing(&curves, plot))
        (draw_names(&curves, plot))
    }
}

/// Results of one method on one solver.
struct MethodCurve<'a> {
    method: &'static str,
    place: usize,
    colour: &'static str,
    shape: MarkShape,
    processor: Processor,
    measure: &'static str,
    points: Vec<(&'a AtlasRow, &'a SolverSide)>,
}

impl<'a> MethodCurve<'a> {
    fn new(study: &'a CaseStudy, k: usize, method: &'static str, processor: Processor) -> Self {
        let rows = study.rows.iter().filter(|row| row.method == method);
        Self {
            method,
            place: k,
            colour: method_colour(k),
            shape: method_shape(k),
            processor,
            measure: study.info.measure,
            points: rows.filter_map(|r| Some((r, processor.side_of(r)?))).collect(),
        }
    }

    /// Returns the pixel of its last point.
    fn end_pixel(&self, plot: &CasePlot) -> Option<(f64, f64)> {
        let (row, side) = self.points.last()?;
        let y = side.error.map_or(plot.strip_middle(), |error| plot.pixel_y(error));
        Some((plot.pixel_x(row.value), y))
    }
}

/// Draws the line, interrupted at values without an answer.
fn draw_line(curve: &MethodCurve, plot: &CasePlot) -> Markup {
    let parts = curve.points.split(|(_, side)| side.error.is_none());
    let at = |(row, side): &(&AtlasRow, &SolverSide)| Some((plot.pixel_x(row.value), plot.pixel_y(side.error?)));
    let parts = parts.filter(|part| !part.is_empty());
    let data: String = parts.map(|part| path_data(part.iter().filter_map(at))).collect();
    // A thin dashed line over a broad one: both are visible where they agree.
    let (width, opacity, dashes) = match curve.processor {
        Processor::Cpu => (4.5, 0.4, None),
        Processor::Gpu => (1.8, 1.0, Some("6 4")),
    };
    html! { @if !data.is_empty() { (draw_path(&data, curve.colour, width, opacity, dashes)) } }
}

/// Draws a mark: large and pale for the CPU, small and dark for the GPU; hollow with a warning.
fn draw_mark(curve: &MethodCurve, (row, side): &(&AtlasRow, &SolverSide), plot: &CasePlot) -> Markup {
    let (size, pale) = match curve.processor {
        Processor::Cpu => (6.0, 0.4),
        Processor::Gpu => (3.2, 1.0),
    };
    let (fill, opacity) = if side.is_warned() {
        ("var(--card)", 1.0)
    } else {
        (curve.colour, pale)
    };
    html! {
        @if let Some(error) = side.error {
            g.mark {
                title { (mark_tooltip(curve, row, side)) }
                path d=(curve.shape.outline_path((plot.pixel_x(row.value), plot.pixel_y(error)), size)) fill=(fill) fill-opacity=(opacity) stroke=(curve.colour) stroke-width="1.5" {}
            }
        }
    }
}

/// Returns the tooltip of a mark.
fn mark_tooltip(curve: &MethodCurve, row: &AtlasRow, side: &SolverSide) -> String {
    let (method, processor) = (curve.method, curve.processor.name());
    let mut text = format!(
        "{method}, {processor}, at {}: {}",
        format_value(row.value),
        format_error(side, curve.measure)
    );
    if !side.warnings.is_empty() {
        text += &format!("\nwarned: {}", side.warnings.join(", "));
    }
    for line in side.notes.iter().chain(&side.message) {
        text += &format!("\n{line}");
    }
    text
}

/// Draws a cross in the strip for each missing answer, side by side, the CPU's above the GPU's.
fn draw_missing(curves: &[MethodCurve], plot: &CasePlot) -> Markup {
    let crosses = |value: f64, processor: Processor| {
        let of = curves.iter().filter(move |curve| curve.processor == processor);
        let points = of.flat_map(|curve| curve.points.iter().map(move |point| (curve, point)));
        let here = points.filter(move |(_, (row, _))| row.value == value);
        let here: Vec<_> = here.filter(|(_, (_, s))| s.error.is_none()).collect();
        let middle = (here.len() as f64 - 1.0) / 2.0;
        let marks = here.into_iter().enumerate();
        marks.map(move |(k, mark)| ((k as f64 - middle) * 8.0, mark))
    };
    let shift = |processor| {
        if processor == Processor::Cpu { -5.0 } else { 6.0 }
    };
    html! {
        @for value in plot.values { @for processor in Processor::BOTH {
            @for (dx, (curve, (row, side))) in crosses(*value, processor) {
                @let at = (plot.pixel_x(*value) + dx, plot.strip_middle() + shift(processor));
                g.mark {
                    title { (mark_tooltip(curve, row, side)) }
                    path d=(MarkShape::Cross.outline_path(at, 4.5)) fill=(curve.colour) {}
                }
            }
        } }
    }
}

/// Draws the methods' names beside the curves' ends, moved apart where they overlap.
fn draw_names(curves: &[MethodCurve], plot: &CasePlot) -> Markup {
    // The CPU's curve carries the name, or the GPU's if the CPU's ends without an answer.
    let answered = |curve: &&MethodCurve| curve.points.last().is_some_and(|(_, s)| s.error.is_some());
    let mut ends: Vec<(&MethodCurve, (f64, f64))> = Vec::new();
    for curve in curves.iter().filter(answered).chain(curves) {
        if ends.iter().all(|(c, _)| c.method != curve.method) {
            ends.extend(curve.end_pixel(plot).map(|end| (curve, end)));
        }
    }
    ends.sort_by(|a, b| a.1.1.total_cmp(&b.1.1));
    let wanted: Vec<f64> = ends.iter().map(|(_, (_, y))| *y).collect();
    let right = plot.frame.right;
    let lines = spread_lines(&wanted, [plot.frame.top + NAME_HEIGHT / 2.0, plot.frame.bottom]);
    html! {
        @for ((curve, (x, y)), at) in ends.iter().zip(lines) {
            @let leader = path_data([(x + 8.0, *y), (right + 6.0, at), (right + 14.0, at)]);
            (draw_path(&leader, curve.colour, 1.0, 0.6, None))
            path d=(curve.shape.outline_path((right + 20.0, at), 5.0)) fill=(curve.colour) {}
            text x=(right + 29.0) y=(format_pixel(at + 4.0)) { (curve.method) }
        }
    }
}

/// Moves rising positions at least [`NAME_HEIGHT`] apart, within `top` and `bottom`.
fn spread_lines(wanted: &[f64], [top, bottom]: [f64; 2]) -> Vec<f64> {
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

#[cfg(test)]
mod tests {
    use super::super::fixture::{make_row, make_side, make_study};
    use super::*;
    use approx::abs_diff_eq;

    #[test]
    fn methods_differ_in_colour_or_mark() {
        let looks: Vec<_> = (0..2 * CURVE_COLOURS.len())
            .map(|k| (method_colour(k), method_shape(k)))
            .collect();
        for (k, look) in looks.iter().enumerate() {
            assert!(!looks[..k].contains(look), "{k}: {look:?}");
            assert_ne!(look.1, MarkShape::Cross);
        }
    }

    #[test]
    fn harder_values_lie_to_the_right_in_either_order() {
        let near = |a: Vec<f64>, b: &[f64]| {
            assert!(
                a.iter().zip(b).all(|(a, b)| abs_diff_eq!(a, b, epsilon = 1e-12)),
                "{a:?}"
            );
        };
        near(value_places(&[1.0, 0.1, 0.001]), &[0.0, 1.0 / 3.0, 1.0]);
        near(value_places(&[1.0, 10.0, 100.0]), &[0.0, 0.5, 1.0]);
        near(value_places(&[0.0, 10.0, 15.0]), &[0.0, 0.5, 1.0]);
        let crowded = [0.01, 0.1, 0.5, 0.9, 0.99];
        near(value_places(&crowded), &[0.0, 0.25, 0.5, 0.75, 1.0]);
        near(value_places(&[7.0]), &[0.5]);
        assert!(value_places(&[]).is_empty());
    }

    #[test]
    fn missing_and_nan_errors_are_drawn() {
        let rows = vec![
            make_row(0.1, make_side(Some(0.0), ""), None),
            make_row(0.01, make_side(None, ""), Some(make_side(Some(1e9), "thin"))),
            make_row(0.001, make_side(Some(f64::NAN), ""), Some(make_side(None, ""))),
        ];
        let svg = draw_case(&make_study("one", rows), &["default", "not run"]).unwrap();
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        // Five results, two of them without an answer.
        assert_eq!(svg.matches("<g class=\"mark\">").count(), 5);
        // One of them with a warning.
        assert_eq!(svg.matches("fill=\"var(--card)\"").count(), 1);
        let nothing = vec![make_row(0.1, make_side(None, ""), None)];
        assert!(draw_case(&make_study("one", nothing), &["default"]).is_some());
        assert_eq!(draw_case(&make_study("one", Vec::new()), &["default"]), None);
    }

    #[test]
    fn names_are_at_least_a_line_apart() {
        let places = spread_lines(&[5.0, 6.0, 7.0, 100.0, 199.0, 200.0], [8.0, 200.0]);
        assert!(places.windows(2).all(|w| w[1] - w[0] >= NAME_HEIGHT - 1e-9));
        assert!(places[0] >= 8.0 && places[5] <= 200.0);
        assert_eq!(places[3], 100.0);
    }
}
