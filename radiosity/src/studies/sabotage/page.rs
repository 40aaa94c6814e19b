//! Content of `sabotage.html`: survivors, scores by shader and by operator, and all mutants.

use super::score::Score;
use super::{JudgedMutant, MutantVerdict};
use crate::report::document::{Blocks, Row, Table, VerdictTone, code_text, plain_text, render_document};
use crate::report::format::format_percent;

const PAGE_TEXT: &str = "Each mutant is one small change of a shader. “compare” judges it by small scenes, the cheapest \
    first, until a criterion does not hold. One that survives shows a check that is missing, or does the same as the \
    original.";

/// Returns the page; `existing` is the number of mutants that could have been drawn.
pub fn render_page(judged: &[JudgedMutant], existing: usize) -> String {
    let score = Score::new(judged);
    let mut opening = Blocks::default();
    opening.add_paragraph(PAGE_TEXT);
    let (tone, word) = match score.has_gap() {
        false => (VerdictTone::Good, "OK"),
        true => (VerdictTone::Bad, "Not OK"),
    };
    opening.add_verdict(tone, word, format!("{}; {existing} exist", score.describe()));
    let mut scores = Blocks::default();
    scores
        .add_table(score_table("Shader", Score::by_name(judged, |mutant| &mutant.shader)))
        .add_table(score_table(
            "Operator",
            Score::by_name(judged, |mutant| &mutant.operator),
        ));
    let survives = |mutant: &&JudgedMutant| matches!(mutant.verdict, MutantVerdict::Survived | MutantVerdict::NotRun);
    let gaps: Vec<&JudgedMutant> = judged.iter().filter(survives).collect();
    let others: Vec<&JudgedMutant> = judged.iter().filter(|mutant| !survives(mutant)).collect();
    let sections = [("survivors", "Survivors", gaps), ("others", "Others", others)].map(|(id, title, mutants)| {
        let mut body = Blocks::default();
        body.add_table(mutant_table(&mutants, id != "survivors"));
        body.into_section(id, title)
    });
    let [survivors, others] = sections;
    let sections = [survivors, scores.into_section("scores", "Scores"), others];
    render_document("Radiosity: sabotage", &opening, &sections, "")
}

fn score_table(head: &str, groups: Vec<(&str, Score)>) -> Table {
    let row = |(name, score): (&str, Score)| {
        let share = score.killed_share().map_or("—".into(), format_percent);
        let counts = [
            score.mutants,
            score.killed,
            score.stage_named,
            score.divergence_right,
            score.survived,
            score.equivalent,
            score.invalid,
            score.not_run,
        ];
        let cells = [name.to_owned(), share].into_iter();
        Row::new(cells.chain(counts.iter().map(ToString::to_string)))
    };
    let heads = format!(
        "{head};#Score;#Mutants;#Killed;#By own|stage;#Divergence|right;#Survived;#Equivalent;#Invalid;#Not run"
    );
    Table::new(&heads, groups.into_iter().map(row))
}

/// Returns the table of mutants; those that survive have no reason.
fn mutant_table(mutants: &[&JudgedMutant], with_reason: bool) -> Table {
    let row = |mutant: &&JudgedMutant| {
        let verdict = match mutant.verdict {
            MutantVerdict::Killed => "killed",
            MutantVerdict::Survived => "survived",
            MutantVerdict::Equivalent => "equivalent",
            MutantVerdict::Invalid => "invalid",
            MutantVerdict::NotRun => "not run",
        };
        let reason = with_reason.then(|| plain_text(&mutant.reason));
        let cells = [
            plain_text(format!("{}:{}", mutant.file, mutant.line)),
            plain_text(&mutant.operator),
            code_text(&mutant.original) + " → " + code_text(&mutant.mutated),
            code_text(&mutant.line_text),
            plain_text(verdict),
        ];
        Row::new(cells.into_iter().chain(reason))
    };
    let heads = match with_reason {
        true => "Place;Operator;Change;~Line;Verdict;~Reason",
        false => "Place;Operator;Change;~Line;Verdict",
    };
    Table::new(heads, mutants.iter().map(row))
}
