//! Composes `diff.html` and `check.html`: figures, pictures and a table of faces of one difference.

use super::pictures::DiffPictures;
use crate::report::document::{
    Blocks, Cell, Row, Table, VerdictTone, bold_text, code_text, plain_text, render_document,
};
use crate::report::energy::add_energy_balances;
use crate::report::format::{count_noun, format_count, format_number, format_percent};
use crate::report::viewer;
use common::solution::StoredSolution;
use oracle::diff::{Diff, FaceDiff};
use oracle::solve::residual::JudgedResult;

/// Maximum number of faces in the table.
const MAX_LISTED_FACES: usize = 200;

/// Renders the page of result A against B: another result, or, where `check` is given, the radiosity gathered from A's
/// own light. `tolerance` is the maximum relative RMS.
pub fn render_page(
    [a, b]: [&StoredSolution; 2],
    (diff, pictures): (&Diff, DiffPictures),
    check: Option<&JudgedResult>,
    tolerance: Option<f64>,
) -> String {
    let mut opening = Blocks::default();
    let error = check.map_or(diff.worst_rms(), JudgedResult::error);
    add_verdict(&mut opening, error, tolerance);
    let source = |stored: &StoredSolution| {
        let texels = count_noun(stored.radiosity.len(), "texel", "texels");
        code_text(stored.dir.display()) + format!(" · {texels}")
    };
    opening.add_remark(plain_text("A: ") + source(a));
    match check {
        None => opening.add_remark(plain_text("B (the reference): ") + source(b)),
        Some(judged) => opening
            .add_remark(
                plain_text("B: A's own light gathered again at every texel, ")
                    + code_text("E + ρKB")
                    + ", and the correction propagated until convergence",
            )
            .add_paragraph(
                plain_text("The first gathering differs by ")
                    + bold_text(format_percent(judged.one_bounce))
                    + ", with all later bounces by "
                    + bold_text(format_percent(error))
                    + ". A result that solves the radiosity equation has difference 0; its own emission and \
                       reflectances are taken as exact.",
            ),
    };
    opening
        .add_remark(format!(
            "{} · compared on {}",
            count_noun(diff.faces.len(), "face", "faces"),
            count_noun(diff.pair.areas.len(), "texel", "texels")
        ))
        .add_notes(&diff.notes)
        .add_paragraph(
            "Reflected radiosity B − E, area-weighted, A against B. Where texels differ in number, both are averaged \
             over common ones, by area and exactly.",
        )
        .add_table(difference_table(diff, pictures.flip));
    let mut sections = Vec::new();
    if let Some(judged) = check {
        let mut body = Blocks::default();
        add_energy_balances(&mut body, &[("", &judged.energy)]);
        sections.push(body.into_section("energy", "Energy"));
    }
    let mut views = Blocks::default();
    if !pictures.differ {
        views.add_paragraph("No texel differs: there is no difference to draw.");
    }
    views
        .add_element(pictures.viewer)
        .add_figures(&pictures.views)
        .add_remark(pictures.remark);
    sections.push(views.into_section("views", "Views"));
    let mut faces = Blocks::default();
    add_faces(&mut faces, diff);
    faces.add_element(viewer::page_assets());
    sections.push(faces.into_section("faces", "Face by face"));
    let title = match check {
        None => "Radiosity: two results compared",
        Some(_) => "Radiosity: a result judged by its own light",
    };
    render_document(title, &opening, &sections, "")
}

fn add_verdict(opening: &mut Blocks, error: f64, tolerance: Option<f64>) {
    let worst = format_percent(error);
    let text = |sign: &str, most| format!("relative RMS {worst} {sign} {}", format_percent(most));
    match tolerance {
        Some(most) if error <= most => opening.add_verdict(VerdictTone::Good, "Within", text("≤", most)),
        Some(most) => opening.add_verdict(VerdictTone::Bad, "Beyond", text(">", most)),
        None => opening.add_verdict(VerdictTone::Neutral, &worst, "relative RMS, the worst channel"),
    };
}

fn difference_table(diff: &Diff, flip: Option<f64>) -> Table {
    let per_channel = |name: &str, values: [f64; 3]| {
        let values = values.map(format_percent);
        Row::new([name.to_owned()].into_iter().chain(values))
    };
    let overall = |name: &str, value: String| {
        let value = Cell {
            columns: 3,
            class: "n",
            ..value.into()
        };
        Row::new([name.into(), value])
    };
    let standard_error = diff.standard_error;
    let standard_error = standard_error.map(|error| per_channel("Standard error of the reference", error));
    let rows = [
        per_channel("Relative RMS", diff.relative_rms),
        per_channel("Bias", diff.bias),
    ];
    let rows = rows.into_iter().chain(standard_error).chain([
        overall("Largest difference ÷ rms", format_percent(diff.max_relative)),
        overall("HDR-FLIP, mean over the view", flip.map_or("–".into(), format_number)),
    ]);
    Table::new(";#R;#G;#B", rows)
}

fn add_faces(body: &mut Blocks, diff: &Diff) {
    let mut order: Vec<&FaceDiff> = diff.faces.iter().collect();
    order.sort_by(|x, y| y.share.total_cmp(&x.share));
    let area: f64 = diff.faces.iter().map(|f| f.area).sum();
    let rows = order.iter().take(MAX_LISTED_FACES).map(|part| {
        let shares = [part.share, part.area / area, part.relative_rms, part.bias].map(format_percent);
        Row::new([part.face.to_string(), part.name.clone()].into_iter().chain(shares))
    });
    body.add_paragraph(
        "Sorted by the share of the squared error. RMS and bias are relative to the face's own reflected radiosity, \
         maximum over channels.",
    );
    let heads = "#Face;Name;#Of the error;#Of the area;#Relative RMS;#Bias";
    body.add_table(Table::new(heads, rows));
    if order.len() > MAX_LISTED_FACES {
        let others = format_count((order.len() - MAX_LISTED_FACES) as u64);
        body.add_remark(format!("The other {others} faces are in diff.json."));
    }
}
