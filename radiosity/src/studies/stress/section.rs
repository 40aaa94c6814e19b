//! Section of one case: description, chart, specimen and all figures.

use super::groups::method_names;
use super::outcome::{
    Processor, WarningOutcome, format_amount, format_error, format_value, swept_values, warning_outcome,
};
use super::table::{case_anchor, method_swatch, verdict_style};
use super::{AtlasRow, CaseStudy, SolverSide, breaks, chart, error_limits, specimen};
use crate::report::format::format_duration;
use crate::report::page;
use maud::{Markup, html};

/// Returns the section of case `k`; `all` are the methods of its group, which determine the colours.
pub fn case_section(k: usize, study: &CaseStudy, all: &[&'static str]) -> Markup {
    let about = &study.info;
    html! {
        section id=(case_anchor(k)) {
            h2 { (about.name) }
            dl.about {
                dt { "Breaks" } dd { (about.breaks) }
                dt { "Swept" } dd { (about.parameter) ", " (format_extent(study)) }
                dt { "Truth" } dd { (about.truth) }
                dt { "Error" } dd { (about.measure) }
                dt { "Breaks first" } dd { (breaks_list(study)) }
            }
            div.case {
                (page::render_chart(chart::draw_case(study, all).as_deref(), "Nothing was run.", chart_caption(about.measure)))
                @match &study.specimen {
                    Some(specimen) => (specimen::draw_specimen(specimen, about.parameter)),
                    None => p.none { "no specimen" },
                }
            }
            @if let Some(specimen) = &study.specimen { (specimen::draw_plates(specimen)) }
            (figures_table(study, all))
        }
    }
}

fn format_extent(study: &CaseStudy) -> String {
    let values = swept_values(study);
    match (values.first(), values.last()) {
        (Some(first), Some(last)) if values.len() > 1 => {
            let (first, last) = (format_value(*first), format_value(*last));
            format!("from {first} to {last} in {} steps", values.len())
        }
        (Some(only), _) => format_value(*only),
        _ => "no values".into(),
    }
}

/// Lists the methods by the first value at which they are not safe.
fn breaks_list(study: &CaseStudy) -> Markup {
    html! {
        @for (at, who) in breaks::breaks_in_order(study) {
            div {
                @match at { Some(at) => { "at " b { (format_value(at)) } }, None => b { "nowhere" } }
                ": " (who.join("; "))
            }
        }
    }
}

/// Returns the chart's caption.
fn chart_caption(measure: &str) -> Markup {
    let small = |inner: Markup| {
        html! { svg.inline viewBox="0 0 30 18" aria-hidden="true" { (inner) } }
    };
    let circle =
        |fill: &str| small(html! { circle cx="15" cy="9" r="6" fill=(fill) stroke="currentColor" stroke-width="2" {} });
    html! {
        (small(html! { path d="M0 9H30" stroke="currentColor" stroke-opacity=".4" stroke-width="6" {} circle cx="15" cy="9" r="6" fill="currentColor" fill-opacity=".4" stroke="currentColor" stroke-width="1.5" {} }))
        " CPU · "
        (small(html! { path d="M0 9H30" stroke="currentColor" stroke-width="2" stroke-dasharray="6 4" {} circle cx="15" cy="9" r="3.5" fill="currentColor" {} }))
        " GPU · " (circle("none")) " hollow: it warned · " (circle("currentColor"))
        " filled beyond " (format_amount(measure, error_limits(measure)[0])) ": it failed in silence · "
        b { "✖" } " no answer. Point at a mark for details."
    }
}

/// Table of all values and methods, folded.
fn figures_table(study: &CaseStudy, all: &[&'static str]) -> Markup {
    let methods = method_names([study]);
    let count = |x: f64| study.rows.iter().filter(|row| row.value == x).count();
    html! {
        details {
            summary { "All figures: " (swept_values(study).len()) " values, " (methods.len()) " methods" }
            div.scroll { table {
                thead { tr {
                    th.n { (study.info.parameter) } th { "Method" }
                    @for processor in Processor::BOTH { th.n { (processor.name()) } }
                    th.n { "Time" br; "CPU · GPU" } th { "Warnings, notes, error message" }
                } }
                tbody { @for x in swept_values(study) {
                    @for (k, row) in study.rows.iter().filter(|row| row.value == x).enumerate() { tr {
                        @if k == 0 { td.n rowspan=(count(x)) { b { (format_value(x)) } } }
                        td { (method_swatch(all.iter().position(|m| *m == row.method).unwrap_or(0))) (row.method) }
                        @for processor in Processor::BOTH { (side_cell(processor.side_of(row), study.info.measure)) }
                        td.n { (format_duration(row.cpu.seconds)) " · " (row.gpu.as_ref().map_or("–".into(), |s| format_duration(s.seconds))) }
                        td.told { (messages_of_row(row)) }
                    } }
                } }
            } }
        }
    }
}

fn side_cell(side: Option<&SolverSide>, measure: &str) -> Markup {
    let Some(side) = side else {
        return html! { td.n.none-here { "n/a" } };
    };
    let (class, sign, _) = verdict_style(side.verdict);
    let mark = match warning_outcome(measure, side) {
        WarningOutcome::Caught => " ▲",
        WarningOutcome::Missed => " ✖",
        WarningOutcome::FalseAlarm => " △",
        WarningOutcome::Quiet => "",
    };
    html! { td.n.(class) { (sign) " " (format_error(side, measure)) (mark) } }
}

/// Lists the messages of both solvers, once if they are equal.
fn messages_of_row(row: &AtlasRow) -> Markup {
    let cpu = messages_of_side(&row.cpu);
    let gpu = row.gpu.as_ref().map(messages_of_side);
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

/// Returns the warning codes (true), then notes and message (false).
fn messages_of_side(side: &SolverSide) -> Vec<(bool, String)> {
    let codes = side.warnings.iter().map(|code| (true, code.clone()));
    let others = side.notes.iter().chain(&side.message);
    codes.chain(others.map(|line| (false, line.clone()))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{make_row, make_side, make_study};
    use super::*;

    #[test]
    fn equal_messages_of_both_solvers_appear_once() {
        let same = make_row(1.0, make_side(Some(0.1), "thin"), Some(make_side(Some(0.2), "thin")));
        assert_eq!(messages_of_row(&same).into_string().matches("thin").count(), 1);
        let other = make_row(1.0, make_side(Some(0.1), "thin"), Some(make_side(Some(0.2), "")));
        let text = messages_of_row(&other).into_string();
        assert!(text.contains("CPU") && !text.contains("GPU"));
    }

    #[test]
    fn every_row_is_in_the_folded_table() {
        let rows = (1..=4).map(|k| make_row(f64::from(k), make_side(Some(0.01), ""), None));
        let page = case_section(0, &make_study("a<b", rows.collect()), &["default"]).into_string();
        assert_eq!(page.matches("rowspan=\"1\"").count(), 4);
        assert!(page.contains("a&lt;b") && !page.contains("a<b"));
        assert!(page.contains("no specimen"));
    }
}
