//! Section on the warnings: errors caught by each code, false alarms, and missed errors.

use super::methods::DEFAULT_METHOD;
use super::outcome::{Processor, WarningOutcome, format_error, format_value, solver_sides, warning_outcome};
use super::score::CodeCount;
use super::table::case_anchor;
use super::{AtlasRow, CaseStudy, SolverSide, Verdict};
use crate::report::table::{TableRow, number_cell, render_table, text_cell};
use maud::{Markup, html};

/// Most missed rows that are listed.
const MAX_LISTED_ROWS: usize = 200;

/// Returns all codes by errors caught, with refusals as a code of their own.
fn rank_codes(studies: &[CaseStudy], codes: &[CodeCount]) -> Vec<CodeCount> {
    let mut refused = CodeCount {
        code: "(refused)".into(),
        caught: 0,
        false_alarms: 0,
    };
    let rows = studies.iter().flat_map(|study| &study.rows);
    for (_, side) in rows.flat_map(solver_sides).filter(|(_, side)| side.is_refused()) {
        *if side.verdict == Verdict::Safe {
            &mut refused.false_alarms
        } else {
            &mut refused.caught
        } += 1;
    }
    let mut ranked = codes.to_vec();
    if refused.caught + refused.false_alarms > 0 {
        ranked.push(refused);
    }
    ranked.sort_by(|a, b| b.caught.cmp(&a.caught).then(a.code.cmp(&b.code)));
    ranked
}

/// Returns the section.
pub fn warnings_section(studies: &[CaseStudy], codes: &[CodeCount]) -> Markup {
    html! {
        section #warnings {
            h2 { "The warnings" }
            p {
                "Each warning code over all methods and both solvers: its answers beyond the limit (caught) and within it (false alarms). "
                "One answer may have several codes."
            }
            (codes_table(&rank_codes(studies, codes)))
            (missed_table(studies))
        }
    }
}

fn codes_table(codes: &[CodeCount]) -> Markup {
    let max_count = codes.iter().map(|i| i.caught + i.false_alarms).max();
    let share = |n: usize| format!("width:{:.1}%", 100.0 * n as f64 / max_count.unwrap_or(1).max(1) as f64);
    let rows = codes.iter().map(|code| {
        let meter = html! { span.meter {
            i.hit style=(share(code.caught)) {}
            i.false style=(share(code.false_alarms)) {}
        } };
        TableRow::new([
            text_cell(html! { code { (code.code) } }),
            number_cell(code.caught),
            number_cell(code.false_alarms),
            text_cell(meter),
        ])
    });
    html! {
        @if codes.is_empty() { p { "No warning was given." } } @else {
            (render_table("gates", &["Code", "#Caught", "#False alarms", "caught, then false alarms (striped)"], rows))
        }
    }
}

/// Lists the results beyond the limit without a warning, the default's first.
fn missed_table(studies: &[CaseStudy]) -> Markup {
    let mut all: Vec<(usize, &str, &AtlasRow, Processor, &SolverSide)> = Vec::new();
    for (k, study) in studies.iter().enumerate() {
        let each = study
            .rows
            .iter()
            .flat_map(|row| solver_sides(row).map(move |s| (row, s)));
        let measure = study.info.measure;
        let missed = each.filter(|(_, (_, side))| warning_outcome(measure, side) == WarningOutcome::Missed);
        all.extend(missed.map(|(row, (processor, side))| (k, measure, row, processor, side)));
    }
    all.sort_by_key(|(_, _, row, ..)| row.method != DEFAULT_METHOD);
    let rows = all.iter().take(MAX_LISTED_ROWS);
    let rows = rows.map(|(k, measure, row, processor, side)| {
        let cells = [
            text_cell(row.method),
            text_cell(processor.name()),
            text_cell(html! { a href=(format!("#{}", case_anchor(*k))) { (row.case) } }),
            number_cell(format_value(row.value)),
            number_cell(format_error(side, measure)),
        ];
        TableRow::new(cells).with_class_if(row.method == DEFAULT_METHOD, "bad")
    });
    html! {
        h3 #missed { "Missed: beyond the limit without a warning" }
        @if all.is_empty() { p { span.pass { "✓" } " None." } } @else {
            p { (all.len()) " of them; those of the default settings come first." }
            details open[all.len() <= 40] {
                summary { "The list" }
                (render_table("", &["Method", "Solver", "Case", "#Value", "#Error"], rows))
                @if all.len() > MAX_LISTED_ROWS { p.small { "The other " (all.len() - MAX_LISTED_ROWS) " are in stress.json." } }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{make_row, make_side, make_study};
    use super::*;

    #[test]
    fn missed_rows_of_the_default_come_first() {
        let mut other = make_row(1.0, make_side(Some(0.5), ""), None);
        other.method = "other";
        let rows = vec![other, make_row(1.0, make_side(Some(0.3), ""), None)];
        let page = warnings_section(&[make_study("one", rows)], &[]).into_string();
        let [own, theirs] = ["30\u{202f}%", "50\u{202f}%"].map(|text| page.find(text).unwrap());
        assert!(own < theirs);
        let safe = vec![make_row(1.0, make_side(Some(0.01), ""), None)];
        assert!(
            warnings_section(&[make_study("one", safe)], &[])
                .into_string()
                .contains("None.")
        );
    }
}
