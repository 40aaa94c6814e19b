//! Composes `report.html` of `compare`: verdict, overview and viewers, a section per comparison, and the explanation.

use super::divergence::add_first_divergence;
use super::figures::ComparisonPictures;
use crate::report::document::{
    Blocks, Cell, Row, Section, Table, Text, VerdictTone, bold_text, code_text, link_text, pass_mark, plain_text,
    render_document, styled_text,
};
use crate::report::energy::add_energy_balances;
use crate::report::format::{count_noun, file_name, format_count, format_duration, format_number, format_percent};
use crate::report::viewer;
use oracle::compare::comparison::{Comparison, Preset, SceneComparison};

/// Name of the row that should be 0.
const UNEXPLAINED_ROW: &str = "–– unexplained";
/// Paragraphs of the explanation: bold first words, and the rest.
const METHOD_PARAGRAPHS: [(&str, &str); 3] = [
    (
        "Each scene is solved twice.",
        " On the CPU rays determine visibility. On the GPU the scene is drawn from the shooter, each face in its own \
         colour (the item buffer), and a texel is visible if its pixel has its face's colour. A third solver is compared \
         with both: the twin, the shaders' algorithm in plain Rust. Shader and twin may differ by rounding only, twin \
         and rays only next to a boundary between two faces in the item buffer.",
    ),
    (
        "Lockstep and free.",
        " In lockstep one solver repeats the other's decisions: which patch shoots, or which links are refined. In a free \
         run each decides on its own, as in normal use; solves to an error may then differ by the estimated errors.",
    ),
    (
        "Agreement is not accuracy.",
        " A criterion that fails means a fault in the code. Two solvers of one method agree, however crude the method \
         is. Beside the verdict stands therefore the error of each solution, against the dense matrix of all texels with \
         independent form factors and visibility. Limits of the method are listed as findings, each with its size and \
         a remedy.",
    ),
];

/// Renders the report; `notes` name the omitted scenes with reasons.
pub fn render_report(judged: &[SceneComparison], notes: &[String]) -> String {
    let mut opening = Blocks::default();
    add_headline(&mut opening, judged);
    opening.add_notes(notes).add_table(overview_table(judged));
    let mut sections = Vec::new();
    for (k, scene) in judged.iter().enumerate() {
        opening.add_heading(file_name(&scene.first.scene.name));
        for (n, c) in scene.iter_comparisons().enumerate() {
            let pictures = ComparisonPictures::new(c);
            let id = section_id(k, c.preset != scene.first.preset);
            sections.push(comparison_section(id, c, &pictures));
            if n == 0 {
                opening.add_element(pictures.viewer);
            }
        }
    }
    let mut method = Blocks::default();
    for (start, rest) in METHOD_PARAGRAPHS {
        method.add_paragraph(bold_text(start) + rest);
    }
    method.add_element(viewer::page_assets());
    sections.push(method.into_section("how", "Method of comparison"));
    render_document("Radiosity: CPU against GPU", &opening, &sections, "")
}

/// Returns the anchor of a comparison of scene `k`: with the defaults of `solve`, or with other settings.
fn section_id(k: usize, is_solve_default: bool) -> String {
    format!("scene-{}{}", k + 1, if is_solve_default { "-solve" } else { "" })
}

/// Formats a share of each solver; – where it is not known.
fn format_errors(errors: [Option<f64>; 2]) -> [String; 2] {
    errors.map(|error| error.map_or("–".into(), format_percent))
}

fn add_headline(opening: &mut Blocks, judged: &[SceneComparison]) {
    let all = judged.len();
    let differ = judged.iter().filter(|scene| !scene.all_agree()).count();
    let scenes = if all == 1 { "scene" } else { "scenes" };
    let (tone, word, says) = match (all, differ) {
        (0, _) => (
            VerdictTone::Bad,
            "Nothing compared",
            "no scene was solved by both".into(),
        ),
        (_, 0) => (
            VerdictTone::Good,
            "Agree",
            format!("CPU and GPU, on {all} of {all} {scenes}"),
        ),
        _ => (VerdictTone::Bad, "Disagree", format!("on {differ} of {all} {scenes}")),
    };
    opening.add_verdict(tone, word, says);
}

fn overview_table(judged: &[SceneComparison]) -> Table {
    let both = |values: [String; 2]| values.join(" · ").into();
    let row = |(k, scene, c): (usize, &SceneComparison, &Comparison)| {
        let differences = [&c.lockstep_difference, &c.free_difference];
        let cells: [Cell; 6] = [
            pass_mark(c.solvers_agree()).into(),
            link_text(section_id(k, c.preset != scene.first.preset), file_name(&c.scene.name)).into(),
            c.preset.name().into(),
            both(format_errors(c.truth_error)),
            both(differences.map(|difference| format_percent(difference.relative_rms))),
            both(c.seconds.map(format_duration)),
        ];
        Row::new(cells).with_class_if(!c.solvers_agree(), "bad")
    };
    let all = judged.iter().enumerate();
    let all = all.flat_map(|(k, scene)| scene.iter_comparisons().map(move |c| (k, scene, c)));
    let heads = ";Scene;Preset;#Error of the solution|CPU · GPU;#GPU − CPU, RMS|lockstep · free;#Time|CPU · GPU";
    Table::new(heads, all.map(row))
}

fn comparison_section(id: String, c: &Comparison, pictures: &ComparisonPictures) -> Section {
    let mut body = Blocks::default();
    body.add_paragraph(bold_text(c.preset.name()) + ", " + code_text(&c.scene.name));
    add_verdict(&mut body, c);
    add_accuracy(&mut body, c);
    if let Some(found) = &c.first_divergence {
        add_first_divergence(&mut body, found);
    }
    let shots = c.error_target.is_none().then(|| {
        let [cpu, gpu] = [&c.cpu, &c.gpu].map(|run| format_count(run.shots.len() as u64));
        format!("{cpu} shots on the CPU, {gpu} on the GPU · ")
    });
    body.add_remark(format!(
        "{} · {} · {}{}",
        count_noun(c.mesh.faces.len(), "face", "faces"),
        count_noun(c.mesh.texels.len(), "texel", "texels"),
        shots.unwrap_or_default(),
        c.adapter
    ));
    body.add_notes(c.scene.notes.iter().chain(&c.notes));
    body.add_heading("Views").add_figures(&pictures.views);
    if pictures.are_alike {
        body.add_paragraph("The two solutions differ at most by rounding: there is no difference to draw.");
    }
    body.add_remark(&pictures.remark);
    body.add_heading("Criteria of the verdict")
        .add_paragraph(
            "Of the solutions: reflected radiosity B − E per texel, area-weighted; the worst channel counts. Of the \
             shaders: each and its counterpart in plain Rust get the same input; one ulp is a unit in the last place of a \
             32-bit float.",
        )
        .add_table(criteria_table(c));
    if c.error_target.is_some() {
        body.add_heading("Links: the GPU's against the CPU's").add_paragraph(
            "Both compute the same links, block by block: the irradiance over them, and stored links themselves. Where \
             rounding decides whether a node is subdivided or a ray passes an edge, the two may differ, and the \
             solutions then differ by at most the requested error.",
        );
        body.add_table(mismatch_table(c))
            .add_heading("Remaining error by cause")
            .add_paragraph("Refinement: the difference between the last two of successive solves. Squares add up.")
            .add_table(cause_table(c));
    } else if !pictures.item_buffer.is_empty() {
        body.add_heading("Visibility: item buffer against rays").add_paragraph(
            "The visibility of every pair of shooter and texel is computed by both. Where they differ, the texel's \
             projection must lie next to a boundary between two faces in the item buffer; a mismatch elsewhere is a bug, \
             and report.json names some such pairs.",
        );
        body.add_table(mismatch_table(c)).add_figures(&pictures.item_buffer);
    }
    body.add_heading("Energy balance");
    add_energy_balances(&mut body, &[("CPU", &c.cpu_energy), ("GPU", &c.gpu_energy)]);
    let title = pass_mark(c.solvers_agree()) + " " + file_name(&c.scene.name);
    let title = match c.preset {
        Preset::Requested => title,
        preset => title + ", " + preset.name(),
    };
    body.into_section(id, title)
}

/// Adds the verdict with the criteria that fail.
fn add_verdict(body: &mut Blocks, c: &Comparison) {
    let failed: Vec<&str> = (c.criteria.iter().filter(|criterion| !criterion.pass))
        .map(|criterion| criterion.name.as_str())
        .collect();
    let all = c.criteria.len();
    if c.solvers_agree() {
        body.add_verdict(VerdictTone::Good, "Agree", format!("all {all} criteria hold"));
    } else if all == 0 {
        body.add_verdict(VerdictTone::Bad, "Not compared", "there are no criteria");
    } else {
        let fail = format!("{} of {all} criteria fail: {}", failed.len(), failed.join(", "));
        body.add_verdict(VerdictTone::Bad, "Disagree", fail);
    }
}

/// Adds the errors of both solutions and the findings about the method.
fn add_accuracy(body: &mut Blocks, c: &Comparison) {
    let on_both = |start: String, errors: [Option<f64>; 2]| -> Text {
        let [cpu, gpu] = format_errors(errors);
        plain_text(start) + styled_text("cpu", cpu) + " on the CPU, " + styled_text("gpu", gpu) + " on the GPU"
    };
    if let Some(asked) = c.error_target {
        let asked = format_percent(asked.error);
        let start = format!("Requested error: at most {asked}. Estimated error: ");
        body.add_paragraph(on_both(start, [0, 1].map(|side| c.estimated_error(side))) + ".");
    }
    body.add_paragraph(match &c.truth {
        Some(truth) => {
            on_both("Error of the solutions: ".into(), c.truth_error)
                + format!(
                    " (relative RMS of reflected radiosity, against {}, itself off by less than {}).",
                    truth.name,
                    format_percent(truth.own_error)
                )
        }
        None => {
            plain_text("The error of the solutions is not known: the scene has too many faces for a reference ")
                + "solution in a few seconds. "
                + code_text("chart")
                + " computes one."
        }
    });
    body.add_notes(c.findings.iter().map(|finding| {
        let size = format_percent(finding.value);
        bold_text(format!("{}: {size}. ", finding.name)) + format!("{}.", finding.message)
    }));
}

fn criteria_table(c: &Comparison) -> Table {
    let rows = c.criteria.iter().map(|criterion| {
        let difference = criterion.difference.as_ref().map(|found| format!("; {found}"));
        let cells = [
            pass_mark(criterion.pass),
            plain_text(&criterion.name),
            plain_text(format_number(criterion.value)),
            plain_text(format_number(criterion.bound)),
            plain_text(format!("{}{}", criterion.reason, difference.unwrap_or_default())),
        ];
        Row::new(cells).with_class_if(!criterion.pass, "bad")
    });
    Table::new(";Criterion;#Measured;#At most;~Reason for the bound", rows)
}

/// Returns the numbers of pairs or blocks that differ. A row is a part of the nearest row above with fewer dashes, and
/// the explained and unexplained rows add up to the one above them.
fn mismatch_table(c: &Comparison) -> Table {
    let p = &c.pairs;
    let rows = match c.error_target {
        None => vec![
            ("Pairs of points facing each other", p.facing, p.pairs),
            ("– near a silhouette: pixels may be wrong", p.explainable, p.facing),
            ("– where rays and item buffer disagree", p.mismatched, p.facing),
            ("–– explained by an outline nearby", p.explained, p.mismatched),
            ("––– by one too thin to appear in the buffer", p.vanished, p.explained),
            (UNEXPLAINED_ROW, p.unexplained, p.mismatched),
        ],
        Some(_) => vec![
            ("Links in blocks of 16 texels or nodes", p.facing, p.facing),
            ("– that differ by more than rounding", p.mismatched, p.facing),
            ("–– within the share allowed for rounding", p.explained, p.mismatched),
            (UNEXPLAINED_ROW, p.unexplained, p.mismatched),
        ],
    };
    let rows = rows.into_iter().map(|(name, n, whole)| {
        let share = match whole {
            0 => "–".to_owned(),
            whole => format_percent(n as f64 / whole as f64),
        };
        Row::new([name.to_owned(), format_count(n), share]).with_class_if(name == UNEXPLAINED_ROW && n > 0, "bad")
    });
    Table::new(";#Count;#Share", rows)
}

/// Returns each solver's error estimate by cause.
fn cause_table(c: &Comparison) -> Table {
    let mut causes = Vec::new();
    for part in c.estimates.iter().flatten().flat_map(|estimate| &estimate.parts) {
        if !causes.contains(&part.cause) {
            causes.push(part.cause);
        }
    }
    let rows = causes.into_iter().map(|cause| {
        let errors = c.estimates.each_ref().map(|estimate| {
            let mut parts = estimate.iter().flat_map(|estimate| &estimate.parts);
            parts.find(|part| part.cause == cause).map(|part| part.error)
        });
        let [cpu, gpu] = format_errors(errors);
        Row::new([cause.name(), &cpu, &gpu, cause.describe_cause()])
    });
    let [cpu, gpu] = format_errors([0, 1].map(|side| c.estimated_error(side)));
    let total = Row::new(["all", &cpu, &gpu, ""]);
    Table::new("Cause;#CPU;#GPU;~Meaning", rows.chain([total]))
}
