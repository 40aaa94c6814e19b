//! The charts of a comparison.

use crate::show::chart::{Axis, CPU, GPU, legend, line, path, px, share, svg};
use common::shooting::Run;
use maud::html;

/// CSS pixels; the page scales them.
const SIZE: (u32, u32) = (720, 340);
/// A curve is thinned out to about this many points.
const POINTS: usize = 800;

/// Unshot power over emitted power after each shot, both free runs, and where they stop.
/// None when there is nothing to draw.
pub fn convergence(cpu: &Run, gpu: &Run, epsilon: f64) -> Option<String> {
    let curves = [curve(cpu), curve(gpu)];
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
    let x = Axis::even("shots", [0.0, shots], &count);
    let y = Axis {
        log: true,
        ..Axis::even(
            "unshot ÷ emitted power (log)",
            [low * 0.7, high * 1.2],
            &share,
        )
    };
    svg(SIZE, 24, [&x, &y], |frame| {
        let [cpu, gpu] = curves.clone().map(|curve| frame.path(curve));
        // Thin and dashed upon thick: both are seen where they agree.
        let mut lines = vec![
            ("CPU, rays".to_owned(), cpu, (CPU, 5.0, 0.85, None)),
            (
                "GPU, item buffer".to_owned(),
                gpu,
                (GPU, 2.0, 1.0, Some("9 6")),
            ),
        ];
        lines.extend(stop.map(|stop| {
            let path = frame.path([(0.0, stop), (shots, stop)]);
            let style = ("currentColor", 1.0, 0.6, Some("2 4"));
            (format!("stop: ε = {}", share(&stop)), path, style)
        }));
        let sample = path([(0.0, 0.0), (26.0, 0.0)]);
        let rows = lines
            .iter()
            .map(|(name, _, (c, w, o, d))| (line(&sample, c, *w, *o, *d), name));
        html! {
            @for (_, data, (c, w, o, d)) in &lines { (line(data, c, *w, *o, *d)) }
            (legend((frame.right - 170.0, frame.top + 16.0), 32.0, rows))
        }
    })
}

/// (shots, unshot fraction); what has no logarithm is left out.
fn curve(run: &Run) -> Vec<(f64, f64)> {
    let emitted = f64::from(run.emitted);
    let unshot = run
        .shots
        .iter()
        .map(|shot| f64::from(shot.unshot) / emitted);
    let all: Vec<(f64, f64)> = std::iter::once(1.0)
        .chain(unshot)
        .enumerate()
        .map(|(k, y)| (k as f64, y))
        .filter(|(_, y)| y.is_finite() && *y > 0.0)
        .collect();
    let step = all.len().div_ceil(POINTS).max(1);
    let last = all.last().copied();
    let mut thinned: Vec<(f64, f64)> = all.iter().copied().step_by(step).collect();
    thinned.extend(last.filter(|last| thinned.last() != Some(last)));
    thinned
}

/// How many mismatched pairs lie how far from an ID boundary: bin k is [k/2, (k+1)/2) pixels.
/// None when there is no mismatch.
pub fn mismatches(histogram: &[u64]) -> Option<String> {
    let most = histogram.iter().copied().max().filter(|most| *most > 0)?;
    let used = histogram.iter().rposition(|count| *count > 0)? + 1;
    let width = used.max(6) as f64 / 2.0;
    let [pixels, count] = [1, 0].map(|digits| move |x: &f64| format!("{x:.digits$}"));
    let x = Axis::even(
        "distance to the nearest ID boundary, pixels",
        [0.0, width],
        &pixels,
    );
    // Logarithmic, so that one pair far away shows beside thousands near; the axis begins at ½.
    let y = Axis {
        log: true,
        ..Axis::even("mismatched pairs (log)", [0.5, most as f64 * 2.0], &count)
    };
    svg(SIZE, 24, [&x, &y], |frame| {
        let bars = histogram[..used]
            .iter()
            .enumerate()
            .filter(|(_, n)| **n > 0);
        html! {
            @for (k, n) in bars {
                @let [left, right] = [k, k + 1].map(|k| frame.x(k as f64 / 2.0));
                @let top = frame.y(*n as f64);
                rect x=(px(left + 1.0)) y=(px(top)) width=(px(right - left - 2.0)) height=(px(frame.bottom - top))
                    fill=(GPU) fill-opacity=".75" {}
            }
        }
    })
}
