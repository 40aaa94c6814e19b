//! Content of `stress.html` for random scenes.

use super::gates::format_limits;
use super::ratio::{EstimateRatios, HIGH_RATIO, LOW_RATIO, MIN_JUDGED_ERROR, estimate_ratio};
use super::{RANDOM_CASE, RandomFindings, RandomResult};
use crate::report::chart::{Axis, CPU_COLOUR, GPU_COLOUR, MarkShape, draw_path, format_share, render_svg};
use crate::report::format::{format_duration, format_number, format_percent};
use crate::report::page::{self, Page};
use crate::report::table::{TableRow, number_cell, render_table, text_cell};
use crate::studies::stress::json::AtlasSummary;
use crate::studies::stress::outcome::{Processor, WarningOutcome, format_error, solver_sides, warning_outcome};
use crate::studies::stress::page::{ATLAS_STYLE, gates_table, gates_verdict};
use crate::studies::stress::score::WarningCounts;
use crate::studies::stress::{RELATIVE_RMS, SAFE_ERROR, SolverSide, specimen};
use maud::{Markup, html};

/// Size of the chart, CSS pixels; the page scales it.
const CHART_SIZE: (u32, u32) = (720, 520);
/// Range of both axes; errors beyond are drawn at the ends.
const AXIS_ENDS: [f64; 2] = [1e-4, 1.0];
const GUIDE_COLOUR: &str = "#808080";

/// Returns the page.
pub fn render_page(findings: &RandomFindings, ratios: &EstimateRatios, summary: &AtlasSummary) -> String {
    let links = html! {
        a href="#top" { "Overview" } a href="#worst" { "The worst" } a href="#all" { "All scenes" }
    };
    let body = html! {
        (page_head(findings, summary))
        (gates_table(summary.gates))
        (counts_table(&summary.score.all))
        h2 { "Error estimates" }
        (ratios_text(ratios))
        (page::render_chart(estimate_chart(findings).as_deref(), "Nothing was estimated.", html! {
            b { "Estimate against error" } " · blue: CPU, orange: GPU; large and filled: beyond 2 % without a warning. On the "
            "thick line they are equal, the thin ones are half and three times the error; dashed: "
            (format_percent(MIN_JUDGED_ERROR)) ", below which estimates are not judged, and 2 %."
        }))
        section #worst {
            h2 { "The worst" }
            @for specimen in &findings.worst {
                h3 { "Seed " (specimen.value) }
                @if let Some(result) = findings.all.iter().find(|f| f.seed as f64 == specimen.value) { p { (result.description) } }
                div.case {
                    (specimen::draw_specimen(specimen, RANDOM_CASE.info.parameter))
                    div { (specimen::draw_plates(specimen)) }
                }
            }
        }
        section #all { h2 { "All scenes" } (scenes_table(findings)) }
    };
    Page {
        title: "Radiosity: freshly drawn scenes",
        bar: ("Parts", links),
        verdict: html! {},
        style: ATLAS_STYLE,
        body,
    }
    .to_html()
}

fn page_head(findings: &RandomFindings, summary: &AtlasSummary) -> Markup {
    html! {
        p {
            "Random rooms, on which nothing was tuned: convex and not, closed and open, with bodies that stand, hang, float, "
            "lean, touch or nearly do, sheets and several lamps. Each is solved as " code { "solve" } " does without options "
            "and judged by " (RANDOM_CASE.info.truth) ". The scene of a seed is drawn again by "
            code { "stress random --seed N --count 1" } "."
        }
        (gates_verdict(summary.gates, !findings.all.is_empty()))
        p.facts {
            (findings.all.len()) @if findings.all.len() == 1 { " scene" } @else { " scenes" } " · GPU: " (summary.adapter.unwrap_or("none")) " · " (format_duration(summary.seconds))
        }
    }
}

fn counts_table(counts: &WarningCounts) -> Markup {
    html! {
        (render_table("gates", &["#Caught|beyond 2 %, warned", "#Missed|beyond 2 %, silent",
            "#False alarms|within, warned", "#Quiet|within, silent"], [
            TableRow::new([counts.caught, counts.missed, counts.false_alarms, counts.quiet].map(number_cell)),
        ]))
    }
}

fn ratios_text(ratios: &EstimateRatios) -> Markup {
    html! {
        p {
            "Estimate over error, of the " (ratios.answers) " answers more than " (format_percent(MIN_JUDGED_ERROR)) " off: median "
            (format_number(ratios.median)) ", below half " (format_percent(ratios.below)) ", above three times " (format_percent(ratios.above))
            @if ratios.unknown > 0 { "; " (ratios.unknown) " were not estimated and count as 0" }
            ". Required: " (format_limits()) "."
        }
    }
}

/// Table of all scenes, the worst first.
fn scenes_table(findings: &RandomFindings) -> Markup {
    let mut order: Vec<&RandomResult> = findings.all.iter().collect();
    order.sort_by(|a, b| b.worst_error().total_cmp(&a.worst_error()));
    let rows = order
        .into_iter()
        .flat_map(|result| solver_sides(&result.row).map(move |(processor, side)| scene_row(result, processor, side)));
    html! {
        (render_table("", &["#Seed", "Solver", "Verdict", "#Error", "#Bias", "#Estimate", "#Over error", "#Time",
            "Warnings", "#Texels", "Scene"], rows))
    }
}

fn scene_row(result: &RandomResult, processor: Processor, side: &SolverSide) -> TableRow {
    let shown = |share: Option<f64>| share.map_or("–".to_owned(), format_percent);
    let name = match warning_outcome(RELATIVE_RMS, side) {
        WarningOutcome::Caught => "caught",
        WarningOutcome::Missed => "missed",
        WarningOutcome::FalseAlarm => "false alarm",
        WarningOutcome::Quiet => "quiet",
    };
    let messages = side.warnings.join(", ") + side.message.as_deref().unwrap_or_default();
    let cells = [
        number_cell(result.seed),
        text_cell(processor.name()),
        text_cell(name),
        number_cell(format_error(side, RELATIVE_RMS)),
        number_cell(shown(side.bias)),
        number_cell(shown(side.estimate)),
        number_cell(estimate_ratio(side).map_or("–".to_owned(), format_number)),
        number_cell(format_duration(side.seconds)),
        text_cell(messages),
        number_cell(html! { (result.texels) "²" }),
        text_cell(&result.description),
    ];
    TableRow::new(cells).with_class_if(name == "missed", "bad")
}

/// Returns the chart with a mark for each answer that has an estimate, or none without any.
pub fn estimate_chart(findings: &RandomFindings) -> Option<String> {
    let all = findings.all.iter().flat_map(|result| solver_sides(&result.row));
    let place = |(processor, side): (Processor, &SolverSide)| {
        let [x, y] = [side.error?, side.estimate?].map(|e| e.clamp(AXIS_ENDS[0], AXIS_ENDS[1]));
        Some((processor, !side.is_warned() && x > SAFE_ERROR, (x, y)))
    };
    let mut marks: Vec<(Processor, bool, (f64, f64))> = all.filter_map(place).collect();
    if marks.is_empty() {
        return None;
    }
    // The GPU's marks are drawn over the CPU's.
    marks.sort_by_key(|(processor, ..)| *processor == Processor::Gpu);
    let [a, b] = AXIS_ENDS;
    let x = Axis::logarithmic_scale("true error (log)", AXIS_ENDS, &format_share);
    let y = Axis::logarithmic_scale("estimated error (log)", AXIS_ENDS, &format_share);
    render_svg(CHART_SIZE, 24, [&x, &y], |frame| {
        // The line estimate = ratio × error within the axes.
        let slope = |ratio: f64| {
            let ends = [a.max(a / ratio), b.min(b / ratio)];
            frame.plot_path(ends.map(|x| (x, x * ratio)))
        };
        html! {
            @for (ratio, width) in [(1.0, 2.0), (LOW_RATIO, 1.0), (HIGH_RATIO, 1.0)] { (draw_path(&slope(ratio), GUIDE_COLOUR, width, 1.0, None)) }
            @for x in [MIN_JUDGED_ERROR, SAFE_ERROR] { (draw_path(&frame.plot_path([(x, a), (x, b)]), GUIDE_COLOUR, 1.0, 1.0, Some("3 4"))) }
            @for (processor, silent, (x, y)) in &marks {
                @let colour = if *processor == Processor::Cpu { CPU_COLOUR } else { GPU_COLOUR };
                path d=(MarkShape::Circle.outline_path((frame.x_pixel(*x), frame.y_pixel(*y)), if *silent { 6.0 } else { 4.0 }))
                    fill=(if *silent { colour } else { "none" }) stroke=(colour) stroke-width="2" {}
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::super::super::fixture::{self, make_row, make_side};
    use super::super::gates;
    use super::*;
    use crate::studies::stress::{CaseStudy, score};

    #[test]
    fn page_shows_every_scene_and_the_worst() {
        let sides = [(0.03, 0.02, ""), (0.01, 0.012, ""), (0.05, 0.06, "cells")];
        let all: Vec<RandomResult> = (0..)
            .zip(sides)
            .map(|(seed, (error, estimate, code))| RandomResult {
                seed,
                description: format!("scene <{seed}>"),
                texels: 6,
                row: make_row(
                    seed as f64,
                    SolverSide {
                        estimate: Some(estimate),
                        bias: Some(-0.001),
                        ..make_side(Some(error), code)
                    },
                    Some(make_side(Some(0.5 * error), code)),
                ),
            })
            .collect();
        let mut worst = fixture::make_specimen(fixture::closed_room(), 0);
        worst.value = 2.0;
        let findings = RandomFindings {
            all,
            worst: vec![worst],
        };
        let study = [CaseStudy {
            info: RANDOM_CASE.info,
            rows: findings.all.iter().map(|result| result.row.clone()).collect(),
            specimen: None,
        }];
        let (score, ratios) = (score::score_warnings(&study), findings.estimate_ratios());
        let summary = AtlasSummary {
            score: &score,
            gates: &gates::evaluate_gates(&findings, &ratios),
            adapter: None,
            seconds: 1.0,
        };
        let page = render_page(&findings, &ratios, &summary);
        assert_eq!(page.matches("<tr class=\"bad\">").count(), 1);
        assert!(page.contains("<h3>Seed 2</h3>") && page.contains("scene &lt;1&gt;"));
        assert!(page.contains("Not OK") && page.contains("class=\"chart\""));
        // Three estimates, since the fixture's GPU has none.
        assert_eq!(page.matches("stroke-width=\"2\"></path>").count(), 3);
    }
}
