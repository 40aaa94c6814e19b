//! Renders `report.html` of a relight: captured room, change by the objects, energy balance.

use crate::relight::RelitScene;
use crate::relight::composite::Composite;
use crate::relight::pictures::RelightPictures;
use crate::relight::thumbnail::{Thumbnail, render_marked_map};
use crate::report::comparison::tables::energy_table;
use crate::report::format::{format_count, format_duration, format_number, format_percent};
use crate::report::page::{Page, render_caution, render_colour_bar, render_figure, render_notes, render_verdict};
use crate::report::table::{TableRow, render_name_value_table, render_table, text_cell};
use crate::report::view::camera::Camera;
use crate::report::viewer;
use common::energy::EnergyBalance;
use common::solution::Warning;
use maud::{Markup, PreEscaped, html};

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
    /// Rendered pictures, encoded.
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
    /// Panorama, if there is one (see [`super::thumbnail::render_thumbnail`]).
    pub thumbnail: Option<Thumbnail>,
    /// Interactive viewer of the relit scene, an HTML element.
    pub viewer: &'a str,
}

/// Renders the page.
pub fn render_report(report: &RelightPage) -> String {
    let pictures = report.pictures;
    let links = html! {
        a href="#top" { "Composite" }
        a href="#around" { "Look around" }
        a href="#change" { "Change by the objects" }
        @if report.thumbnail.is_some() { a href="#panorama" { "Panorama" } }
        a href="#textures" { "All textures" }
        a href="#figures" { "Figures" }
    };
    let body = html! {
        (render_facts(report))
        (render_notes(report.notes))
        (render_views(report, pictures))
        section #around {
            h2 { "Look around" }
            (PreEscaped(report.viewer))
        }
        (render_change(report, pictures))
        @if let Some(map) = &report.thumbnail { (render_panorama(report, map, pictures)) }
        (render_textures(report, pictures))
        section #figures {
            h2 { "Figures" }
            (shot_table(report))
            @if let Some(energy) = report.energy {
                h3 { "Energy balance" }
                p { "Of the total B, including the captured room's own lights." }
                (energy_table(&[("", energy)]))
            }
            (time_bars(report.seconds))
            (settings_table(report.settings))
        }
        (viewer::page_assets())
    };
    Page {
        title: "Radiosity: a relit room",
        bar: ("Parts", links),
        verdict: render_headline(report),
        style: "",
        body,
    }
    .to_html()
}

/// Renders the verdict, warnings and counts of negative values.
fn render_headline(report: &RelightPage) -> Markup {
    let (texels, pixels) = (report.negative_texels, report.composite.negative);
    let verdict = match (report.converged, texels + pixels + report.warnings.len()) {
        (false, _) => render_caution("Stopped", html! { "before ε was reached" }),
        (true, 0) => render_verdict(
            Some(true),
            "Relit",
            html! { "to the requested tolerance; no value is negative" },
        ),
        (true, _) => render_caution("Relit", html! { "to the requested tolerance, with warnings" }),
    };
    let below = |n: usize, one: &str, many: &str| {
        format!("{} {} below 0", format_count(n as u64), if n == 1 { one } else { many })
    };
    let negative_counts = [
        (texels > 0).then(|| {
            let what = below(texels, "texel is", "texels are");
            format!("{what}: the objects remove more light there than was captured.")
        }),
        (pixels > 0).then(|| {
            let what = below(pixels, "pixel of the composite would be", "pixels of the composite would be");
            format!(
                "{what} and are shown black: the background is darker there than the room's model, and the shadow exceeds it."
            )
        }),
    ];
    html! {
        (verdict)
        @for message in report.warnings.iter().map(|w| &w.message).chain(negative_counts.iter().flatten()) {
            p.warning { b { "Warning: " } (message) }
        }
    }
}

fn render_facts(report: &RelightPage) -> Markup {
    let (mesh, room) = (report.relit.mesh, report.relit.room);
    let of_room = mesh.texels.iter().filter(|t| !report.relit.is_object(t.face));
    let of_room = of_room.count();
    html! {
        p.facts {
            "Room: " code { (report.room) } " · " (format_count(room as u64)) " faces, "
            (format_count(of_room as u64)) " texels" br;
            "Objects: "
            @if report.objects.is_empty() { "none" }
            @for (k, object) in report.objects.iter().enumerate() {
                @if k > 0 { ", " } code { (object) }
            }
            " · " (format_count(mesh.faces.len().saturating_sub(room) as u64)) " faces, "
            (format_count((mesh.texels.len() - of_room) as u64)) " texels"
        }
    }
}

fn render_views(report: &RelightPage, p: &RelightPictures) -> Markup {
    let white = format_number(f64::from(p.exposure.white));
    let c = report.composite;
    let origin = report.relit.mesh.origin;
    let eye = (report.camera.eye.as_dvec3() * report.relit.mesh.unit + origin).to_array();
    let covered: f64 = c.mask.iter().map(|share| f64::from(*share)).sum();
    html! {
        div.grid {
            (render_figure("", &p.views[1], "The room with the object", html! {
                b { "Composite" } " · the background with the room's light changed by the objects, and the objects "
                "themselves. White is " (white) " W/m²/sr."
            }))
            (render_figure("", &p.views[0], "The room as it was captured", html! {
                b { "Background" } " · as captured, at the same exposure."
            }))
        }
        p.small {
            "Camera at (" (eye.map(format_number).join(", ")) ") in the scene's unit, vertical field of view "
            (format_number(f64::from(report.camera.fov_degrees))) "°; back faces are transparent. Without an option the "
            "exposure shows the 90th percentile of both pictures, lights excluded, at 80 % of white; the curve is " (p.exposure.curve.name()) ". Both pictures are in "
            code { "composite.exr" } " and " code { "background.exr" } " as radiance (W/m²/sr), not clipped."
        }
        div.grid {
            (render_figure("", &p.objects[0], "The object alone", html! {
                b { "The object alone" } " · lit by the room, interreflection included."
            }))
            (render_figure("", &p.objects[1], "The object's coverage", html! {
                b { "Its mask" } " · white where a pixel shows only the object; "
                (format_percent(covered / c.mask.len().max(1) as f64)) " of the picture."
            }))
        }
    }
}

fn render_change(report: &RelightPage, p: &RelightPictures) -> Markup {
    html! {
        section #change {
            h2 { "Change of the room by the objects" }
            div.grid {
                (render_figure("", &p.change, "Change of the room in false colours", html! {
                    b { "B − B₀" } " · blue is darker, red lighter: luminance relative to the background's rms ("
                    (format_number(p.rms)) " W/m²/sr), clipped beyond the range; grey is the object."
                    (render_colour_bar(p.range))
                }))
                (render_figure("", &p.shadows, "Shadows", html! {
                    b { "Shadows" } " · the remaining share of the background's light where the objects reduce it: "
                    "white is 1, black is 0."
                }))
            }
            @if report.relit.mesh.faces.len() <= report.relit.room {
                p { "There is no object: the composite is the background, bit for bit." }
            }
        }
    }
}

fn render_panorama(report: &RelightPage, map: &Thumbnail, p: &RelightPictures) -> Markup {
    html! {
        section #panorama {
            h2 { "The panorama and the room" }
            figure { (render_marked_map(report.relit, map, p.exposure)) figcaption {
                "The map's centre is " b { "+z" } ", " b { "+x" } " is to the left, " b { "y" }
                " is up (latitude and longitude, whatever the map's own layout; +y and −y are the whole upper and "
                "lower rim, −z the left and right rims). The lines are the room's edges projected from the eye: where "
                "they deviate from the photograph's corners, the room's size or the eye is wrong."
            } }
        }
    }
}

fn render_textures(report: &RelightPage, p: &RelightPictures) -> Markup {
    let (lights, light_count) = &p.lights;
    html! {
        section #textures {
            h2 { "All textures" }
            div.grid {
                (render_figure("pixels", &p.atlases[0], "Atlas before", html! {
                    b { "B₀" } " · captured radiosity of every texel, faces side by side in file order; objects, "
                    "black here, come last."
                }))
                (render_figure("pixels", &p.atlases[1], "Atlas after", html! {
                    b { "B" } " · with the object, at the same exposure: white is "
                    (format_number(std::f64::consts::PI * f64::from(p.exposure.white))) " W/m²."
                }))
                (render_figure("pixels", lights, "Lights", html! {
                    b { "Lights" } " · orange: texels at least half of whose radiosity is their own emission; "
                    (format_count(*light_count as u64)) " of " (format_count(report.relit.mesh.texels.len() as u64)) "."
                }))
                (render_figure("pixels", &p.reflectance, "Atlas of the reflectance", html! {
                    b { "ρ" } " · reflectance of every texel, estimated or given; white is 1."
                }))
            }
        }
    }
}

/// Renders the numbers of shots and of negative values.
fn shot_table(report: &RelightPage) -> Markup {
    let rows = [
        ("Shots of the room", u64::from(report.map_shots)),
        ("Shots of the objects", u64::from(report.object_shots)),
        ("Texels below 0", report.negative_texels as u64),
        ("Pixels of the composite below 0", report.composite.negative as u64),
    ];
    render_name_value_table(rows.map(|(name, n)| (name, format_count(n))))
}

/// Renders the wall-clock time of each phase with bars.
fn time_bars(phases: &[(&str, f64)]) -> Markup {
    let total: f64 = phases.iter().map(|(_, s)| s).sum();
    let share = |s: f64| {
        if total > 0.0 { (s / total).max(0.0) } else { 0.0 }
    };
    html! {
        @if !phases.is_empty() {
            h3 { "Time" }
            @for (name, s) in phases {
                div.energy {
                    span.phase { (name) }
                    div.bar {
                        span.absorbed style=(format!("flex-grow:{:.5}", share(*s))) {}
                        span style=(format!("flex-grow:{:.5}", 1.0 - share(*s))) {}
                    }
                    span.seconds { (format_duration(*s)) }
                }
            }
        }
    }
}

/// Renders the options in force.
fn settings_table(settings: &[(String, String)]) -> Markup {
    html! {
        @if !settings.is_empty() {
            h3 { "Settings in force" }
            (render_table("", &[], settings.iter().map(|(name, value)| TableRow::new([text_cell(name), text_cell(value)]))))
        }
    }
}
