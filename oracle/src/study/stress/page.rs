//! `stress.html`: the failure atlas in one file that opens offline.

use super::gates::Gate;
use super::groups::{groups, names};
use super::json::Told;
use super::methods::{DEFAULT, PIXELS};
use super::outcome::{Outcome, amount, outcome, sides};
use super::score::Counts;
use super::section::section;
use super::table::{anchor, key, table};
use super::{LEAK, RELATIVE, Row, Study, indicators, limits};
use crate::show::number::{duration, percent};
use crate::show::page::{self, Page, verdict};
use maud::{Markup, html};

pub(super) const STYLE: &str = include_str!("style.css");
/// Rows of a gate that are listed.
const LISTED: usize = 200;

/// The page; `told` is what the runner found.
pub fn page(studies: &[Study], told: &Told) -> String {
    let groups = groups(studies);
    let links = html! {
        a href="#top" { "Overview" }
        a href="#warnings" { "Warnings" }
        @for (k, study) in studies.iter().enumerate() {
            a href=(format!("#{}", anchor(k))) { (study.about.name) }
        }
    };
    let body = html! {
        (head(studies, told.gates))
        p.facts {
            (studies.len()) @if studies.len() == 1 { " case · " } @else { " cases · " } (names(studies).len()) " methods · GPU: " (told.adapter.unwrap_or("none"))
            " · " (duration(told.seconds))
        }
        (gates(told.gates))
        (scores(studies, told))
        h3 { "Where each method breaks first" }
        (key())
        @for group in &groups { (table(group)) }
        @for (k, study) in studies.iter().enumerate() {
            @let own = groups.iter().find(|group| group.studies.iter().any(|(n, _)| *n == k));
            @if let Some(group) = own { (section(k, study, &group.methods)) }
        }
        (indicators::section(studies, &told.score.codes))
    };
    Page {
        title: "Radiosity: the failure atlas",
        bar: ("Cases", links),
        verdict: html! {},
        style: STYLE,
        body,
    }
    .html()
}

/// Cases, and those of them in which these rows were never beyond the limit in silence.
fn kept(studies: &[Study], counts: impl Fn(&Row) -> bool) -> [usize; 2] {
    let mut found = [0; 2];
    for study in studies {
        let mut own = study.rows.iter().filter(|row| counts(row)).peekable();
        if own.peek().is_some() {
            let silent = own
                .flat_map(sides)
                .any(|(_, s)| outcome(study.about.measure, s) == Outcome::Missed);
            found[0] += 1;
            found[1] += usize::from(!silent);
        }
    }
    found
}

fn head(studies: &[Study], gates: &[Gate]) -> Markup {
    let run = studies.iter().any(|study| !study.rows.is_empty());
    let [of, leaks] = [RELATIVE, LEAK].map(|m| limits(m).map(|limit| amount(m, limit)));
    html! {
        p {
            "Each case is a family of scenes built to break one method, made harder step by step until it does. "
            "Every method answers each of them on both solvers, and is judged by the truth: up to " (of[0]) " off it is safe, "
            "up to " (of[1]) " it degrades, beyond that it fails; and what is not safe must be warned about. "
            "Of the emitted light " (leaks[0]) " and " (leaks[1]) " may leak through a wall. "
            "The default is what " code { "solve" } " does without options; item buffers have " (PIXELS) "² pixels, in the default as well."
        }
        (held(gates, run))
    }
}

/// Whether all gates hold; nothing holds where nothing was run.
pub(super) fn held(gates: &[Gate], run: bool) -> Markup {
    match gates.iter().filter(|gate| !gate.held).count() {
        _ if !run => verdict(Some(false), "Not OK", html! { "nothing was run" }),
        0 => verdict(
            Some(true),
            "OK",
            html! { "all " (gates.len()) " gates hold" },
        ),
        broken => verdict(
            Some(false),
            "Not OK",
            html! { (broken) " of " (gates.len()) " gates do not hold" },
        ),
    }
}

/// What must hold, and where it does not.
pub(super) fn gates(gates: &[Gate]) -> Markup {
    html! {
        (page::table("gates", &["Gate", "Holds", "Where it does not"], html! {
            @for gate in gates { tr {
                td { (gate.name) }
                td { (mark(gate.held)) }
                td { @if !gate.broken.is_empty() { (broken(&gate.broken)) } }
            } }
        }))
    }
}

fn broken(rows: &[String]) -> Markup {
    if let [only] = rows {
        return html! { (only) };
    }
    html! {
        details open[rows.len() <= 3] {
            summary { (rows.len()) " rows" }
            ul.broken { @for row in rows.iter().take(LISTED) { li { (row) } } }
            @if rows.len() > LISTED { p.small { "The other " (rows.len() - LISTED) " are in stress.json." } }
        }
    }
}

fn scores(studies: &[Study], told: &Told) -> Markup {
    let lines: [(&str, &Counts, [usize; 2]); 2] = [
        (
            "Default settings",
            &told.score.default,
            kept(studies, |row| row.method == DEFAULT),
        ),
        ("All methods", &told.score.all, kept(studies, |_| true)),
    ];
    html! {
        (page::table("gates", &["", "#Cases safe|or warned throughout", "#Caught|not safe, warned",
            "#Missed|not safe, silent", "#False alarms|safe, warned", "#Quiet|safe, silent",
            "#False alarms|of all answers"], html! {
            @for (name, counts, [cases, kept]) in lines { tr {
                th { (name) }
                td.n { (kept) " of " (cases) }
                td.n { (counts.caught) }
                td.n { @if counts.missed > 0 { a href="#missed" { (counts.missed) } } @else { "0" } }
                td.n { (counts.false_alarms) }
                td.n { (counts.quiet) }
                td.n { (percent(counts.false_share())) }
            } }
        }))
        p.small { "Counted over answers: each value, method and solver is one. A refusal with a reason is a warning." }
    }
}

/// ✓ or ■, and no colour alone.
fn mark(ok: bool) -> Markup {
    html! {
        " " @if ok { span.pass { "✓ ok" } } @else { span.fail { "■ not ok" } }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{self, row, side, study};
    use super::super::score;
    use super::*;

    fn of(studies: &[Study]) -> String {
        let score = score::of(studies);
        let told = Told {
            score: &score,
            gates: &super::super::gates::of(studies, &score),
            adapter: Some("llvmpipe <&>"),
            seconds: 12.5,
        };
        page(studies, &told)
    }

    #[test]
    fn the_whole_page_names_everything() {
        let studies = fixture::studies();
        let page = of(&studies);
        for (k, study) in studies.iter().enumerate() {
            let anchor = anchor(k);
            assert_eq!(page.matches(&format!("id=\"{anchor}\"")).count(), 1);
            assert!(page.contains(&format!("href=\"#{anchor}\"")));
            let name = html! { (study.about.name) }.into_string();
            assert!(page.contains(&format!("<h2>{name}</h2>")), "{name}");
        }
        let all = names(&studies);
        for method in &all {
            let name = html! { (method) }.into_string();
            assert!(page.contains(&format!("</svg><br>{name}</th>")), "{name}");
        }
        // A cell for each half of each method in each case (the matrix has one), all charts, most specimens.
        let cells = page.matches(" at worst; ").count() + page.matches("title=\"not run\"").count();
        assert_eq!(cells, (2 * all.len() - 1) * studies.len());
        assert_eq!(page.matches("class=\"chart\"").count(), studies.len());
        let seen = studies.iter().filter(|s| s.specimen.is_some()).count();
        assert_eq!(page.matches("class=\"specimen\"").count(), seen);
    }

    #[test]
    fn it_refers_to_nothing_outside() {
        let page = of(&fixture::studies());
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
        let mut said = side(None, "co<de");
        said.message = Some("why <b>not</b>".into());
        let mut one = study(bad, vec![row(0.5, said, None)]);
        one.about.parameter = "gap <m>";
        one.rows[0].method = "m<i>x";
        let page = of(&[one]);
        for raw in [bad, "co<de", "<b>not", "gap <m>", "m<i>x"] {
            assert!(!page.contains(raw), "{raw}");
        }
        for escaped in ["a&lt;script&gt;&amp;&quot;x", "co&lt;de", "m&lt;i&gt;x"] {
            assert!(page.contains(escaped), "{escaped}");
        }
    }

    #[test]
    fn ok_is_said_only_when_it_is() {
        let page = |error: f64, code: &str| {
            of(&[study("one", vec![row(1.0, side(Some(error), code), None)])])
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
        assert!(of(&[]).contains("<strong>Not OK</strong>"));
    }
}
