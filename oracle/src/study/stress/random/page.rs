//! `stress.html` of random scenes.

use super::gates::limits;
use super::ratio::{FLOOR, Ratios, ratio};
use super::{CASE, Findings, Found, chart};
use crate::show::report::document;
use crate::show::report::number::{number, percent};
use crate::study::stress::json::Told;
use crate::study::stress::outcome::{Half, Outcome, error, outcome, sides};
use crate::study::stress::page::{STYLE, gates};
use crate::study::stress::score::Counts;
use crate::study::stress::{RELATIVE, Side, plates, specimen};
use maud::{Markup, PreEscaped, html};

/// The page; `told` is what the runner found.
pub fn page(findings: &Findings, ratios: &Ratios, told: &Told) -> String {
    let title = "Radiosity: freshly drawn scenes";
    let nav = html! {
        nav aria-label="Parts" {
            a href="#top" { "Overview" } a href="#worst" { "The worst" } a href="#all" { "All scenes" }
        }
    };
    let body = html! {
        style { (PreEscaped(STYLE)) }
        header #top { h1 { (title) } }
        (head(findings, told))
        (gates(told.gates))
        (counts(&told.score.all))
        h2 { "Does it know how wrong it is?" }
        (known(ratios))
        (crate::show::report::chart(chart::svg(findings).as_deref(), "Nothing was estimated.", html! {
            b { "Estimate against error" } " · blue: CPU, orange: GPU; large and filled: beyond 2 % without a warning. On the "
            "thick line they are equal, the thin ones are half and three times the error; dashed: "
            (percent(FLOOR)) ", below which nothing is asked of an estimate, and 2 %."
        }))
        section #worst {
            h2 { "The worst" }
            @for specimen in &findings.worst {
                h3 { "Seed " (specimen.value) }
                @if let Some(found) = findings.all.iter().find(|f| f.seed as f64 == specimen.value) { p { (found.told) } }
                div.case { (specimen::view(specimen, CASE.about.parameter)) }
                (plates::plates(specimen))
            }
        }
        section #all { h2 { "All scenes" } (table(findings)) }
    };
    document(title, &nav, &body)
}

fn head(findings: &Findings, told: &Told) -> Markup {
    let broken = told.gates.iter().filter(|gate| !gate.held).count();
    let run = !findings.all.is_empty();
    html! {
        p {
            "Rooms that nothing was tuned on: convex and not, closed and open, with bodies that stand, hang, float, "
            "lean, touch or nearly do, sheets and several lamps. Each is solved as " code { "solve" } " does without options "
            "and judged by " (CASE.about.truth) ". The scene of a seed is drawn again by "
            code { "stress random --seed N --count 1" } "."
        }
        p.verdict.(if run && broken == 0 { "agree" } else { "disagree" }) {
            @if !run { strong { "Not OK" } " nothing was run" }
            @else if broken == 0 { strong { "OK" } " all " (told.gates.len()) " gates hold" }
            @else { strong { "Not OK" } " " (broken) " of " (told.gates.len()) " gates do not hold" }
        }
        p.facts {
            (findings.all.len()) " scenes · GPU: " (told.adapter.unwrap_or("none")) " · " (number(told.seconds)) " s"
        }
    }
}

fn counts(counts: &Counts) -> Markup {
    html! {
        div.scroll { table.gates {
            thead { tr {
                th.n { "Caught" br; "beyond 2 %, warned" } th.n { "Missed" br; "beyond 2 %, silent" }
                th.n { "False alarms" br; "within, warned" } th.n { "Quiet" br; "within, silent" }
            } }
            tbody { tr {
                td.n { (counts.caught) } td.n { (counts.missed) } td.n { (counts.false_alarms) } td.n { (counts.quiet) }
            } }
        } }
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
fn table(findings: &Findings) -> Markup {
    let mut order: Vec<&Found> = findings.all.iter().collect();
    order.sort_by(|a, b| b.error().total_cmp(&a.error()));
    html! {
        div.scroll { table {
            thead { tr {
                th.n { "Seed" } th { "Solver" } th { "Verdict" } th.n { "Error" } th.n { "Bias" } th.n { "Estimate" }
                th.n { "Over error" } th.n { "Seconds" } th { "Warnings" } th.n { "Texels" } th { "Scene" }
            } }
            tbody { @for found in order { @for (half, side) in sides(&found.row) { (line(found, half, side)) } } }
        } }
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
            td.n { (ratio(side).map_or("–".to_owned(), number)) } td.n { (number(side.seconds)) }
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
        if let Some(path) = std::env::var_os("STRESS_RANDOM_PAGE") {
            std::fs::write(path, &page).unwrap();
        }
        assert_eq!(page.matches("<tr class=\"bad\">").count(), 1);
        assert!(page.contains("<h3>Seed 2</h3>") && page.contains("scene &lt;1&gt;"));
        assert!(page.contains("Not OK") && page.contains("class=\"chart\""));
        // Estimates of three answers; the fixture's GPU makes none.
        assert_eq!(page.matches("<circle").count(), 3);
    }
}
