//! The response curves.

use crate::merge::brackets::Response;
use crate::show::chart::{mesh, svg_of};
use plotters::prelude::*;
use std::f64::consts::LN_2;

/// Size in CSS pixels; the page scales it.
const SIZE: (u32, u32) = (720, 380);
/// Red, green and blue, told apart on white and on black; the page's key has them too.
pub const COLOURS: [RGBColor; 3] = [
    RGBColor(205, 60, 60),
    RGBColor(44, 150, 80),
    RGBColor(43, 123, 186),
];

/// Code against exposure (stops from that of code 128), as Debevec and Malik draw it.
pub fn curves(response: &Response) -> Option<String> {
    let points = |curve: &[f64; 256]| -> Vec<(f64, f64)> {
        let stops = curve.iter().map(|g| g / LN_2);
        stops.zip((0..=255).map(f64::from)).collect()
    };
    let curves = response.curves.each_ref().map(points);
    let stops = || curves.iter().flatten().map(|p| p.0);
    let low = stops().fold(f64::INFINITY, f64::min).floor();
    let high = stops().fold(f64::NEG_INFINITY, f64::max).ceil();
    svg_of(SIZE, |area| {
        let mut chart = ChartBuilder::on(area)
            .margin(10)
            .margin_right(24)
            .x_label_area_size(44)
            .y_label_area_size(74)
            .build_cartesian_2d(low..high, 0.0..256.0)?;
        mesh(
            &mut chart,
            "exposure E Δt, stops from that of code 128",
            "code",
            &|x| format!("{x:.0}").replace('-', "−"),
            &|y| format!("{y:.0}"),
        )?;
        for (curve, colour) in curves.iter().zip(COLOURS) {
            let line = LineSeries::new(curve.iter().copied(), colour.stroke_width(2));
            chart.draw_series(line)?;
        }
        Ok(())
    })
}
