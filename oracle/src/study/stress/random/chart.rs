//! Estimate against error, both logarithmic.

use super::Findings;
use super::ratio::{FLOOR, HIGH, LOW};
use crate::show::chart::{CPU, GPU, mesh, share, svg_of};
use crate::study::converge::chart::ticks;
use crate::study::stress::outcome::{Half, sides};
use crate::study::stress::{SAFE, Side};
use plotters::prelude::*;

/// CSS pixels; the page scales them.
const SIZE: (u32, u32) = (720, 520);
/// Both axes; what lies beyond is drawn on their ends.
const ENDS: [f64; 2] = [1e-4, 1.0];

/// A mark for each answer that has an estimate; none where there are none.
pub fn svg(findings: &Findings) -> Option<String> {
    let all = findings.all.iter().flat_map(|found| sides(&found.row));
    let place = |(half, side): (Half, &Side)| {
        let [x, y] = [side.error?, side.estimate?].map(|e| e.clamp(ENDS[0], ENDS[1]));
        Some((half, side.warned(), (x, y)))
    };
    let marks: Vec<(Half, bool, (f64, f64))> = all.filter_map(place).collect();
    if marks.is_empty() {
        return None;
    }
    let [a, b] = ENDS;
    let axis = || (a..b).log_scale().with_key_points(ticks(a, b));
    svg_of(SIZE, |area| {
        let mut chart = ChartBuilder::on(area)
            .margin(10)
            .margin_right(24)
            .x_label_area_size(44)
            .y_label_area_size(74)
            .build_cartesian_2d(axis(), axis())?;
        mesh(
            &mut chart,
            "true error (log)",
            "estimated error (log)",
            &share,
            &share,
        )?;
        let grey = RGBColor(128, 128, 128);
        for (ratio, width) in [(1.0, 2), (LOW, 1), (HIGH, 1)] {
            // From one end of the axes to the other.
            let from = a.max(a / ratio);
            let to = b.min(b / ratio);
            let line = [(from, from * ratio), (to, to * ratio)];
            chart.draw_series(LineSeries::new(line, grey.stroke_width(width)))?;
        }
        for x in [FLOOR, SAFE] {
            let line = [(x, a), (x, b)];
            chart.draw_series(DashedLineSeries::new(line, 3, 4, grey.stroke_width(1)))?;
        }
        for (half, colour) in [(Half::Cpu, CPU), (Half::Gpu, GPU)] {
            let own = marks.iter().filter(|(of, ..)| *of == half);
            chart.draw_series(own.map(|(_, warned, at)| {
                let silent = !warned && at.0 > SAFE;
                let style = if silent {
                    colour.filled()
                } else {
                    colour.stroke_width(2)
                };
                Circle::new(*at, if silent { 6 } else { 4 }, style)
            }))?;
        }
        Ok(())
    })
}
