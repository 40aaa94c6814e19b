//! `report.html` of one relight: what was captured, what the objects changed, where the light
//! went; one file that opens offline.

mod tables;

use crate::relight::Relit;
use crate::relight::composite::Composite;
use crate::relight::pictures::Pictures;
use crate::relight::thumbnail::{Thumbnail, marked};
use crate::show::number::{count, number, percent};
use crate::show::page::{Page, caution, colour_bar, figure, notes, verdict};
use crate::show::report::tables::energy as power;
use crate::show::view::camera::Camera;
use crate::show::viewer;
use common::energy::Energy;
use common::solution::Warning;
use maud::{Markup, PreEscaped, html};

/// Everything that the page tells.
pub struct Report<'a> {
    /// What the room was read from.
    pub room: &'a str,
    /// What the objects were read from.
    pub objects: &'a [String],
    /// How it was relit, by whom, and with which other options: name, value.
    pub settings: &'a [(String, String)],
    /// Geometry and light.
    pub relit: &'a Relit<'a>,
    /// What the camera saw.
    pub composite: &'a Composite,
    /// Its pictures.
    pub pictures: &'a Pictures,
    /// The camera, in the mesh's coordinates.
    pub camera: Camera,
    /// Where the power went; none where the method keeps no balance.
    pub energy: Option<&'a Energy>,
    /// Shots of the room.
    pub map_shots: u32,
    /// Shots of the objects.
    pub object_shots: u32,
    /// Whether it was shot down to ε.
    pub converged: bool,
    /// Texels whose B is below 0 in some channel.
    pub negative_texels: usize,
    /// Wall-clock seconds of each phase.
    pub seconds: &'a [(&'a str, f64)],
    /// What may be wrong with the answer.
    pub warnings: &'a [Warning],
    /// Everything else worth saying.
    pub notes: &'a [String],
    /// The panorama, if there is one (see [`super::thumbnail::thumbnail`]).
    pub thumbnail: Option<Thumbnail>,
    /// The relit scene to look around in: an element, as text.
    pub around: &'a str,
}

/// The page.
pub fn html(report: &Report) -> String {
    let pictures = report.pictures;
    let links = html! {
        a href="#top" { "Composite" }
        a href="#around" { "Look around" }
        a href="#change" { "What the object changed" }
        @if report.thumbnail.is_some() { a href="#panorama" { "Panorama" } }
        a href="#textures" { "All textures" }
        a href="#figures" { "Figures" }
    };
    let body = html! {
        (facts(report))
        (notes(report.notes))
        (views(report, pictures))
        section #around {
            h2 { "Look around" }
            (PreEscaped(report.around))
        }
        (change(report, pictures))
        @if let Some(map) = &report.thumbnail { (panorama(report, map, pictures)) }
        (textures(report, pictures))
        section #figures {
            h2 { "Figures" }
            (tables::shots(report))
            @if let Some(energy) = report.energy {
                h3 { "Where the power went" }
                p { "Of the whole of B, the captured room's own lights included." }
                (power(&[("", energy)]))
            }
            (tables::seconds(report.seconds))
            (tables::settings(report.settings))
        }
        (viewer::once())
    };
    Page {
        title: "Radiosity: a relit room",
        bar: ("Parts", links),
        verdict: headline(report),
        style: "",
        body,
    }
    .html()
}

/// The verdict, and beside it whatever takes away from it.
fn headline(report: &Report) -> Markup {
    let (texels, pixels) = (report.negative_texels, report.composite.negative);
    let said = match (report.converged, texels + pixels + report.warnings.len()) {
        (false, _) => caution("Stopped", html! { "before ε was reached" }),
        (true, 0) => verdict(
            Some(true),
            "Relit",
            html! { "down to what was asked for; nothing is below 0" },
        ),
        (true, _) => caution("Relit", html! { "down to what was asked for, but" }),
    };
    let below = |n: usize, one: &str, many: &str| {
        format!(
            "{} {} below 0",
            count(n as u64),
            if n == 1 { one } else { many }
        )
    };
    let confessed = [
        (texels > 0).then(|| {
            let what = below(texels, "texel is", "texels are");
            format!("{what}: there the objects take more light than was captured.")
        }),
        (pixels > 0).then(|| {
            let what = below(pixels, "pixel of the composite would be", "pixels of the composite would be");
            format!(
                "{what} and are shown black: there the background is darker than the room's model, and the shadow takes more than is there."
            )
        }),
    ];
    html! {
        (said)
        @for message in report.warnings.iter().map(|w| &w.message).chain(confessed.iter().flatten()) {
            p.warning { b { "Warning: " } (message) }
        }
    }
}

fn facts(report: &Report) -> Markup {
    let (mesh, room) = (report.relit.mesh, report.relit.room);
    let of_room = mesh
        .texels
        .iter()
        .filter(|t| !report.relit.is_object(t.face));
    let of_room = of_room.count();
    html! {
        p.facts {
            "Room: " code { (report.room) } " · " (count(room as u64)) " faces, "
            (count(of_room as u64)) " texels" br;
            "Objects: "
            @if report.objects.is_empty() { "none" }
            @for (k, object) in report.objects.iter().enumerate() {
                @if k > 0 { ", " } code { (object) }
            }
            " · " (count(mesh.faces.len().saturating_sub(room) as u64)) " faces, "
            (count((mesh.texels.len() - of_room) as u64)) " texels"
        }
    }
}

fn views(report: &Report, p: &Pictures) -> Markup {
    let white = number(f64::from(p.exposure.white));
    let c = report.composite;
    let origin = report.relit.mesh.origin;
    let eye = (report.camera.eye.as_dvec3() * report.relit.mesh.unit + origin).to_array();
    let covered: f64 = c.mask.iter().map(|share| f64::from(*share)).sum();
    html! {
        div.grid {
            (figure("", &p.views[1], "The room with the object", html! {
                b { "Composite" } " · the background, times what the object changes of the room's light, and "
                "the object itself. White is " (white) " W/m²/sr."
            }))
            (figure("", &p.views[0], "The room as it was captured", html! {
                b { "Background" } " · as it was captured, at the same exposure."
            }))
        }
        p.small {
            "Camera at (" (eye.map(number).join(", ")) ") in the scene's unit, vertical field of view "
            (number(f64::from(report.camera.fov_degrees))) "°; backs are looked through. Unless "
            "it was moved, the exposure brings the 90th percentile of what both pictures show, lights left out, to "
            "80 % of white; the curve is " (p.exposure.curve.name()) ". Both pictures are in "
            code { "composite.exr" } " and " code { "background.exr" } " as radiance (W/m²/sr), not clipped."
        }
        div.grid {
            (figure("", &p.objects[0], "The object alone", html! {
                b { "The object alone" } " · lit by the room and by what it sends there and back."
            }))
            (figure("", &p.objects[1], "The object's coverage", html! {
                b { "Its mask" } " · white where a pixel shows nothing else; "
                (percent(covered / c.mask.len().max(1) as f64)) " of the picture."
            }))
        }
    }
}

fn change(report: &Report, p: &Pictures) -> Markup {
    html! {
        section #change {
            h2 { "What the object changed in the room" }
            div.grid {
                (figure("", &p.change, "Change of the room in false colours", html! {
                    b { "B − B₀" } " · blue is darker, red lighter: luminance relative to the background's rms ("
                    (number(p.rms)) " W/m²/sr), clipped beyond the range; grey is the object."
                    (colour_bar(p.range))
                }))
                (figure("", &p.shadows, "Shadows", html! {
                    b { "Shadows" } " · the share of the background's light that is left where the object takes "
                    "some: white all, black none."
                }))
            }
            @if report.relit.mesh.faces.len() <= report.relit.room {
                p { "There is no object: the composite is the background, bit for bit." }
            }
        }
    }
}

fn panorama(report: &Report, map: &Thumbnail, p: &Pictures) -> Markup {
    html! {
        section #panorama {
            h2 { "The panorama and the room" }
            figure { (marked(report.relit, map, p.exposure)) figcaption {
                "The centre of the map looks towards " b { "+z" } ", " b { "+x" } " is to the left, " b { "y" }
                " is up (shown in latitude and longitude, whatever the map's own layout; +y and −y are the whole "
                "upper and lower rim, −z the left and the right one). The lines are the edges of the room as its "
                "size and the eye put them: where they leave the photograph's corners, one of the two is wrong."
            } }
        }
    }
}

fn textures(report: &Report, p: &Pictures) -> Markup {
    let (lights, found) = &p.lights;
    html! {
        section #textures {
            h2 { "All textures" }
            div.grid {
                (figure("pixels", &p.atlases[0], "Atlas before", html! {
                    b { "B₀" } " · captured radiosity of every texel, faces side by side in file order; objects, "
                    "black here, come last."
                }))
                (figure("pixels", &p.atlases[1], "Atlas after", html! {
                    b { "B" } " · with the object, at the same exposure: white is "
                    (number(std::f64::consts::PI * f64::from(p.exposure.white))) " W/m²."
                }))
                (figure("pixels", lights, "Lights found", html! {
                    b { "Lights" } " · orange: texels at least half of whose radiosity is their own emission; "
                    (count(*found as u64)) " of " (count(report.relit.mesh.texels.len() as u64)) "."
                }))
                (figure("pixels", &p.reflectance, "Atlas of the reflectance", html! {
                    b { "ρ" } " · reflectance of every texel, as found or as given; white is 1."
                }))
            }
        }
    }
}
