//! Cases down, methods across, CPU and GPU side by side: where each method breaks first.

use super::breaks::{self, Break};
use super::chart::{colour, shape};
use super::groups::Group;
use super::outcome::{Half, Outcome, amount, outcome, value, value_short};
use super::{Side, Study, Verdict, limits};
use maud::{Markup, html};

/// Widths in rem: eleven methods fit on 1400 pixels.
const FIRST: f64 = 9.0;
const COLUMN: f64 = 3.55;
/// What must not be overlooked.
const MISSED: &str = "✖";

/// A method's columns: without the GPU's where that never answers.
struct Column {
    method: &'static str,
    halves: Vec<Half>,
}

fn columns(group: &Group) -> Vec<Column> {
    let rows = || group.studies.iter().flat_map(|(_, study)| &study.rows);
    let has = |method: &str, half: Half| {
        let mut own = rows().filter(|row| row.method == method);
        half == Half::Cpu || own.any(|row| half.of(row).is_some())
    };
    let column = |method: &&'static str| Column {
        method,
        halves: Half::BOTH.into_iter().filter(|h| has(method, *h)).collect(),
    };
    group.methods.iter().map(column).collect()
}

/// The table of a group.
pub fn table(group: &Group) -> Markup {
    let columns = columns(group);
    let halves: Vec<(&str, Half, bool)> = columns
        .iter()
        .flat_map(|c| {
            let last = c.halves.last();
            c.halves
                .iter()
                .map(move |h| (c.method, *h, Some(h) == last))
        })
        .collect();
    html! {
        div.atlas { table style=(format!("width:{:.2}rem", FIRST + COLUMN * halves.len() as f64)) {
            colgroup { col style=(format!("width:{FIRST}rem")); col span=(halves.len()); }
            thead {
                tr {
                    th.corner { (group.name) }
                    @for (k, column) in columns.iter().enumerate() {
                        th.end colspan=(column.halves.len()) { (swatch(k)) br; (column.method) }
                    }
                }
                tr {
                    th.corner { "what is swept" }
                    @for (_, half, end) in &halves { th.end[*end] { (half.name()) } }
                }
            }
            tbody { @for (k, study) in &group.studies { tr {
                th {
                    a href=(format!("#{}", anchor(*k))) { (study.about.name) }
                    span { (study.about.parameter) }
                }
                @let breaks = breaks::of(study);
                @for (method, half, end) in &halves { (cell(study, &breaks, (method, *half), *end)) }
            } } }
        } }
    }
}

/// The case's place on the page.
pub fn anchor(k: usize) -> String {
    format!("case-{}", k + 1)
}

/// The method's mark in its colour.
pub fn swatch(k: usize) -> Markup {
    html! { svg.swatch viewBox="-7 -7 14 14" aria-hidden="true" {
        path d=(shape(k).path((0.0, 0.0), 5.0)) fill=(colour(k)) {}
    } }
}

/// A verdict's class, sign and name.
pub fn face(verdict: Verdict) -> (&'static str, &'static str, &'static str) {
    match verdict {
        Verdict::Safe => ("safe", "○", "safe"),
        Verdict::Degrades => ("degrades", "◐", "degrades"),
        Verdict::Fails => ("fails", "●", "fails"),
    }
}

/// What the tables' signs mean.
pub fn key() -> Markup {
    let verdicts = [
        (Verdict::Safe, "every value within the first limit"),
        (Verdict::Degrades, "within the second at the worst value"),
        (Verdict::Fails, "worse, or no answer, at the worst"),
    ];
    html! {
        p.keys {
            @for (verdict, what) in verdicts {
                @let (class, sign, name) = face(verdict);
                span { span.box.(class) { (sign) " " (name) } " " (what) }
            }
            span { "at " b { "0.1" } " the first value at which it is not safe" }
            span { "at " b { "once" } " at the easiest already" }
            span { b { "holds" } " safe everywhere" }
            span { b { "▲3" } " not safe at three values, and warned or refused" }
            span { span.missed { (MISSED) "2" } " not safe at two, unwarned" }
            span { b { "△1" } " warned once, but safe" }
        }
    }
}

/// Where the method breaks first, as text.
fn first(limit: &Break) -> Markup {
    match (limit.safe.to, limit.safe.breaks_at) {
        (_, None) => html! { "holds" },
        (None, _) => html! { i { "at " } "once" },
        (_, Some(at)) => html! { i { "at " } (value_short(at)) },
    }
}

fn cell(study: &Study, breaks: &[Break], (method, half): (&str, Half), end: bool) -> Markup {
    let rows = study.rows.iter().filter(|r| r.method == method);
    let sides: Vec<&Side> = rows.filter_map(|row| half.of(row)).collect();
    let limit = breaks
        .iter()
        .find(|b| b.method == method && b.solver == half);
    let worst = sides.iter().map(|side| side.verdict).max();
    let (Some(worst), Some(limit)) = (worst, limit) else {
        return html! { td.none-here.end[end] title="not run" { b { "n/a" } } };
    };
    let (class, sign, _) = face(worst);
    let measure = study.about.measure;
    let outcomes: Vec<Outcome> = sides.iter().map(|side| outcome(measure, side)).collect();
    let count = |of: Outcome| outcomes.iter().filter(|one| **one == of).count();
    let marks = [
        ("▲", count(Outcome::Caught)),
        (MISSED, count(Outcome::Missed)),
        ("△", count(Outcome::FalseAlarm)),
    ];
    let counts = marks.map(|(_, n)| n);
    html! {
        td.(class).end[end] title=(about(study, limit, worst, counts)) {
            b { (first(limit)) }
            small { (sign) @for (mark, n) in marks { @if n > 0 { " " span.missed[mark == MISSED] { (mark) (n) } } } }
        }
    }
}

/// What pointing at a cell tells.
fn about(study: &Study, limit: &Break, worst: Verdict, counts: [usize; 3]) -> String {
    let text = |at: Option<f64>| at.map_or("nowhere".into(), value);
    let measure = study.about.measure;
    let [first, second] = limits(measure).map(|limit| amount(measure, limit));
    let [caught, missed, false_alarms] = counts;
    format!(
        "{}, {}, {}: {} at worst; safe to {}, beyond {first} at {}, beyond {second} at {}; \
         not safe: {caught} warned, {missed} unwarned; false alarms: {false_alarms}",
        study.about.name,
        limit.method,
        limit.solver.name(),
        face(worst).2,
        text(limit.safe.to),
        text(limit.safe.breaks_at),
        text(limit.degraded.breaks_at),
    )
}

#[cfg(test)]
mod tests {
    use super::super::Row;
    use super::super::fixture::{row, side, study};
    use super::*;

    fn drawn(errors: &[Option<f64>], code: &str) -> String {
        let rows = (1..).zip(errors);
        let rows = rows.map(|(k, e)| row(f64::from(k), side(*e, code), None));
        drawn_on(rows.collect(), Half::Cpu)
    }

    fn drawn_on(rows: Vec<Row>, half: Half) -> String {
        let study = study("one", rows);
        cell(&study, &breaks::of(&study), ("default", half), false).into_string()
    }

    #[test]
    fn a_cell_says_where_it_breaks_and_who_said_so() {
        let silent = drawn(&[Some(0.001), Some(0.01), Some(0.05)], "");
        assert!(
            silent.contains("degrades") && silent.contains("at </i>3<") && silent.contains("✖1")
        );
        let told = drawn(&[Some(0.5), None], "thin");
        assert!(told.contains("fails") && told.contains("at </i>once<") && told.contains("▲2"));
        let safe = drawn(&[Some(0.001)], "");
        assert!(safe.contains("<b>holds</b>") && !safe.contains('✖') && !safe.contains('▲'));
        assert!(drawn(&[Some(0.001)], "thin").contains("△1"));
        let rows = vec![row(1.0, side(Some(0.0), ""), None)];
        assert!(drawn_on(rows, Half::Gpu).contains("n/a"));
    }
}
