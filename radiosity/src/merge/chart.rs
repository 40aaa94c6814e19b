//! Draws the camera's response curves.

use crate::merge::brackets::CameraResponse;
use crate::report::chart::{Axis, CPU_COLOUR, draw_path, render_svg};
use maud::html;
use std::f64::consts::LN_2;

/// Width and height in CSS pixels; the page scales them.
const CHART_SIZE: (u32, u32) = (720, 380);
/// Colours of the red, green and blue curves, distinguishable on white and on black.
pub const CHANNEL_COLOURS: [&str; 3] = ["#cd3c3c", "#2c9650", CPU_COLOUR];

/// Draws code against exposure (stops from that of code 128), as in Debevec and Malik 1997.
pub fn render_response_chart(response: &CameraResponse) -> Option<String> {
    let points = |curve: &[f64; 256]| -> Vec<(f64, f64)> {
        let stops = curve.iter().map(|g| g / LN_2);
        stops.zip((0..=255).map(f64::from)).collect()
    };
    let curves = response.curves.each_ref().map(points);
    let stops = || curves.iter().flatten().map(|p| p.0);
    let low = stops().fold(f64::INFINITY, f64::min).floor();
    let high = stops().fold(f64::NEG_INFINITY, f64::max).ceil();
    let [stops, code] = [1, 1].map(|_| |x: &f64| format!("{x:.0}").replace('-', "−"));
    let x = Axis::linear_scale("exposure E Δt, stops from that of code 128", [low, high], &stops);
    let y = Axis::linear_scale("code", [0.0, 256.0], &code);
    render_svg(CHART_SIZE, 24, [&x, &y], |frame| {
        html! {
            @for (curve, colour) in curves.iter().zip(CHANNEL_COLOURS) {
                (draw_path(&frame.plot_path(curve.iter().copied()), colour, 2.0, 1.0, None))
            }
        }
    })
}
