//! Composes `report.html` of a relight: captured room, change by the objects, energy balance.

use super::RelitScene;
use super::composite::Composite;
use super::pictures::RelightPictures;
use crate::report::document::{
    Blocks, Document, Figure, Table, Text, VerdictTone, bold_text, code_text, plain_text, stacked_bar,
};
use crate::report::energy::add_energy_balances;
use crate::report::format::{count_noun, format_count, format_duration, format_number};
use crate::report::view::camera::Camera;
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
    /// Solver and options: name, value.
    pub settings: &'a [(String, String)],
    /// Geometry and solution.
    pub relit: &'a RelitScene<'a>,
    /// Rendered pictures, linear.
    pub composite: &'a Composite,
    /// Figures.
    pub pictures: &'a RelightPictures,
    /// Camera in mesh coordinates.
    pub camera: Camera,
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
    /// Wall-clock seconds of each phase.
    pub seconds: &'a [(&'a str, f64)],
    /// Warnings about the solution.
    pub warnings: &'a [Warning],
    /// Notes.
    pub notes: &'a [String],
    /// Marked panorama, if there is one.
    pub panorama: Option<Figure>,
    /// Interactive viewer of the relit scene, an HTML element.
    pub viewer: &'a str,
}

/// Renders the page.
pub fn render_report(report: &RelightPage) -> String {
    let pictures = report.pictures;
    let mut opening = Blocks::default();
    add_headline(&mut opening, report);
    add_sources(&mut opening, report);
    opening
        .add_notes(report.notes)
        .add_figures(&pictures.views)
        .add_remark(describe_camera(report))
        .add_figures(&pictures.objects);
    let mut around = Blocks::default();
    around.add_element(PreEscaped(report.viewer.to_owned()));
    let mut change = Blocks::default();
    change.add_figures(&pictures.change);
    if report.relit.mesh.faces.len() <= report.relit.room {
        change.add_paragraph("There is no object: the composite is the background, bit for bit.");
    }
    let mut sections = vec![
        around.into_section("around", "Look around"),
        change.into_section("change", "Change of the room by the objects"),
    ];
    if let Some(panorama) = &report.panorama {
        let mut body = Blocks::default();
        body.add_figure(panorama);
        sections.push(body.into_section("panorama", "The panorama and the room"));
    }
    let mut textures = Blocks::default();
    textures.add_figures(&pictures.atlases);
    sections.push(textures.into_section("textures", "All textures"));
    let mut figures = Blocks::default();
    add_tables(&mut figures, report);
    figures.add_element(viewer::page_assets());
    sections.push(figures.into_section("figures", "Figures"));
    let page = Document {
        title: "Radiosity: a relit room",
        opening,
        sections,
        style: "",
    };
    page.to_html()
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

fn describe_camera(report: &RelightPage) -> Text {
    let mesh = report.relit.mesh;
    let eye = (report.camera.eye.as_dvec3() * mesh.unit + mesh.origin).to_array();
    plain_text(format!(
        "Camera at ({}) in the scene's unit, vertical field of view {}°; back faces are transparent. Without an option \
         the exposure shows the 90th percentile of both pictures, lights excluded, at 80 % of white; the curve is {}. \
         Both pictures are in ",
        eye.map(format_number).join(", "),
        format_number(f64::from(report.camera.fov_degrees)),
        report.pictures.exposure.curve.name()
    )) + code_text("composite.exr")
        + " and "
        + code_text("background.exr")
        + " as radiance (W/m²/sr), not clipped."
}

/// Adds counts, energy balance, times and settings.
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
    let total: f64 = report.seconds.iter().map(|(_, s)| s).sum();
    let times = report.seconds.iter().map(|(name, s)| {
        let share = if total > 0.0 { s / total } else { 0.0 };
        let bar = [
            ("#3d6f9e", share, format_duration(*s)),
            ("transparent", 1.0 - share, String::new()),
        ];
        (format!("{name}: {}", format_duration(*s)), stacked_bar(bar))
    });
    body.add_heading("Time").add_table(Table::of_values(times));
    body.add_heading("Settings in force");
    body.add_table(Table::of_values(
        report.settings.iter().map(|(name, value)| (name, value)),
    ));
}
