//! A sweep's charts: error and seconds against the parameter, both axes logarithmic.

use super::{MeasuredSweep, Point};
use crate::show::chart::{Axis, COLOURS, Label, MARKS, line, share, svg};
use crate::show::number::number;
use maud::{Markup, html};

/// CSS pixels; the page scales them.
const SIZE: (u32, u32) = (520, 330);

/// The colour of curve `k`.
fn colour(k: usize) -> &'static str {
    COLOURS[k % COLOURS.len()]
}

/// The mark of curve `k` about a pixel.
fn mark(k: usize, at: (f64, f64), size: f64) -> Markup {
    html! { path d=(MARKS[k % MARKS.len()].path(at, size)) fill=(colour(k)) {} }
}

/// Colour, mark and name of curve `k` beside its chart.
pub fn key(k: usize, name: &str) -> Markup {
    html! { span.key {
        svg.inline viewBox="0 0 26 16" aria-hidden="true" {
            (line("M0 8H26", colour(k), 2.0, 1.0, None)) (mark(k, (13.0, 8.0), 5.0))
        }
        (name)
    } }
}

/// Error against the parameter; none when no error is above 0.
pub fn errors(sweep: &MeasuredSweep) -> Option<String> {
    draw(sweep, "relative RMS (log)", &share, |point| point.error)
}

/// Seconds against the parameter.
pub fn seconds(sweep: &MeasuredSweep) -> Option<String> {
    draw(sweep, "seconds (log)", &|y| number(*y), |p| p.seconds)
}

fn draw(
    sweep: &MeasuredSweep,
    name: &str,
    label: Label,
    size: impl Fn(&Point) -> f64,
) -> Option<String> {
    let curve = |points: &[Point]| -> Vec<(f64, f64)> {
        let points = points.iter().map(|point| (point.value, size(point)));
        points.filter(|(_, y)| *y > 0.0 && y.is_finite()).collect()
    };
    let curves: Vec<_> = sweep.curves.iter().map(|c| curve(&c.points)).collect();
    let all = || curves.iter().flatten();
    let mut values: Vec<f64> = all().map(|p| p.0).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let (low, high) = (*values.first()?, *values.last()?);
    let bottom = all().map(|p| p.1).fold(f64::INFINITY, f64::min) * 0.7;
    let top = all().map(|p| p.1).fold(0.0, f64::max) * 1.4;
    let value = |x: &f64| number(*x);
    let x = Axis {
        ticks: Some(values),
        ..Axis::log(sweep.option, [low * 0.85, high * 1.15], &value)
    };
    let y = Axis::log(name, [bottom, top], label);
    svg(SIZE, 24, [&x, &y], |frame| {
        html! {
            @for (k, curve) in curves.iter().enumerate() {
                // A curve without a point has no path either.
                @if !curve.is_empty() { (line(&frame.path(curve.iter().copied()), colour(k), 2.0, 1.0, None)) }
                @for (x, y) in curve { (mark(k, (frame.x(*x), frame.y(*y)), 4.5)) }
            }
        }
    })
}
