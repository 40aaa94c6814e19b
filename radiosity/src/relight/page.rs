//! Composes `report.html` of a relight: captured room, change by the objects, energy balance.

use super::RelitScene;
use super::composite::Composite;
use crate::report::document::{Blocks, Figure, Table, VerdictTone, bold_text, code_text, plain_text, render_document};
use crate::report::energy::add_energy_balances;
use crate::report::format::{count_noun, format_count};
use crate::report::viewer;
use common::energy::EnergyBalance;
use common::solution::Warning;
use maud::PreEscaped;

/// Content of a relight report.
pub struct RelightPage<'a> {
    /// Source of the room.
    pub room: &'a str,
    /// Sources of the objects.
    pub objects: &'a [String],
    /// Geometry and solution.
    pub relit: &'a RelitScene<'a>,
    /// Rendered pictures, linear.
    pub composite: &'a Composite,
    /// Figures.
    pub pictures: &'a [Figure],
    /// Energy balance; none where the method keeps none.
    pub energy: Option<&'a EnergyBalance>,
    /// Number of shots of the room.
    pub map_shots: u32,
    /// Number of shots of the objects.
    pub object_shots: u32,
    /// True if the solve reached its target.
    pub converged: bool,
    /// Number of texels with B below 0 in some channel.
    pub negative_texels: usize,
    /// Warnings about the solution.
    pub warnings: &'a [Warning],
    /// Notes.
    pub notes: &'a [String],
    /// Interactive viewer of the relit scene, an HTML element.
    pub viewer: &'a str,
}

/// Renders the page.
pub fn render_report(report: &RelightPage) -> String {
    let mut opening = Blocks::default();
    add_headline(&mut opening, report);
    add_sources(&mut opening, report);
    opening.add_notes(report.notes).add_figures(report.pictures).add_remark(
        plain_text(
            "Without an option the exposure shows the 90th percentile of both pictures, lights excluded, at 80 % \
                        of white; back faces are transparent. Both pictures are in ",
        ) + code_text("composite.exr")
            + " and "
            + code_text("background.exr")
            + " as radiance (W/m²/sr), not clipped.",
    );
    if report.relit.mesh.faces.len() <= report.relit.room {
        opening.add_paragraph("There is no object: the composite is the background, bit for bit.");
    }
    let mut around = Blocks::default();
    around.add_element(PreEscaped(report.viewer.to_owned()));
    let mut figures = Blocks::default();
    add_tables(&mut figures, report);
    figures.add_element(viewer::page_assets());
    let sections = [
        around.into_section("around", "Look around"),
        figures.into_section("figures", "Figures"),
    ];
    render_document("Radiosity: a relit room", &opening, &sections, "")
}

/// Adds the verdict, warnings and counts of negative values.
fn add_headline(opening: &mut Blocks, report: &RelightPage) {
    let (texels, pixels) = (report.negative_texels, report.composite.negative);
    match (report.converged, texels + pixels + report.warnings.len()) {
        (false, _) => opening.add_verdict(VerdictTone::Careful, "Stopped", "before ε was reached"),
        (true, 0) => {
            let says = "to the requested tolerance; no value is negative";
            opening.add_verdict(VerdictTone::Good, "Relit", says)
        }
        (true, _) => opening.add_verdict(
            VerdictTone::Careful,
            "Relit",
            "to the requested tolerance, with warnings",
        ),
    };
    let mut warnings: Vec<String> = report.warnings.iter().map(|warning| warning.message.clone()).collect();
    if texels > 0 {
        let what = count_noun(texels, "texel is", "texels are");
        warnings.push(format!(
            "{what} below 0: the objects remove more light there than was captured."
        ));
    }
    if pixels > 0 {
        let what = count_noun(pixels, "pixel", "pixels");
        warnings.push(format!(
            "{what} of the composite would be below 0 and are shown black: the background is darker there than the \
             room's model, and the shadow exceeds it."
        ));
    }
    for warning in warnings {
        opening.add_warning(bold_text("Warning: ") + warning);
    }
}

/// Adds files and sizes of room and objects.
fn add_sources(opening: &mut Blocks, report: &RelightPage) {
    let (mesh, room) = (report.relit.mesh, report.relit.room);
    let of_room = mesh.texels.iter().filter(|t| !report.relit.is_object(t.face)).count();
    let size = |faces: usize, texels: usize| {
        let (faces, texels) = (
            count_noun(faces, "face", "faces"),
            count_noun(texels, "texel", "texels"),
        );
        format!(" · {faces}, {texels}")
    };
    let objects = report.objects.iter().map(|object| code_text(object) + " ");
    let objects = objects.reduce(|all, object| all + object).unwrap_or(plain_text("none"));
    opening.add_remark(plain_text("Room: ") + code_text(report.room) + size(room, of_room));
    let rest = size(mesh.faces.len().saturating_sub(room), mesh.texels.len() - of_room);
    opening.add_remark(plain_text("Objects: ") + objects + rest);
}

/// Adds counts and energy balance.
fn add_tables(body: &mut Blocks, report: &RelightPage) {
    let counts = [
        ("Shots of the room", u64::from(report.map_shots)),
        ("Shots of the objects", u64::from(report.object_shots)),
        ("Texels below 0", report.negative_texels as u64),
        ("Pixels of the composite below 0", report.composite.negative as u64),
    ];
    body.add_table(Table::of_values(counts.map(|(name, n)| (name, format_count(n)))));
    if let Some(energy) = report.energy {
        body.add_heading("Energy balance")
            .add_paragraph("Of the total B, including the captured room's own lights.");
        add_energy_balances(body, &[("", energy)]);
    }
}
