//! Charts as inline SVG: no files, no fonts, no network; text takes the page's colour.

use common::shooting::Run;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::element::DashedPathElement;
use plotters::prelude::*;

/// Drawn in this, text and axes become the page's own colour.
const INK: RGBColor = RGBColor(1, 2, 3);
/// The CPU's colour, here and in the tables.
pub const CPU: RGBColor = RGBColor(43, 123, 186);
/// The GPU's colour.
pub const GPU: RGBColor = RGBColor(224, 123, 0);
/// Size in CSS pixels; the page scales it.
const SIZE: (u32, u32) = (720, 340);
/// A curve is thinned out to about this many points.
const POINTS: usize = 800;

/// What is drawn on.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Whether it could be drawn.
pub(crate) type Drawn = Result<(), Box<dyn std::error::Error>>;

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
    let low = points()
        .map(|p| p.1)
        .chain(stop)
        .fold(0.5, f64::min)
        .max(1e-12);
    let high = points().map(|p| p.1).fold(1.0, f64::max).min(1e12);
    svg(|area| {
        let mut chart = ChartBuilder::on(area)
            .margin(10)
            .margin_right(24)
            .x_label_area_size(44)
            .y_label_area_size(74)
            .build_cartesian_2d(0.0..shots, (low * 0.7..high * 1.2).log_scale())?;
        mesh(
            &mut chart,
            "shots",
            "unshot ÷ emitted power (log)",
            &|x| format!("{x:.0}"),
            &share,
        )?;
        let [cpu, gpu] = curves.clone();
        let style = CPU.mix(0.85).stroke_width(5);
        chart
            .draw_series(LineSeries::new(cpu, style))?
            .label(" CPU, rays")
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 26, y)], style));
        // Thin and dashed upon thick: both are seen where they agree.
        let style = GPU.stroke_width(2);
        chart
            .draw_series(DashedLineSeries::new(gpu, 9, 6, style))?
            .label(" GPU, item buffer")
            .legend(move |(x, y)| DashedPathElement::new([(x, y), (x + 26, y)], 9, 6, style));
        if let Some(stop) = stop {
            let style = INK.mix(0.6).stroke_width(1);
            let line = [(0.0, stop), (shots, stop)];
            chart
                .draw_series(DashedLineSeries::new(line, 2, 4, style))?
                .label(format!(" stop: ε = {}", share(&stop)))
                .legend(move |(x, y)| DashedPathElement::new([(x, y), (x + 26, y)], 2, 4, style));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .label_font(("sans-serif", 15).into_font().color(&INK))
            .legend_area_size(32)
            .draw()?;
        Ok(())
    })
}

/// A share as the axis names it.
pub(crate) fn share(y: &f64) -> String {
    let digits = (-(100.0 * y).log10().floor()).clamp(0.0, 10.0) as usize;
    format!("{:.digits$} %", 100.0 * y)
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
    // Logarithmic, so that one pair far away shows beside thousands near; the axis begins at ½.
    let range = (0.5..most as f64 * 2.0).log_scale();
    svg(|area| {
        let mut chart = ChartBuilder::on(area)
            .margin(10)
            .margin_right(24)
            .x_label_area_size(44)
            .y_label_area_size(74)
            .build_cartesian_2d(0.0..width, range)?;
        let x = "distance to the nearest ID boundary, pixels";
        mesh(
            &mut chart,
            x,
            "mismatched pairs (log)",
            &|x| format!("{x:.1}"),
            &|y| format!("{y:.0}"),
        )?;
        let bars = histogram[..used]
            .iter()
            .enumerate()
            .filter(|(_, count)| **count > 0);
        chart.draw_series(bars.map(|(k, count)| {
            let corners = [(k as f64 / 2.0, 0.5), ((k + 1) as f64 / 2.0, *count as f64)];
            let mut bar = Rectangle::new(corners, GPU.mix(0.75).filled());
            bar.set_margin(0, 0, 1, 1);
            bar
        }))?;
        Ok(())
    })
}

/// What an axis writes at a value.
pub(crate) type Label<'a> = &'a dyn Fn(&f64) -> String;

/// Axes, their names and a faint grid.
pub(crate) fn mesh<'a, X, Y>(
    chart: &mut ChartContext<'a, SVGBackend<'a>, Cartesian2d<X, Y>>,
    x_name: &str,
    y_name: &str,
    x_label: Label,
    y_label: Label,
) -> Drawn
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    chart
        .configure_mesh()
        .x_desc(x_name)
        .y_desc(y_name)
        .x_label_formatter(x_label)
        .y_label_formatter(y_label)
        .y_labels(8)
        .axis_style(INK.mix(0.7))
        .bold_line_style(INK.mix(0.15))
        .light_line_style(INK.mix(0.04))
        .axis_desc_style(("sans-serif", 15).into_font().color(&INK))
        .label_style(("sans-serif", 13).into_font().color(&INK))
        .draw()?;
    Ok(())
}

/// The SVG element, scaled by the page and in its colours.
fn svg(draw: impl FnOnce(&Area) -> Drawn) -> Option<String> {
    svg_of(SIZE, draw)
}

/// The same in another size (CSS pixels).
pub(crate) fn svg_of((w, h): (u32, u32), draw: impl FnOnce(&Area) -> Drawn) -> Option<String> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, (w, h)).into_drawing_area();
        draw(&area).ok()?;
        area.present().ok()?;
    }
    let inner = &text[text.find('>')? + 1..];
    let open = format!(r#"<svg role="img" class="chart" viewBox="0 0 {w} {h}">"#);
    Some(open + &inner.replace("#010203", "currentColor"))
}
