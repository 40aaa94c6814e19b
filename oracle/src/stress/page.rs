//! `stress.html`: the failure atlas in one file that opens offline.

use super::outcome::{Outcome, broken, methods, outcome, sides};
use super::score::{DEFAULT, Score};
use super::section::section;
use super::table::{anchor, table};
use super::{Row, Study, indicators};
use crate::report::document;
use crate::report::number::number;
use maud::{Markup, PreEscaped, html};

const STYLE: &str = include_str!("style.css");

/// The page; `score` is that of the default settings.
pub fn page(studies: &[Study], score: &Score, adapter: Option<&str>, seconds: f64) -> String {
    let title = "Radiosity: the failure atlas";
    let all = methods(studies);
    let nav = html! {
        nav aria-label="Cases" {
            a href="#top" { "Overview" }
            @for (k, study) in studies.iter().enumerate() {
                a href=(format!("#{}", anchor(k))) { (study.about.name) }
            }
            a href="#warnings" { "Warnings" }
        }
    };
    let body = html! {
        style { (PreEscaped(STYLE)) }
        header #top { h1 { (title) } }
        (head(studies, score))
        p.facts {
            (studies.len()) " cases · " (all.len()) " methods · GPU: " (adapter.unwrap_or("none"))
            " · " (number(seconds)) " s"
        }
        (scores(studies, score))
        h3 { "How far each method holds" }
        (table(studies, &all))
        @for (k, study) in studies.iter().enumerate() { (section(k, study, &all)) }
        (indicators::section(studies))
    };
    document(title, &nav, &body)
}

/// What is counted over the rows of one method, or of all.
struct Tally {
    cases: usize,
    /// Of them, those in which nothing was beyond 2 % in silence.
    kept: usize,
    /// Panics, and errors that are no numbers.
    broken: usize,
}

impl Tally {
    fn new(studies: &[Study], counts: impl Fn(&Row) -> bool) -> Self {
        let rows = |study: &'_ Study| -> Vec<Row> {
            study.rows.iter().filter(|r| counts(r)).cloned().collect()
        };
        let mut tally = Self {
            cases: 0,
            kept: 0,
            broken: 0,
        };
        for rows in studies.iter().map(rows).filter(|rows| !rows.is_empty()) {
            let silent = |row: &Row| sides(row).any(|(_, s)| outcome(s) == Outcome::Missed);
            let broken = rows.iter().flat_map(sides).filter(|(_, s)| broken(s));
            tally.cases += 1;
            tally.kept += usize::from(!rows.iter().any(silent));
            tally.broken += broken.count();
        }
        tally
    }
}

fn head(studies: &[Study], score: &Score) -> Markup {
    let own = Tally::new(studies, |row| row.method == DEFAULT);
    let kept = own.cases > 0 && own.kept == own.cases && score.missed == 0 && own.broken == 0;
    html! {
        p {
            "Each case is a family of scenes built to break one method, made harder step by step until it does. "
            "Every method answers each of them on both solvers, and is judged by the truth: up to 2 % off it is safe, "
            "up to 10 % it degrades, beyond that it fails, and beyond 2 % it must have warned."
        }
        p.verdict.(if kept { "agree" } else { "disagree" }) {
            strong { (if kept { "OK" } else { "Not OK" }) }
            @if own.cases == 0 { " nothing was run at the default settings" } @else {
                " at the default settings: " (own.kept) " of " (own.cases)
                " cases within 2 % or warned about throughout; wrong in silence: " (score.missed)
                "; panics and NaN: " (own.broken)
            }
        }
    }
}

fn scores(studies: &[Study], score: &Score) -> Markup {
    let everything = studies.iter().flat_map(|study| &study.rows);
    let lines = [
        (
            true,
            *score,
            Tally::new(studies, |row| row.method == DEFAULT),
        ),
        (false, Score::of(everything), Tally::new(studies, |_| true)),
    ];
    html! {
        div.scroll { table.gates {
            thead { tr {
                th {} th.n { "Cases within 2 %" br; "or warned throughout" }
                th.n { "Caught" br; "beyond 2 %, warned" } th.n { "Missed" br; "beyond 2 %, silent" }
                th.n { "False alarms" br; "safe, warned" } th.n { "Quiet" br; "safe, silent" }
                th.n { "Panics, NaN" }
            } }
            tbody { @for (gate, score, tally) in lines { tr {
                th { (if gate { "Default settings" } else { "All methods" }) }
                td.n { (tally.kept) " of " (tally.cases) @if gate { (mark(tally.cases > 0 && tally.kept == tally.cases)) } }
                td.n { (score.caught) }
                td.n { @if score.missed > 0 { a href="#missed" { (score.missed) } } @else { "0" } @if gate { (mark(score.missed == 0)) } }
                td.n { (score.false_alarms) }
                td.n { (score.quiet) }
                td.n { (tally.broken) @if gate { (mark(tally.broken == 0)) } }
            } } }
        } }
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
    use super::*;

    fn of(studies: &[Study]) -> String {
        let own = studies.iter().flat_map(|study| &study.rows);
        let score = Score::of(own.filter(|row| row.method == DEFAULT));
        page(studies, &score, Some("llvmpipe <&>"), 12.5)
    }

    /// Also the page to be looked at: `STRESS_PAGE=file cargo test … the_whole_page`.
    #[test]
    fn the_whole_page_names_everything() {
        let studies = fixture::studies();
        let page = of(&studies);
        if let Some(path) = std::env::var_os("STRESS_PAGE") {
            std::fs::write(path, &page).unwrap();
        }
        for (k, study) in studies.iter().enumerate() {
            let anchor = anchor(k);
            assert_eq!(page.matches(&format!("id=\"{anchor}\"")).count(), 1);
            assert!(page.contains(&format!("href=\"#{anchor}\"")));
            let name = html! { (study.about.name) }.into_string();
            assert!(page.contains(&format!("<h2>{name}</h2>")), "{name}");
        }
        let all = methods(&studies);
        for method in &all {
            let name = html! { (method) }.into_string();
            assert!(page.contains(&format!("</span>{name}</th>")), "{name}");
        }
        // A cell for each half of each method in each case, all charts, most specimens.
        let cells = page.matches(" at worst; ").count() + page.matches("title=\"not run\"").count();
        assert_eq!(cells, 2 * all.len() * studies.len());
        assert_eq!(page.matches("class=\"chart\"").count(), studies.len());
        let seen = studies.iter().filter(|s| s.specimen.is_some()).count();
        assert_eq!(page.matches("class=\"specimen\"").count(), seen);
    }

    #[test]
    fn it_refers_to_nothing_outside() {
        let page = of(&fixture::studies()[..4]);
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
