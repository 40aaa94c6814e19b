//! Cases down, methods across, CPU and GPU side by side: how far each method holds.

use super::chart::colour;
use super::outcome::{Half, Outcome, tally, value, value_short, verdict};
use super::score::Break;
use super::{Row, Side, Study, Verdict};
use maud::{Markup, html};

/// Widths in rem: nine methods fit on 1400 pixels.
const FIRST: f64 = 9.4;
const COLUMN: f64 = 4.1;
/// What must not be overlooked.
const MISSED: &str = "✖";

/// The table with its key.
pub fn table(studies: &[Study], methods: &[&'static str]) -> Markup {
    html! {
        (key())
        div.atlas { table style=(format!("width:{:.2}rem", FIRST + COLUMN * 2.0 * methods.len() as f64)) {
            colgroup { col style=(format!("width:{FIRST}rem")); col span=(2 * methods.len()); }
            thead {
                tr {
                    th.corner { "Case" }
                    @for (k, method) in methods.iter().enumerate() {
                        th colspan="2" { (swatch(k)) (method) }
                    }
                }
                tr {
                    th.corner { "what is swept" }
                    @for _ in methods { @for half in Half::BOTH { th { (half.name()) } } }
                }
            }
            tbody { @for (k, study) in studies.iter().enumerate() { tr {
                th {
                    a href=(format!("#{}", anchor(k))) { (study.about.name) }
                    span { (study.about.parameter) }
                }
                @for method in methods { @for half in Half::BOTH { (cell(study, method, half)) } }
            } } }
        } }
    }
}

/// The case's place on the page.
pub fn anchor(k: usize) -> String {
    format!("case-{}", k + 1)
}

/// A dot in the method's colour.
pub fn swatch(k: usize) -> Markup {
    html! { span.swatch style=(format!("background:{}", colour(k))) {} }
}

/// A verdict's class, sign and name.
pub fn face(verdict: Verdict) -> (&'static str, &'static str, &'static str) {
    match verdict {
        Verdict::Safe => ("safe", "○", "safe"),
        Verdict::Degrades => ("degrades", "◐", "degrades"),
        Verdict::Fails => ("fails", "●", "fails"),
    }
}

fn key() -> Markup {
    let verdicts = [
        (Verdict::Safe, "every value within 2 %"),
        (Verdict::Degrades, "up to 10 % at the worst value"),
        (Verdict::Fails, "worse, or no answer, at the worst"),
    ];
    html! {
        p.keys {
            @for (verdict, what) in verdicts {
                @let (class, sign, name) = face(verdict);
                span { span.box.(class) { (sign) " " (name) } " " (what) }
            }
            span { "to " b { "0.1" } " within 2 % up to there" }
            span { b { "all" } " everywhere" }
            span { b { "–" } " nowhere" }
            span { b { "▲3" } " beyond 2 % at three values, and warned or refused" }
            span { span.missed { (MISSED) "2" } " beyond 2 % at two, unwarned" }
            span { b { "△1" } " warned once, but safe" }
        }
    }
}

/// How far the method holds, as text.
fn reach(limit: &Break) -> Markup {
    match (limit.safe_to, limit.breaks_at) {
        (_, None) => html! { "all" },
        (Some(to), _) => html! { i { "to " } (value_short(to)) },
        (None, _) => html! { "–" },
    }
}

fn cell(study: &Study, method: &str, half: Half) -> Markup {
    let rows: Vec<&Row> = study.rows.iter().filter(|r| r.method == method).collect();
    let sides: Vec<&Side> = rows.iter().filter_map(|row| half.of(row)).collect();
    let end = if half == Half::Gpu { "gpu-half" } else { "" };
    let Some(worst) = sides.iter().map(|side| verdict(side)).max() else {
        return html! { td.none-here.(end) title="not run" { b { "n/a" } } };
    };
    let limit = Break::of(rows.iter().copied(), |row| half.of(row));
    let (class, sign, name) = face(worst);
    let count = |of: Outcome| tally(sides.iter().copied(), of);
    let marks = [
        ("▲", count(Outcome::Caught)),
        (MISSED, count(Outcome::Missed)),
        ("△", count(Outcome::FalseAlarm)),
    ];
    let text = |at: Option<f64>| at.map_or("nowhere".into(), value);
    let [caught, missed, false_alarms] = marks.map(|(_, n)| n);
    let about = format!(
        "{}, {method}, {}: {name} at worst; safe to {}, beyond 2 % at {}, beyond 10 % at {}; \
         beyond 2 %: {caught} warned, {missed} unwarned; false alarms: {false_alarms}",
        study.about.name,
        half.name(),
        text(limit.safe_to),
        text(limit.breaks_at),
        text(limit.fails_at),
    );
    html! {
        td.(class).(end) title=(about) {
            b { (reach(&limit)) }
            small { (sign) @for (mark, n) in marks { @if n > 0 { " " span.missed[mark == MISSED] { (mark) (n) } } } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{row, side, study};
    use super::*;

    fn drawn(errors: &[Option<f64>], code: &str) -> String {
        let rows = (1..).zip(errors);
        let rows = rows.map(|(k, e)| row(f64::from(k), side(*e, code), None));
        cell(&study("one", rows.collect()), "default", Half::Cpu).into_string()
    }

    #[test]
    fn a_cell_says_where_it_breaks_and_who_said_so() {
        let silent = drawn(&[Some(0.001), Some(0.01), Some(0.05)], "");
        assert!(
            silent.contains("degrades") && silent.contains("to </i>2<") && silent.contains("✖1")
        );
        let told = drawn(&[Some(0.5), None], "thin");
        assert!(told.contains("fails") && told.contains("<b>–</b>") && told.contains("▲2"));
        let safe = drawn(&[Some(0.001)], "");
        assert!(safe.contains("<b>all</b>") && !safe.contains('✖') && !safe.contains('▲'));
        assert!(drawn(&[Some(0.001)], "thin").contains("△1"));
        let rows = vec![row(1.0, side(Some(0.0), ""), None)];
        let gpu = cell(&study("one", rows), "default", Half::Gpu);
        assert!(gpu.into_string().contains("n/a"));
    }
}
