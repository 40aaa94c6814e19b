//! Error over a case's parameter, both logarithmic, harder to the right.

mod curves;

use crate::show::chart::{Axis, COLOURS, Frame, MARKS, Shape, line, path, px, share, svg, ticks};
use crate::study::stress::outcome::{amount, values};
use crate::study::stress::{LEAK, Side, Study, outcome};
use curves::curves;
use maud::{Markup, html};

/// CSS pixels; the page scales them.
const SIZE: (u32, u32) = (860, 470);
/// The width left for the curves' names.
const NAMES: u32 = 156;
/// The strip on top for what has no answer, as a share of the axis.
const STRIP: f64 = 0.12;
/// Errors beyond these lie on the axis' ends; in the limit of what is safe.
const ERRORS: [f64; 2] = [1e-5, 1e5];
/// The axis shows at least so much around both limits.
const AROUND: f64 = 3.0;
/// Closest labels of the parameter's axis, as a share of it.
const TICKS: f64 = 0.085;

/// The colour of method `k`; the first has the page's own.
pub fn colour(k: usize) -> &'static str {
    k.checked_sub(1)
        .map_or("currentColor", |k| COLOURS[k % COLOURS.len()])
}

/// Its mark, which no other method of this colour has, since they are one fewer; a cross means that there is no answer.
pub fn shape(k: usize) -> Shape {
    let marks = MARKS.iter().filter(|mark| **mark != Shape::Cross);
    let marks: Vec<Shape> = marks.copied().collect();
    marks[k % marks.len()]
}

/// Where everything lies.
pub struct Plot<'a> {
    /// The values, in order of severity.
    pub values: &'a [f64],
    places: &'a [f64],
    /// Without the strip.
    errors: [f64; 2],
    /// Up to here an error is safe, and from there on it fails.
    limits: [f64; 2],
    /// The axes.
    pub frame: &'a Frame<'a>,
}

impl Plot<'_> {
    /// The pixel of a value.
    pub fn x(&self, value: f64) -> f64 {
        let at = self.values.iter().position(|v| *v == value).unwrap_or(0);
        self.frame.x(self.places.get(at).copied().unwrap_or(0.5))
    }

    /// The pixel of an error.
    pub fn y(&self, error: f64) -> f64 {
        let [low, high] = self.errors;
        // What is no number is as wrong as can be.
        self.frame.y(if error.is_nan() {
            high
        } else {
            error.clamp(low, high)
        })
    }

    /// The middle of the strip.
    pub fn strip(&self) -> f64 {
        (self.frame.top + self.y(self.errors[1])) / 2.0
    }
}

/// The parameter's axis goes from before the first value to beyond the last: there the limits are
/// named.
const ENDS: [f64; 2] = [-0.04, 1.09];

/// Closest values of a logarithmic axis, in even steps.
const CLOSEST: f64 = 0.25;

/// The values on 0…1: logarithmic where that keeps them apart, else in even steps.
fn places(values: &[f64]) -> Vec<f64> {
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
    if places.windows(2).any(|w| w[1] - w[0] < CLOSEST * step) {
        return even();
    }
    places
}

/// From the least to the greatest error, with room around them.
fn range<'a>(sides: impl Iterator<Item = &'a Side>, limits: [f64; 2]) -> [f64; 2] {
    let errors = sides.filter_map(|side| side.error);
    let errors = errors.filter(|error| error.is_finite() && *error > 0.0);
    let shown = [limits[0] / AROUND, limits[1] * AROUND];
    let [low, high] = errors.fold(shown, |[low, high], error| {
        [low.min(error * 0.6), high.max(error * 1.7)]
    });
    let ends = ERRORS.map(|end| end * limits[0]);
    [low.max(ends[0]), high.min(ends[1])]
}

/// The chart; none when there is nothing to draw.
pub fn drawn(study: &Study, methods: &[&'static str]) -> Option<String> {
    if study.rows.is_empty() {
        return None;
    }
    let (values, measure) = (values(study), study.about.measure);
    let limits = super::limits(measure);
    let sides = study.rows.iter().flat_map(outcome::sides);
    let errors = range(sides.map(|(_, side)| side), limits);
    let strip = (errors[1] / errors[0]).powf(STRIP);
    let places = places(&values);
    let mut shown: Vec<f64> = Vec::new();
    for place in &places {
        if shown.last().is_none_or(|last| place - last > TICKS) {
            shown.push(*place);
        }
    }
    let named = |x: &f64| {
        let at = places.iter().position(|place| place == x);
        at.map_or(String::new(), |k| outcome::value(values[k]))
    };
    let parameter = format!("{} → harder", study.about.parameter);
    let error = format!("{measure} (log)");
    let told = |error: &f64| match measure {
        LEAK => outcome::value(*error),
        _ => share(error),
    };
    let x = Axis {
        ticks: Some(shown),
        ..Axis::even(&parameter, ENDS, &named)
    };
    let y = Axis {
        ticks: Some(ticks(errors[0], errors[1])),
        ..Axis::log(&error, [errors[0], errors[1] * strip], &told)
    };
    svg(SIZE, NAMES, [&x, &y], |frame| {
        let plot = Plot {
            values: &values,
            places: &places,
            errors,
            limits,
            frame,
        };
        html! { (zones(&plot)) (curves(study, methods, &plot)) (names(&plot, measure)) }
    })
}

/// Both limits, what lies beyond them shaded, and the strip.
fn zones(plot: &Plot) -> Markup {
    let Frame {
        left, top, right, ..
    } = *plot.frame;
    let [safe, degraded] = plot.limits.map(|limit| plot.y(limit));
    let strip = plot.y(plot.errors[1]);
    let shade = |from: f64, to: f64, class: &str| {
        html! { rect class=(class) x=(left) y=(px(to)) width=(right - left) height=(px((from - to).max(0.0))) {} }
    };
    let across = |y: f64| path([(left, y), (right, y)]);
    html! {
        (shade(safe, degraded, "zone-degrades"))
        (shade(degraded, top, "zone-fails"))
        @for y in [safe, degraded] { (line(&across(y), "currentColor", 1.2, 0.75, None)) }
        (line(&across(strip), "currentColor", 1.0, 1.0, Some("2 4")))
        text x=(left - 8.0) y=(px((top + strip) / 2.0 + 4.0)) text-anchor="end" { "no answer" }
    }
}

/// What the limits are, upon everything else.
fn names(plot: &Plot, measure: &str) -> Markup {
    let x = plot.frame.right - 4.0;
    html! {
        @for limit in plot.limits {
            text.over x=(x) y=(px(plot.y(limit) - 4.0)) text-anchor="end" { (amount(measure, limit)) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{row, side, study};
    use super::*;
    use approx::abs_diff_eq;

    #[test]
    fn no_two_methods_look_alike() {
        let looks: Vec<_> = (0..2 * COLOURS.len())
            .map(|k| (colour(k), shape(k)))
            .collect();
        for (k, look) in looks.iter().enumerate() {
            assert!(!looks[..k].contains(look), "{k}: {look:?}");
            assert_ne!(look.1, Shape::Cross);
        }
    }

    #[test]
    fn harder_is_to_the_right_whichever_way_the_values_go() {
        let near = |a: Vec<f64>, b: &[f64]| {
            assert!(
                a.iter()
                    .zip(b)
                    .all(|(a, b)| abs_diff_eq!(a, b, epsilon = 1e-12)),
                "{a:?}"
            );
        };
        near(places(&[1.0, 0.1, 0.001]), &[0.0, 1.0 / 3.0, 1.0]);
        near(places(&[1.0, 10.0, 100.0]), &[0.0, 0.5, 1.0]);
        near(places(&[0.0, 10.0, 15.0]), &[0.0, 0.5, 1.0]);
        let crowded = [0.01, 0.1, 0.5, 0.9, 0.99];
        near(places(&crowded), &[0.0, 0.25, 0.5, 0.75, 1.0]);
        near(places(&[7.0]), &[0.5]);
        assert!(places(&[]).is_empty());
    }

    #[test]
    fn missing_values_do_not_break_it() {
        let rows = vec![
            row(0.1, side(Some(0.0), ""), None),
            row(0.01, side(None, ""), Some(side(Some(1e9), "thin"))),
            row(0.001, side(Some(f64::NAN), ""), Some(side(None, ""))),
        ];
        let svg = drawn(&study("one", rows), &["default", "not run"]).unwrap();
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        // Three answers, two of them none.
        assert_eq!(svg.matches("<g class=\"mark\">").count(), 5);
        // One of them warned.
        assert_eq!(svg.matches("fill=\"var(--card)\"").count(), 1);
        let nothing = vec![row(0.1, side(None, ""), None)];
        assert!(drawn(&study("one", nothing), &["default"]).is_some());
        assert_eq!(drawn(&study("one", Vec::new()), &["default"]), None);
    }
}
