//! Content of `stress.html`: the failure atlas.

use super::gates::AtlasGate;
use super::groups::{group_cases, method_names};
use super::json::AtlasSummary;
use super::methods::{DEFAULT_METHOD, ITEM_BUFFER_PIXELS};
use super::outcome::{WarningOutcome, format_amount, solver_sides, warning_outcome};
use super::score::WarningCounts;
use super::section::case_section;
use super::table::{breaks_table, case_anchor, table_legend};
use super::{AtlasRow, CaseStudy, LEAK_MEASURE, RELATIVE_RMS, error_limits, warnings};
use crate::report::format::{format_duration, format_percent};
use crate::report::page::{Page, render_verdict};
use crate::report::table::{TableRow, number_cell, render_table, text_cell};
use maud::{Markup, html};

pub(super) const ATLAS_STYLE: &str = include_str!("style.css");
/// Most rows of a gate that are listed.
const MAX_LISTED_ROWS: usize = 200;

/// Returns the page.
pub fn render_page(studies: &[CaseStudy], summary: &AtlasSummary) -> String {
    let groups = group_cases(studies);
    let links = html! {
        a href="#top" { "Overview" }
        a href="#warnings" { "Warnings" }
        @for (k, study) in studies.iter().enumerate() {
            a href=(format!("#{}", case_anchor(k))) { (study.info.name) }
        }
    };
    let body = html! {
        (page_head(studies, summary.gates))
        p.facts {
            (studies.len()) @if studies.len() == 1 { " case · " } @else { " cases · " } (method_names(studies).len()) " methods · GPU: " (summary.adapter.unwrap_or("none"))
            " · " (format_duration(summary.seconds))
        }
        (gates_table(summary.gates))
        (scores_table(studies, summary))
        h3 { "Where each method breaks first" }
        (table_legend())
        @for group in &groups { (breaks_table(group)) }
        @for (k, study) in studies.iter().enumerate() {
            @let group_of_case = groups.iter().find(|group| group.studies.iter().any(|(n, _)| *n == k));
            @if let Some(group) = group_of_case { (case_section(k, study, &group.methods)) }
        }
        (warnings::warnings_section(studies, &summary.score.codes))
    };
    Page {
        title: "Radiosity: the failure atlas",
        bar: ("Cases", links),
        verdict: html! {},
        style: ATLAS_STYLE,
        body,
    }
    .to_html()
}

/// Counts the cases with rows that satisfy `counts`, and those among them without missed errors.
fn count_safe_cases(studies: &[CaseStudy], is_counted: impl Fn(&AtlasRow) -> bool) -> [usize; 2] {
    let mut cases = [0; 2];
    for study in studies {
        let mut rows = study.rows.iter().filter(|row| is_counted(row)).peekable();
        if rows.peek().is_some() {
            let silent = rows
                .flat_map(solver_sides)
                .any(|(_, s)| warning_outcome(study.info.measure, s) == WarningOutcome::Missed);
            cases[0] += 1;
            cases[1] += usize::from(!silent);
        }
    }
    cases
}

fn page_head(studies: &[CaseStudy], gates: &[AtlasGate]) -> Markup {
    let run = studies.iter().any(|study| !study.rows.is_empty());
    let [of, leaks] = [RELATIVE_RMS, LEAK_MEASURE].map(|m| error_limits(m).map(|limit| format_amount(m, limit)));
    html! {
        p {
            "Each case is a family of scenes built to break one method, made harder step by step until it does. "
            "Every method answers each of them on both solvers, and is judged by the truth: up to " (of[0]) " off it is safe, "
            "up to " (of[1]) " it degrades, beyond that it fails; a result that is not safe needs a warning. "
            "Of the emitted light " (leaks[0]) " and " (leaks[1]) " may leak through a wall. "
            "The default is " code { "solve" } " without options; item buffers have " (ITEM_BUFFER_PIXELS) "² pixels, in the default as well."
        }
        (gates_verdict(gates, run))
    }
}

/// Returns the verdict line; without any rows the gates do not hold.
pub(super) fn gates_verdict(gates: &[AtlasGate], run: bool) -> Markup {
    match gates.iter().filter(|gate| !gate.held).count() {
        _ if !run => render_verdict(Some(false), "Not OK", html! { "nothing was run" }),
        0 => render_verdict(Some(true), "OK", html! { "all " (gates.len()) " gates hold" }),
        broken => render_verdict(
            Some(false),
            "Not OK",
            html! { (broken) " of " (gates.len()) " gates do not hold" },
        ),
    }
}

/// Table of the gates and their violations.
pub(super) fn gates_table(gates: &[AtlasGate]) -> Markup {
    let rows = gates.iter().map(|gate| {
        let violations = html! { @if !gate.broken.is_empty() { (broken_rows(&gate.broken)) } };
        TableRow::new([
            text_cell(gate.name),
            text_cell(gate_mark(gate.held)),
            text_cell(violations),
        ])
    });
    render_table("gates", &["Gate", "Holds", "Where it does not"], rows)
}

fn broken_rows(rows: &[String]) -> Markup {
    if let [only] = rows {
        return html! { (only) };
    }
    html! {
        details open[rows.len() <= 3] {
            summary { (rows.len()) " rows" }
            ul.broken { @for row in rows.iter().take(MAX_LISTED_ROWS) { li { (row) } } }
            @if rows.len() > MAX_LISTED_ROWS { p.small { "The other " (rows.len() - MAX_LISTED_ROWS) " are in stress.json." } }
        }
    }
}

fn scores_table(studies: &[CaseStudy], summary: &AtlasSummary) -> Markup {
    let lines: [(&str, &WarningCounts, [usize; 2]); 2] = [
        (
            "Default settings",
            &summary.score.default,
            count_safe_cases(studies, |row| row.method == DEFAULT_METHOD),
        ),
        ("All methods", &summary.score.all, count_safe_cases(studies, |_| true)),
    ];
    let rows = lines.map(|(name, counts, [cases, kept])| {
        let missed = html! { @if counts.missed > 0 { a href="#missed" { (counts.missed) } } @else { "0" } };
        TableRow::new([
            text_cell(name).as_heading(),
            number_cell(html! { (kept) " of " (cases) }),
            number_cell(counts.caught),
            number_cell(missed),
            number_cell(counts.false_alarms),
            number_cell(counts.quiet),
            number_cell(format_percent(counts.false_alarm_share())),
        ])
    });
    let heads = [
        "",
        "#Cases safe|or warned throughout",
        "#Caught|not safe, warned",
        "#Missed|not safe, silent",
        "#False alarms|safe, warned",
        "#Quiet|safe, silent",
        "#False alarms|of all answers",
    ];
    html! {
        (render_table("gates", &heads, rows))
        p.small { "Counted over answers: each value, method and solver is one. A refusal with a reason counts as a warning." }
    }
}

/// Returns ✓ or ■, so that colour is not the only sign.
fn gate_mark(ok: bool) -> Markup {
    html! {
        " " @if ok { span.pass { "✓ ok" } } @else { span.fail { "■ not ok" } }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{self, make_row, make_side, make_study};
    use super::super::score;
    use super::*;

    fn page_of(studies: &[CaseStudy]) -> String {
        let score = score::score_warnings(studies);
        let summary = AtlasSummary {
            score: &score,
            gates: &super::super::gates::evaluate_gates(studies, &score),
            adapter: Some("llvmpipe <&>"),
            seconds: 12.5,
        };
        render_page(studies, &summary)
    }

    #[test]
    fn page_contains_every_case_method_chart_and_specimen() {
        let studies = fixture::make_studies();
        let page = page_of(&studies);
        for (k, study) in studies.iter().enumerate() {
            let anchor = case_anchor(k);
            assert_eq!(page.matches(&format!("id=\"{anchor}\"")).count(), 1);
            assert!(page.contains(&format!("href=\"#{anchor}\"")));
            let name = html! { (study.info.name) }.into_string();
            assert!(page.contains(&format!("<h2>{name}</h2>")), "{name}");
        }
        let all = method_names(&studies);
        for method in &all {
            let name = html! { (method) }.into_string();
            assert!(page.contains(&format!("</svg><br>{name}</th>")), "{name}");
        }
        // A cell for each solver of each method in each case (one for the matrix), charts, specimens.
        let cells = page.matches(" at worst; ").count() + page.matches("title=\"not run\"").count();
        assert_eq!(cells, (2 * all.len() - 1) * studies.len());
        assert_eq!(page.matches("class=\"chart\"").count(), studies.len());
        let seen = studies.iter().filter(|s| s.specimen.is_some()).count();
        assert_eq!(page.matches("class=\"specimen\"").count(), seen);
    }

    #[test]
    fn page_has_no_external_references() {
        let page = page_of(&fixture::make_studies());
        assert!(page.contains("llvmpipe &lt;&amp;&gt;") && !page.contains("<&>"));
        let own = page.replace("http://www.w3.org/2000/svg", "");
        for outside in ["http://", "https://", "url(", "@import", "<script", "<link"] {
            assert!(!own.contains(outside), "{outside}");
        }
        let targets = ["href=\"", "src=\""].map(|name| own.split(name).skip(1));
        for target in targets.into_iter().flatten() {
            let inside = target.starts_with('#') || target.starts_with("data:image/png;");
            assert!(inside, "{}", &target[..40]);
        }
    }

    #[test]
    fn names_are_escaped_everywhere() {
        let bad = "a<script>&\"x";
        let mut said = make_side(None, "co<de");
        said.message = Some("why <b>not</b>".into());
        let mut one = make_study(bad, vec![make_row(0.5, said, None)]);
        one.info.parameter = "gap <m>";
        one.rows[0].method = "m<i>x";
        let page = page_of(&[one]);
        for raw in [bad, "co<de", "<b>not", "gap <m>", "m<i>x"] {
            assert!(!page.contains(raw), "{raw}");
        }
        for escaped in ["a&lt;script&gt;&amp;&quot;x", "co&lt;de", "m&lt;i&gt;x"] {
            assert!(page.contains(escaped), "{escaped}");
        }
    }

    #[test]
    fn verdict_is_ok_only_if_all_gates_hold() {
        let page = |error: f64, code: &str| {
            page_of(&[make_study(
                "one",
                vec![make_row(1.0, make_side(Some(error), code), None)],
            )])
        };
        for (error, code, ok) in [
            (0.01, "", true),
            (0.5, "thin", true),
            (0.5, "", false),
            (f64::NAN, "thin", false),
        ] {
            let page = page(error, code);
            assert_eq!(page.contains("<strong>OK</strong>"), ok, "{error} {code}");
            assert_eq!(page.contains("<strong>Not OK</strong>"), !ok);
        }
        assert!(page_of(&[]).contains("<strong>Not OK</strong>"));
    }
}
