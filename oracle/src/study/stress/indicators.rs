//! How the indicators did: what each warning caught, and what none did.

use super::methods::DEFAULT;
use super::outcome::{Half, Outcome, error, outcome, sides, value};
use super::score::Code;
use super::table::anchor;
use super::{Row, Side, Study, Verdict};
use crate::show::page::table;
use maud::{Markup, html};

/// Missed rows that are listed.
const LISTED: usize = 200;

/// All codes, those that caught most first; a refusal is one.
fn indicators(studies: &[Study], codes: &[Code]) -> Vec<Code> {
    let mut refused = Code {
        code: "(refused)".into(),
        caught: 0,
        false_alarms: 0,
    };
    let rows = studies.iter().flat_map(|study| &study.rows);
    for (_, side) in rows.flat_map(sides).filter(|(_, side)| side.refused()) {
        *if side.verdict == Verdict::Safe {
            &mut refused.false_alarms
        } else {
            &mut refused.caught
        } += 1;
    }
    let mut found = codes.to_vec();
    if refused.caught + refused.false_alarms > 0 {
        found.push(refused);
    }
    found.sort_by(|a, b| b.caught.cmp(&a.caught).then(a.code.cmp(&b.code)));
    found
}

/// The section.
pub fn section(studies: &[Study], codes: &[Code]) -> Markup {
    html! {
        section #warnings {
            h2 { "How the warnings did" }
            p {
                "Each code over all methods and both solvers: where it was given, was the answer really beyond the limit? "
                "One answer may have several codes."
            }
            (codes_table(&indicators(studies, codes)))
            (missed(studies))
        }
    }
}

fn codes_table(found: &[Code]) -> Markup {
    let most = found.iter().map(|i| i.caught + i.false_alarms).max();
    let share = |n: usize| {
        format!(
            "width:{:.1}%",
            100.0 * n as f64 / most.unwrap_or(1).max(1) as f64
        )
    };
    html! {
        @if found.is_empty() { p { "No warning was given." } } @else {
            (table("gates", &["Code", "#Caught", "#False alarms", "caught, then false alarms (striped)"], html! {
                @for one in found { tr {
                    td { code { (one.code) } }
                    td.n { (one.caught) }
                    td.n { (one.false_alarms) }
                    td { span.meter {
                        i.hit style=(share(one.caught)) {}
                        i.false style=(share(one.false_alarms)) {}
                    } }
                } }
            }))
        }
    }
}

/// What was beyond the limit in silence, the default's first.
fn missed(studies: &[Study]) -> Markup {
    let mut all: Vec<(usize, &str, &Row, Half, &Side)> = Vec::new();
    for (k, study) in studies.iter().enumerate() {
        let each = study
            .rows
            .iter()
            .flat_map(|row| sides(row).map(move |s| (row, s)));
        let measure = study.about.measure;
        let missed = each.filter(|(_, (_, side))| outcome(measure, side) == Outcome::Missed);
        all.extend(missed.map(|(row, (half, side))| (k, measure, row, half, side)));
    }
    all.sort_by_key(|(_, _, row, ..)| row.method != DEFAULT);
    html! {
        h3 #missed { "Missed: beyond the limit, and nobody said so" }
        @if all.is_empty() { p { span.pass { "✓" } " None." } } @else {
            p { (all.len()) " of them; those of the default settings come first." }
            details open[all.len() <= 40] {
                summary { "The list" }
                (table("", &["Method", "Solver", "Case", "#Value", "#Error"], html! {
                    @for (k, measure, row, half, side) in all.iter().take(LISTED) { tr.bad[row.method == DEFAULT] {
                        td { (row.method) } td { (half.name()) }
                        td { a href=(format!("#{}", anchor(*k))) { (row.case) } }
                        td.n { (value(row.value)) } td.n { (error(side, measure)) }
                    } }
                }))
                @if all.len() > LISTED { p.small { "The other " (all.len() - LISTED) " are in stress.json." } }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{row, side, study};
    use super::*;

    #[test]
    fn the_defaults_misses_come_first() {
        let mut other = row(1.0, side(Some(0.5), ""), None);
        other.method = "other";
        let rows = vec![other, row(1.0, side(Some(0.3), ""), None)];
        let page = section(&[study("one", rows)], &[]).into_string();
        let [own, theirs] = ["30\u{202f}%", "50\u{202f}%"].map(|text| page.find(text).unwrap());
        assert!(own < theirs);
        let safe = vec![row(1.0, side(Some(0.01), ""), None)];
        assert!(
            section(&[study("one", safe)], &[])
                .into_string()
                .contains("None.")
        );
    }
}
