//! `stress.html` of random scenes.

use super::gates::limits;
use super::ratio::{FLOOR, Ratios, ratio};
use super::{CASE, Findings, Found, chart};
use crate::show::number::{duration, number, percent};
use crate::show::page::{self, Page, table};
use crate::study::stress::json::Told;
use crate::study::stress::outcome::{Half, Outcome, error, outcome, sides};
use crate::study::stress::page::{STYLE, gates, held};
use crate::study::stress::score::Counts;
use crate::study::stress::{RELATIVE, Side, plates, specimen};
use maud::{Markup, html};

/// The page; `told` is what the runner found.
pub fn page(findings: &Findings, ratios: &Ratios, told: &Told) -> String {
    let links = html! {
        a href="#top" { "Overview" } a href="#worst" { "The worst" } a href="#all" { "All scenes" }
    };
    let body = html! {
        (head(findings, told))
        (gates(told.gates))
        (counts(&told.score.all))
        h2 { "Does it know how wrong it is?" }
        (known(ratios))
        (page::chart(chart::svg_of(findings).as_deref(), "Nothing was estimated.", html! {
            b { "Estimate against error" } " · blue: CPU, orange: GPU; large and filled: beyond 2 % without a warning. On the "
            "thick line they are equal, the thin ones are half and three times the error; dashed: "
            (percent(FLOOR)) ", below which nothing is asked of an estimate, and 2 %."
        }))
        section #worst {
            h2 { "The worst" }
            @for specimen in &findings.worst {
                h3 { "Seed " (specimen.value) }
                @if let Some(found) = findings.all.iter().find(|f| f.seed as f64 == specimen.value) { p { (found.told) } }
                div.case {
                    (specimen::view(specimen, CASE.about.parameter))
                    div { (plates::plates(specimen)) }
                }
            }
        }
        section #all { h2 { "All scenes" } (scenes(findings)) }
    };
    Page {
        title: "Radiosity: freshly drawn scenes",
        bar: ("Parts", links),
        verdict: html! {},
        style: STYLE,
        body,
    }
    .html()
}

fn head(findings: &Findings, told: &Told) -> Markup {
    html! {
        p {
            "Rooms that nothing was tuned on: convex and not, closed and open, with bodies that stand, hang, float, "
            "lean, touch or nearly do, sheets and several lamps. Each is solved as " code { "solve" } " does without options "
            "and judged by " (CASE.about.truth) ". The scene of a seed is drawn again by "
            code { "stress random --seed N --count 1" } "."
        }
        (held(told.gates, !findings.all.is_empty()))
        p.facts {
            (findings.all.len()) @if findings.all.len() == 1 { " scene" } @else { " scenes" } " · GPU: " (told.adapter.unwrap_or("none")) " · " (duration(told.seconds))
        }
    }
}

fn counts(counts: &Counts) -> Markup {
    html! {
        (table("gates", &["#Caught|beyond 2 %, warned", "#Missed|beyond 2 %, silent",
            "#False alarms|within, warned", "#Quiet|within, silent"], html! {
            tr {
                td.n { (counts.caught) } td.n { (counts.missed) } td.n { (counts.false_alarms) } td.n { (counts.quiet) }
            }
        }))
    }
}

fn known(ratios: &Ratios) -> Markup {
    html! {
        p {
            "Estimate over error, of the " (ratios.answers) " answers more than " (percent(FLOOR)) " off: median "
            (number(ratios.median)) ", below half " (percent(ratios.below)) ", above three times " (percent(ratios.above))
            @if ratios.unknown > 0 { "; " (ratios.unknown) " were not estimated and count as 0" }
            ". Asked for: " (limits()) "."
        }
    }
}

/// All scenes, the worst first.
fn scenes(findings: &Findings) -> Markup {
    let mut order: Vec<&Found> = findings.all.iter().collect();
    order.sort_by(|a, b| b.error().total_cmp(&a.error()));
    html! {
        (table("", &["#Seed", "Solver", "Verdict", "#Error", "#Bias", "#Estimate", "#Over error", "#Time",
            "Warnings", "#Texels", "Scene"], html! {
            @for found in order { @for (half, side) in sides(&found.row) { (line(found, half, side)) } }
        }))
    }
}

fn line(found: &Found, half: Half, side: &Side) -> Markup {
    let shown = |share: Option<f64>| share.map_or("–".to_owned(), percent);
    let name = match outcome(RELATIVE, side) {
        Outcome::Caught => "caught",
        Outcome::Missed => "missed",
        Outcome::FalseAlarm => "false alarm",
        Outcome::Quiet => "quiet",
    };
    let told = side.warnings.join(", ") + side.message.as_deref().unwrap_or_default();
    html! {
        tr.bad[name == "missed"] {
            td.n { (found.seed) } td { (half.name()) } td { (name) }
            td.n { (error(side, RELATIVE)) } td.n { (shown(side.bias)) } td.n { (shown(side.estimate)) }
            td.n { (ratio(side).map_or("–".to_owned(), number)) } td.n { (duration(side.seconds)) }
            td { (told) } td.n { (found.texels) "²" } td { (found.told) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::fixture::{self, row, side};
    use super::super::gates;
    use super::*;
    use crate::study::stress::{Study, score};

    #[test]
    fn the_page_shows_every_scene_and_the_worst() {
        let sides = [(0.03, 0.02, ""), (0.01, 0.012, ""), (0.05, 0.06, "cells")];
        let all: Vec<Found> = (0..)
            .zip(sides)
            .map(|(seed, (error, estimate, code))| Found {
                seed,
                told: format!("scene <{seed}>"),
                texels: 6,
                row: row(
                    seed as f64,
                    Side {
                        estimate: Some(estimate),
                        bias: Some(-0.001),
                        ..side(Some(error), code)
                    },
                    Some(side(Some(0.5 * error), code)),
                ),
            })
            .collect();
        let mut worst = fixture::specimen(fixture::room(), 0);
        worst.value = 2.0;
        let findings = Findings {
            all,
            worst: vec![worst],
        };
        let study = [Study {
            about: CASE.about,
            rows: findings.all.iter().map(|found| found.row.clone()).collect(),
            specimen: None,
        }];
        let (score, ratios) = (score::of(&study), findings.ratios());
        let told = Told {
            score: &score,
            gates: &gates::of(&findings, &ratios),
            adapter: None,
            seconds: 1.0,
        };
        let page = page(&findings, &ratios, &told);
        assert_eq!(page.matches("<tr class=\"bad\">").count(), 1);
        assert!(page.contains("<h3>Seed 2</h3>") && page.contains("scene &lt;1&gt;"));
        assert!(page.contains("Not OK") && page.contains("class=\"chart\""));
        // Estimates of three answers; the fixture's GPU makes none.
        assert_eq!(page.matches("stroke-width=\"2\"></path>").count(), 3);
    }
}
