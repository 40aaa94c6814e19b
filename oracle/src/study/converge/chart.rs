//! A sweep's charts: error and seconds against the parameter, both axes logarithmic.

use super::{MeasuredSweep, Point};
use crate::show::chart::{Label, mesh, share, svg_of};
use plotters::prelude::*;

/// Size in CSS pixels; the page scales it.
const SIZE: (u32, u32) = (520, 330);
/// The curves' colours, told apart on white and on black.
const COLOURS: [RGBColor; 6] = [
    RGBColor(43, 123, 186),
    RGBColor(224, 123, 0),
    RGBColor(44, 150, 80),
    RGBColor(160, 90, 190),
    RGBColor(205, 60, 60),
    RGBColor(130, 130, 130),
];

/// The colour of curve `k`.
pub fn colour(k: usize) -> RGBColor {
    COLOURS[k % COLOURS.len()]
}

/// Error against the parameter; none when no error is above 0.
pub fn errors(sweep: &MeasuredSweep) -> Option<String> {
    draw(sweep, "relative RMS (log)", &share, |point| point.error)
}

/// Seconds against the parameter.
pub fn seconds(sweep: &MeasuredSweep) -> Option<String> {
    let label = |y: &f64| crate::show::report::number::number(*y);
    draw(sweep, "seconds (log)", &label, |point| point.seconds)
}

fn draw(
    sweep: &MeasuredSweep,
    y_name: &str,
    y_label: Label,
    size: impl Fn(&Point) -> f64,
) -> Option<String> {
    let curves: Vec<Vec<(f64, f64)>> = sweep
        .curves
        .iter()
        .map(|curve| {
            let points = curve.points.iter().map(|point| (point.value, size(point)));
            points.filter(|(_, y)| *y > 0.0 && y.is_finite()).collect()
        })
        .collect();
    let all = || curves.iter().flatten();
    let mut values: Vec<f64> = all().map(|p| p.0).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let (low, high) = (*values.first()?, *values.last()?);
    let bottom = all().map(|p| p.1).fold(f64::INFINITY, f64::min) * 0.7;
    let top = all().map(|p| p.1).fold(0.0, f64::max) * 1.4;
    let x = (low * 0.85..high * 1.15)
        .log_scale()
        .with_key_points(values);
    let y = (bottom..top)
        .log_scale()
        .with_key_points(ticks(bottom, top));
    let x_label = |x: &f64| crate::show::report::number::number(*x);
    svg_of(SIZE, |area| {
        let mut chart = ChartBuilder::on(area)
            .margin(10)
            .margin_right(24)
            .x_label_area_size(44)
            .y_label_area_size(74)
            .build_cartesian_2d(x, y)?;
        mesh(&mut chart, sweep.option, y_name, &x_label, y_label)?;
        for (k, curve) in curves.iter().enumerate() {
            let line = LineSeries::new(curve.iter().copied(), colour(k).stroke_width(2));
            chart.draw_series(line)?;
            let dots = curve
                .iter()
                .map(|point| Circle::new(*point, 4, colour(k).filled()));
            chart.draw_series(dots)?;
        }
        Ok(())
    })
}

/// 1, 2 and 5 × 10ⁿ where they fit, powers of ten alone over many decades.
pub(crate) fn ticks(low: f64, high: f64) -> Vec<f64> {
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
