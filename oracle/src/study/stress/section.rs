//! One case: what it breaks, its chart, its specimen, and all its figures.

use super::groups::names;
use super::outcome::{Half, Outcome, amount, error, outcome, value, values};
use super::table::{anchor, face, swatch};
use super::{Row, Side, Study, breaks, chart, limits, plates, specimen};
use crate::show::number::duration;
use crate::show::page;
use maud::{Markup, html};

/// The section of case `k`; `all` are the methods of its group, which decide the colours.
pub fn section(k: usize, study: &Study, all: &[&'static str]) -> Markup {
    let about = &study.about;
    html! {
        section id=(anchor(k)) {
            h2 { (about.name) }
            dl.about {
                dt { "Breaks" } dd { (about.breaks) }
                dt { "Swept" } dd { (about.parameter) ", " (extent(study)) }
                dt { "Truth" } dd { (about.truth) }
                dt { "Error" } dd { (about.measure) }
                dt { "Breaks first" } dd { (first(study)) }
            }
            div.case {
                (page::chart(chart::drawn(study, all).as_deref(), "Nothing was run.", caption(about.measure)))
                @match &study.specimen {
                    Some(specimen) => (specimen::view(specimen, about.parameter)),
                    None => p.none { "no specimen" },
                }
            }
            @if let Some(specimen) = &study.specimen { (plates::plates(specimen)) }
            (figures(study, all))
        }
    }
}

fn extent(study: &Study) -> String {
    let values = values(study);
    match (values.first(), values.last()) {
        (Some(first), Some(last)) if values.len() > 1 => {
            let (first, last) = (value(*first), value(*last));
            format!("from {first} to {last} in {} steps", values.len())
        }
        (Some(only), _) => value(*only),
        _ => "no values".into(),
    }
}

/// Who is no longer safe at which value, in the order of the sweep.
fn first(study: &Study) -> Markup {
    html! {
        @for (at, who) in breaks::in_order(study) {
            div {
                @match at { Some(at) => { "at " b { (value(at)) } }, None => b { "nowhere" } }
                ": " (who.join("; "))
            }
        }
    }
}

/// The chart's key.
fn caption(measure: &str) -> Markup {
    let small = |inner: Markup| {
        html! { svg.inline viewBox="0 0 30 18" aria-hidden="true" { (inner) } }
    };
    let circle = |fill: &str| {
        small(
            html! { circle cx="15" cy="9" r="6" fill=(fill) stroke="currentColor" stroke-width="2" {} },
        )
    };
    html! {
        (small(html! { path d="M0 9H30" stroke="currentColor" stroke-opacity=".4" stroke-width="6" {} circle cx="15" cy="9" r="6" fill="currentColor" fill-opacity=".4" stroke="currentColor" stroke-width="1.5" {} }))
        " CPU · "
        (small(html! { path d="M0 9H30" stroke="currentColor" stroke-width="2" stroke-dasharray="6 4" {} circle cx="15" cy="9" r="3.5" fill="currentColor" {} }))
        " GPU · " (circle("none")) " hollow: it warned · " (circle("currentColor"))
        " filled beyond " (amount(measure, limits(measure)[0])) ": it failed in silence · "
        b { "✖" } " no answer. Point at a mark to read what it is."
    }
}

/// All values and methods, folded.
fn figures(study: &Study, all: &[&'static str]) -> Markup {
    let own = names([study]);
    let count = |x: f64| study.rows.iter().filter(|row| row.value == x).count();
    html! {
        details {
            summary { "All figures: " (values(study).len()) " values, " (own.len()) " methods" }
            div.scroll { table {
                thead { tr {
                    th.n { (study.about.parameter) } th { "Method" }
                    @for half in Half::BOTH { th.n { (half.name()) } }
                    th.n { "Time" br; "CPU · GPU" } th { "Warnings, what was changed, why there is no answer" }
                } }
                tbody { @for x in values(study) {
                    @for (k, row) in study.rows.iter().filter(|row| row.value == x).enumerate() { tr {
                        @if k == 0 { td.n rowspan=(count(x)) { b { (value(x)) } } }
                        td { (swatch(all.iter().position(|m| *m == row.method).unwrap_or(0))) (row.method) }
                        @for half in Half::BOTH { (shown(half.of(row), study.about.measure)) }
                        td.n { (duration(row.cpu.seconds)) " · " (row.gpu.as_ref().map_or("–".into(), |s| duration(s.seconds))) }
                        td.told { (told(row)) }
                    } }
                } }
            } }
        }
    }
}

fn shown(side: Option<&Side>, measure: &str) -> Markup {
    let Some(side) = side else {
        return html! { td.n.none-here { "n/a" } };
    };
    let (class, sign, _) = face(side.verdict);
    let mark = match outcome(measure, side) {
        Outcome::Caught => " ▲",
        Outcome::Missed => " ✖",
        Outcome::FalseAlarm => " △",
        Outcome::Quiet => "",
    };
    html! { td.n.(class) { (sign) " " (error(side, measure)) (mark) } }
}

/// What both sides say; once where they say the same.
fn told(row: &Row) -> Markup {
    let cpu = lines(&row.cpu);
    let gpu = row.gpu.as_ref().map(lines);
    let part = |name: &str, lines: &[(bool, String)]| {
        html! {
            @for (code, line) in lines { div {
                @if !name.is_empty() { b { (name) " " } }
                @if *code { code { (line) } } @else { (line) }
            } }
        }
    };
    match gpu {
        Some(gpu) if gpu == cpu => part("", &cpu),
        Some(gpu) => html! { (part("CPU", &cpu)) (part("GPU", &gpu)) },
        None => part("", &cpu),
    }
}

/// Codes first, then sentences.
fn lines(side: &Side) -> Vec<(bool, String)> {
    let codes = side.warnings.iter().map(|code| (true, code.clone()));
    let others = side.notes.iter().chain(&side.message);
    codes
        .chain(others.map(|line| (false, line.clone())))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{row, side, study};
    use super::*;

    #[test]
    fn what_both_say_is_told_once() {
        let same = row(1.0, side(Some(0.1), "thin"), Some(side(Some(0.2), "thin")));
        assert_eq!(told(&same).into_string().matches("thin").count(), 1);
        let other = row(1.0, side(Some(0.1), "thin"), Some(side(Some(0.2), "")));
        let text = told(&other).into_string();
        assert!(text.contains("CPU") && !text.contains("GPU"));
    }

    #[test]
    fn every_row_is_in_the_folded_table() {
        let rows = (1..=4).map(|k| row(f64::from(k), side(Some(0.01), ""), None));
        let page = section(0, &study("a<b", rows.collect()), &["default"]).into_string();
        assert_eq!(page.matches("rowspan=\"1\"").count(), 4);
        assert!(page.contains("a&lt;b") && !page.contains("a<b"));
        assert!(page.contains("no specimen"));
    }
}
