//! The response curves.

use crate::merge::brackets::Response;
use crate::show::chart::{Axis, CPU, line, svg};
use maud::html;
use std::f64::consts::LN_2;

/// CSS pixels; the page scales them.
const SIZE: (u32, u32) = (720, 380);
/// Red, green and blue, told apart on white and on black; the page's key has them too.
pub const COLOURS: [&str; 3] = ["#cd3c3c", "#2c9650", CPU];

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
    let [stops, code] = [1, 1].map(|_| |x: &f64| format!("{x:.0}").replace('-', "−"));
    let x = Axis::even(
        "exposure E Δt, stops from that of code 128",
        [low, high],
        &stops,
    );
    let y = Axis::even("code", [0.0, 256.0], &code);
    svg(SIZE, 24, [&x, &y], |frame| {
        html! {
            @for (curve, colour) in curves.iter().zip(COLOURS) {
                (line(&frame.path(curve.iter().copied()), colour, 2.0, 1.0, None))
            }
        }
    })
}
