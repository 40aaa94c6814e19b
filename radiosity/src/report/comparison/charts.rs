//! Draws the charts of a comparison: unshot power against shots, and the histogram of visibility mismatches.

use crate::report::chart::{
    Axis, CPU_COLOUR, GPU_COLOUR, draw_legend, draw_path, format_pixel, format_share, path_data, render_svg,
};
use common::shooting::SolveRun;
use maud::html;

/// Width and height in CSS pixels; the page scales them.
const CHART_SIZE: (u32, u32) = (720, 340);
/// Approximate maximum number of points per curve.
const MAX_CURVE_POINTS: usize = 800;

/// Draws unshot power over emitted power after each shot of both free runs, and the stopping threshold `epsilon`.
/// None without shots.
pub fn convergence_chart(cpu: &SolveRun, gpu: &SolveRun, epsilon: f64) -> Option<String> {
    let curves = [unshot_curve(cpu), unshot_curve(gpu)];
    let points = || curves.iter().flatten();
    let shots = points().map(|p| p.0).fold(0.0, f64::max);
    if shots < 1.0 {
        return None;
    }
    let stop = Some(epsilon).filter(|e| e.is_finite() && *e > 0.0 && *e < 1.0);
    let sizes = points().map(|p| p.1).chain(stop);
    let low = sizes.fold(0.5, f64::min).max(1e-12);
    let high = points().map(|p| p.1).fold(1.0, f64::max).min(1e12);
    let count = |x: &f64| format!("{x:.0}");
    let x = Axis::linear_scale("shots", [0.0, shots], &count);
    let y = Axis {
        log: true,
        ..Axis::linear_scale("unshot ÷ emitted power (log)", [low * 0.7, high * 1.2], &format_share)
    };
    render_svg(CHART_SIZE, 24, [&x, &y], |frame| {
        let [cpu, gpu] = curves.clone().map(|curve| frame.plot_path(curve));
        // A thin dashed line over a thick one: both are visible where they agree.
        let mut lines = vec![
            ("CPU, rays".to_owned(), cpu, (CPU_COLOUR, 5.0, 0.85, None)),
            ("GPU, item buffer".to_owned(), gpu, (GPU_COLOUR, 2.0, 1.0, Some("9 6"))),
        ];
        lines.extend(stop.map(|stop| {
            let path = frame.plot_path([(0.0, stop), (shots, stop)]);
            let style = ("currentColor", 1.0, 0.6, Some("2 4"));
            (format!("stop: ε = {}", format_share(&stop)), path, style)
        }));
        let sample = path_data([(0.0, 0.0), (26.0, 0.0)]);
        let rows = lines
            .iter()
            .map(|(name, _, (c, w, o, d))| (draw_path(&sample, c, *w, *o, *d), name));
        html! {
            @for (_, data, (c, w, o, d)) in &lines { (draw_path(data, c, *w, *o, *d)) }
            (draw_legend((frame.right - 170.0, frame.top + 16.0), 32.0, rows))
        }
    })
}

/// Returns (shots, unshot fraction), without values that have no logarithm.
fn unshot_curve(run: &SolveRun) -> Vec<(f64, f64)> {
    let emitted = f64::from(run.emitted);
    let unshot = run.shots.iter().map(|shot| f64::from(shot.unshot) / emitted);
    let all: Vec<(f64, f64)> = std::iter::once(1.0)
        .chain(unshot)
        .enumerate()
        .map(|(k, y)| (k as f64, y))
        .filter(|(_, y)| y.is_finite() && *y > 0.0)
        .collect();
    let step = all.len().div_ceil(MAX_CURVE_POINTS).max(1);
    let last = all.last().copied();
    let mut thinned: Vec<(f64, f64)> = all.iter().copied().step_by(step).collect();
    thinned.extend(last.filter(|last| thinned.last() != Some(last)));
    thinned
}

/// Draws the number of mismatched pairs against the distance from an ID boundary: bin k is [k/2, (k+1)/2) pixels.
/// None without a mismatch.
pub fn mismatch_chart(histogram: &[u64]) -> Option<String> {
    let most = histogram.iter().copied().max().filter(|most| *most > 0)?;
    let used = histogram.iter().rposition(|count| *count > 0)? + 1;
    let width = used.max(6) as f64 / 2.0;
    let [pixels, count] = [1, 0].map(|digits| move |x: &f64| format!("{x:.digits$}"));
    let x = Axis::linear_scale("distance to the nearest ID boundary, pixels", [0.0, width], &pixels);
    // Logarithmic, so that one distant pair shows beside thousands of near ones; the axis begins at ½.
    let y = Axis {
        log: true,
        ..Axis::linear_scale("mismatched pairs (log)", [0.5, most as f64 * 2.0], &count)
    };
    render_svg(CHART_SIZE, 24, [&x, &y], |frame| {
        let bars = histogram[..used].iter().enumerate().filter(|(_, n)| **n > 0);
        html! {
            @for (k, n) in bars {
                @let [left, right] = [k, k + 1].map(|k| frame.x_pixel(k as f64 / 2.0));
                @let top = frame.y_pixel(*n as f64);
                rect x=(format_pixel(left + 1.0)) y=(format_pixel(top)) width=(format_pixel(right - left - 2.0)) height=(format_pixel(frame.bottom - top))
                    fill=(GPU_COLOUR) fill-opacity=".75" {}
            }
        }
    })
}
