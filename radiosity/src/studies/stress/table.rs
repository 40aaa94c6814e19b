//! Table of the break points: cases down, methods across, CPU and GPU side by side.

use super::breaks::{self, BreakPoint};
use super::chart::{method_colour, method_shape};
use super::groups::CaseGroup;
use super::outcome::{Processor, WarningOutcome, format_amount, format_short_value, format_value, warning_outcome};
use super::{CaseStudy, SolverSide, Verdict, error_limits};
use maud::{Markup, html};

/// Width of the first column, rem.
const FIRST_WIDTH_REM: f64 = 9.0;
const COLUMN_WIDTH_REM: f64 = 3.55;
/// Sign of a missed error.
const MISSED_SIGN: &str = "✖";

/// Columns of a method, without the GPU's if it has no results.
struct Column {
    method: &'static str,
    processors: Vec<Processor>,
}

fn method_columns(group: &CaseGroup) -> Vec<Column> {
    let rows = || group.studies.iter().flat_map(|(_, study)| &study.rows);
    let has = |method: &str, processor: Processor| {
        let mut own = rows().filter(|row| row.method == method);
        processor == Processor::Cpu || own.any(|row| processor.side_of(row).is_some())
    };
    let column = |method: &&'static str| Column {
        method,
        processors: Processor::BOTH.into_iter().filter(|h| has(method, *h)).collect(),
    };
    group.methods.iter().map(column).collect()
}

/// Returns the table of a group.
pub fn breaks_table(group: &CaseGroup) -> Markup {
    let columns = method_columns(group);
    let processors: Vec<(&str, Processor, bool)> = columns
        .iter()
        .flat_map(|c| {
            let last = c.processors.last();
            c.processors.iter().map(move |h| (c.method, *h, Some(h) == last))
        })
        .collect();
    html! {
        div.atlas { table style=(format!("width:{:.2}rem", FIRST_WIDTH_REM + COLUMN_WIDTH_REM * processors.len() as f64)) {
            colgroup { col style=(format!("width:{FIRST_WIDTH_REM}rem")); col span=(processors.len()); }
            thead {
                tr {
                    th.corner { (group.name) }
                    @for (k, column) in columns.iter().enumerate() {
                        th.end colspan=(column.processors.len()) { (method_swatch(k)) br; (column.method) }
                    }
                }
                tr {
                    th.corner { "Swept parameter" }
                    @for (_, processor, end) in &processors { th.end[*end] { (processor.name()) } }
                }
            }
            tbody { @for (k, study) in &group.studies { tr {
                th {
                    a href=(format!("#{}", case_anchor(*k))) { (study.info.name) }
                    span { (study.info.parameter) }
                }
                @let breaks = breaks::find_breaks(study);
                @for (method, processor, end) in &processors { (break_cell(study, &breaks, (method, *processor), *end)) }
            } } }
        } }
    }
}

/// Returns the page anchor of case `k`.
pub fn case_anchor(k: usize) -> String {
    format!("case-{}", k + 1)
}

/// Returns the mark of method `k` in its colour.
pub fn method_swatch(k: usize) -> Markup {
    html! { svg.swatch viewBox="-7 -7 14 14" aria-hidden="true" {
        path d=(method_shape(k).outline_path((0.0, 0.0), 5.0)) fill=(method_colour(k)) {}
    } }
}

/// Returns a verdict's CSS class, sign and name.
pub fn verdict_style(verdict: Verdict) -> (&'static str, &'static str, &'static str) {
    match verdict {
        Verdict::Safe => ("safe", "○", "safe"),
        Verdict::Degrades => ("degrades", "◐", "degrades"),
        Verdict::Fails => ("fails", "●", "fails"),
    }
}

/// Returns the legend of the tables' signs.
pub fn table_legend() -> Markup {
    let verdicts = [
        (Verdict::Safe, "every value within the first limit"),
        (Verdict::Degrades, "within the second at the worst value"),
        (Verdict::Fails, "worse, or no answer, at the worst"),
    ];
    html! {
        p.keys {
            @for (verdict, what) in verdicts {
                @let (class, sign, name) = verdict_style(verdict);
                span { span.box.(class) { (sign) " " (name) } " " (what) }
            }
            span { "at " b { "0.1" } " the first value at which it is not safe" }
            span { "at " b { "once" } " at the easiest already" }
            span { b { "holds" } " safe everywhere" }
            span { b { "▲3" } " not safe at three values, and warned or refused" }
            span { span.missed { (MISSED_SIGN) "2" } " not safe at two, unwarned" }
            span { b { "△1" } " warned once, but safe" }
        }
    }
}

/// Formats the first value at which a method is not safe.
fn format_break(limit: &BreakPoint) -> Markup {
    match (limit.safe.to, limit.safe.breaks_at) {
        (_, None) => html! { "holds" },
        (None, _) => html! { i { "at " } "once" },
        (_, Some(at)) => html! { i { "at " } (format_short_value(at)) },
    }
}

fn break_cell(study: &CaseStudy, breaks: &[BreakPoint], (method, processor): (&str, Processor), end: bool) -> Markup {
    let rows = study.rows.iter().filter(|r| r.method == method);
    let sides: Vec<&SolverSide> = rows.filter_map(|row| processor.side_of(row)).collect();
    let limit = breaks.iter().find(|b| b.method == method && b.solver == processor);
    let worst = sides.iter().map(|side| side.verdict).max();
    let (Some(worst), Some(limit)) = (worst, limit) else {
        return html! { td.none-here.end[end] title="not run" { b { "n/a" } } };
    };
    let (class, sign, _) = verdict_style(worst);
    let measure = study.info.measure;
    let outcomes: Vec<WarningOutcome> = sides.iter().map(|side| warning_outcome(measure, side)).collect();
    let count = |of: WarningOutcome| outcomes.iter().filter(|one| **one == of).count();
    let marks = [
        ("▲", count(WarningOutcome::Caught)),
        (MISSED_SIGN, count(WarningOutcome::Missed)),
        ("△", count(WarningOutcome::FalseAlarm)),
    ];
    let counts = marks.map(|(_, n)| n);
    html! {
        td.(class).end[end] title=(cell_tooltip(study, limit, worst, counts)) {
            b { (format_break(limit)) }
            small { (sign) @for (mark, n) in marks { @if n > 0 { " " span.missed[mark == MISSED_SIGN] { (mark) (n) } } } }
        }
    }
}

/// Returns the tooltip of a table cell.
fn cell_tooltip(study: &CaseStudy, limit: &BreakPoint, worst: Verdict, counts: [usize; 3]) -> String {
    let text = |at: Option<f64>| at.map_or("nowhere".into(), format_value);
    let measure = study.info.measure;
    let [first, second] = error_limits(measure).map(|limit| format_amount(measure, limit));
    let [caught, missed, false_alarms] = counts;
    format!(
        "{}, {}, {}: {} at worst; safe to {}, beyond {first} at {}, beyond {second} at {}; \
         not safe: {caught} warned, {missed} unwarned; false alarms: {false_alarms}",
        study.info.name,
        limit.method,
        limit.solver.name(),
        verdict_style(worst).2,
        text(limit.safe.to),
        text(limit.safe.breaks_at),
        text(limit.degraded.breaks_at),
    )
}

#[cfg(test)]
mod tests {
    use super::super::AtlasRow;
    use super::super::fixture::{make_row, make_side, make_study};
    use super::*;

    fn cell_of_errors(errors: &[Option<f64>], code: &str) -> String {
        let rows = (1..).zip(errors);
        let rows = rows.map(|(k, e)| make_row(f64::from(k), make_side(*e, code), None));
        cell_of_rows(rows.collect(), Processor::Cpu)
    }

    fn cell_of_rows(rows: Vec<AtlasRow>, processor: Processor) -> String {
        let study = make_study("one", rows);
        break_cell(&study, &breaks::find_breaks(&study), ("default", processor), false).into_string()
    }

    #[test]
    fn table_cell_shows_break_point_and_warnings() {
        let silent = cell_of_errors(&[Some(0.001), Some(0.01), Some(0.05)], "");
        assert!(silent.contains("degrades") && silent.contains("at </i>3<") && silent.contains("✖1"));
        let warned = cell_of_errors(&[Some(0.5), None], "thin");
        assert!(warned.contains("fails") && warned.contains("at </i>once<") && warned.contains("▲2"));
        let safe = cell_of_errors(&[Some(0.001)], "");
        assert!(safe.contains("<b>holds</b>") && !safe.contains('✖') && !safe.contains('▲'));
        assert!(cell_of_errors(&[Some(0.001)], "thin").contains("△1"));
        let rows = vec![make_row(1.0, make_side(Some(0.0), ""), None)];
        assert!(cell_of_rows(rows, Processor::Gpu).contains("n/a"));
    }
}
