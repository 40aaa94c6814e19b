//! Estimate against error, both logarithmic.

use super::Findings;
use super::ratio::{FLOOR, HIGH, LOW};
use crate::show::chart::{Axis, CPU, GPU, Shape, line, share, svg};
use crate::study::stress::outcome::{Half, sides};
use crate::study::stress::{SAFE, Side};
use maud::html;

/// CSS pixels; the page scales them.
const SIZE: (u32, u32) = (720, 520);
/// Both axes; what lies beyond is drawn on their ends.
const ENDS: [f64; 2] = [1e-4, 1.0];
const GREY: &str = "#808080";

/// A mark for each answer that has an estimate; none where there are none.
pub fn svg_of(findings: &Findings) -> Option<String> {
    let all = findings.all.iter().flat_map(|found| sides(&found.row));
    let place = |(half, side): (Half, &Side)| {
        let [x, y] = [side.error?, side.estimate?].map(|e| e.clamp(ENDS[0], ENDS[1]));
        Some((half, !side.warned() && x > SAFE, (x, y)))
    };
    let mut marks: Vec<(Half, bool, (f64, f64))> = all.filter_map(place).collect();
    if marks.is_empty() {
        return None;
    }
    // The GPU's upon the CPU's.
    marks.sort_by_key(|(half, ..)| *half == Half::Gpu);
    let [a, b] = ENDS;
    let x = Axis::log("true error (log)", ENDS, &share);
    let y = Axis::log("estimated error (log)", ENDS, &share);
    svg(SIZE, 24, [&x, &y], |frame| {
        // From one end of the axes to the other.
        let slope = |ratio: f64| {
            let ends = [a.max(a / ratio), b.min(b / ratio)];
            frame.path(ends.map(|x| (x, x * ratio)))
        };
        html! {
            @for (ratio, width) in [(1.0, 2.0), (LOW, 1.0), (HIGH, 1.0)] { (line(&slope(ratio), GREY, width, 1.0, None)) }
            @for x in [FLOOR, SAFE] { (line(&frame.path([(x, a), (x, b)]), GREY, 1.0, 1.0, Some("3 4"))) }
            @for (half, silent, (x, y)) in &marks {
                @let colour = if *half == Half::Cpu { CPU } else { GPU };
                path d=(Shape::Circle.path((frame.x(*x), frame.y(*y)), if *silent { 6.0 } else { 4.0 }))
                    fill=(if *silent { colour } else { "none" }) stroke=(colour) stroke-width="2" {}
            }
        }
    })
}
