//! Renders `diff.html`: figures, pictures and a table of faces of one difference.

use super::pictures::DiffPictures;
use crate::report::comparison::tables::energy_table;
use crate::report::format::{format_count, format_number, format_percent};
use crate::report::page::{Page, render_colour_bar, render_figure, render_notes, render_verdict};
use crate::report::table::{TableRow, number_cell, render_table, text_cell};
use crate::report::viewer;
use common::energy::EnergyBalance;
use common::solution::StoredSolution;
use maud::{Markup, html};
use oracle::diff::{Diff, FaceDiff};

/// Maximum number of faces in the table.
const MAX_LISTED_FACES: usize = 200;

/// Renders the page of two results; `tolerance` is the maximum relative RMS, if given.
pub fn render_page(
    [a, b]: [&StoredSolution; 2],
    diff: &Diff,
    pictures: &DiffPictures,
    tolerance: Option<f64>,
) -> String {
    let links = html! {
        a href="#top" { "Figures" }
        a href="#around" { "Look around" }
        a href="#views" { "Views" }
        a href="#textures" { "All textures" }
        a href="#faces" { "Face by face" }
    };
    let body = html! {
        p.facts {
            "A: " code { (a.dir.display()) } " · " (format_count(a.radiosity.len() as u64)) " texels" br;
            "B (the reference): " code { (b.dir.display()) } " · "
            (format_count(b.radiosity.len() as u64)) " texels · "
            (format_count(diff.faces.len() as u64)) " faces · compared on "
            (format_count(diff.pair.areas.len() as u64)) " texels"
        }
        (render_notes(&diff.notes))
        (render_figures(diff, pictures))
        (render_views(pictures))
        (render_textures(pictures))
        (face_table(diff))
        (viewer::page_assets())
    };
    Page {
        title: "Radiosity: two results compared",
        bar: ("Parts", links),
        verdict: tolerance_verdict(diff, tolerance),
        style: "",
        body,
    }
    .to_html()
}

/// Renders the page of a result against the radiosity gathered from its own light, which differs by `one_bounce`
/// after the first gathering.
pub fn render_check_page(
    result: &StoredSolution,
    (diff, one_bounce, energy): (&Diff, f64, &EnergyBalance),
    pictures: &DiffPictures,
    tolerance: Option<f64>,
) -> String {
    let links = html! {
        a href="#top" { "Figures" }
        a href="#energy" { "Energy" }
        a href="#around" { "Look around" }
        a href="#views" { "Views" }
        a href="#textures" { "All textures" }
        a href="#faces" { "Face by face" }
    };
    let body = html! {
        p.facts {
            "A, the result: " code { (result.dir.display()) } " · "
            (format_count(result.radiosity.len() as u64)) " texels · "
            (format_count(diff.faces.len() as u64)) " faces" br;
            "B: its own light gathered again at every texel, " code { "E + ρKB" } ", and the correction propagated "
            "until convergence"
        }
        p {
            "The first gathering differs by " b { (format_percent(one_bounce)) } ", with all later bounces by "
            b { (format_percent(diff.worst_rms())) } ". A result that solves the radiosity equation has difference 0; its own "
            "emission and reflectances are taken as exact."
        }
        (render_notes(&diff.notes))
        (render_figures(diff, pictures))
        section #energy {
            h2 { "Energy" }
            (energy_table(&[("", energy)]))
        }
        (render_views(pictures))
        (render_textures(pictures))
        (face_table(diff))
        (viewer::page_assets())
    };
    Page {
        title: "Radiosity: a result judged by its own light",
        bar: ("Parts", links),
        verdict: tolerance_verdict(diff, tolerance),
        style: "",
        body,
    }
    .to_html()
}

fn tolerance_verdict(diff: &Diff, tolerance: Option<f64>) -> Markup {
    let worst = format_percent(diff.worst_rms());
    let text = |sign: &str, most| html! { "relative RMS " (worst) " " (sign) " " (format_percent(most)) };
    match tolerance {
        Some(most) if diff.worst_rms() <= most => render_verdict(Some(true), "Within", text("≤", most)),
        Some(most) => render_verdict(Some(false), "Beyond", text(">", most)),
        None => render_verdict(None, &worst, html! { "relative RMS, the worst channel" }),
    }
}

fn render_figures(diff: &Diff, pictures: &DiffPictures) -> Markup {
    let per_channel = |name: &str, values: [f64; 3]| {
        let values = values.map(|x| number_cell(format_percent(x)));
        TableRow::new([text_cell(name)].into_iter().chain(values))
    };
    let overall = |name: &str, value: String| TableRow::new([text_cell(name), number_cell(value).with_column_span(3)]);
    let flip = pictures.flip.as_ref();
    let mut rows = vec![
        per_channel("Relative RMS", diff.relative_rms),
        per_channel("Bias", diff.bias),
    ];
    rows.extend(
        diff.standard_error
            .map(|error| per_channel("Standard error of the reference", error)),
    );
    rows.push(overall("Largest difference ÷ rms", format_percent(diff.max_relative)));
    rows.push(overall(
        "HDR-FLIP, mean over the view",
        flip.map_or("–".into(), |flip| format_number(flip.mean)),
    ));
    html! {
        p {
            "Reflected radiosity B − E, area-weighted, A against B. Where texels differ in number, both are "
            "averaged over common ones, by area and exactly."
        }
        (render_table("", &["", "#R", "#G", "#B"], rows))
    }
}

fn render_views(p: &DiffPictures) -> Markup {
    let white = format_number(f64::from(p.exposure.white));
    let eye = p.camera.eye.to_array().map(|x| format_number(f64::from(x))).join(", ");
    html! {
        section #around {
            h2 { "Look around" }
            @if !p.differ { (no_difference_note()) }
            (p.viewer)
        }
        section #views {
            h2 { "Views" }
            div.grid {
                @for ((name, what), source) in [("A", ""), ("B", ", the reference")].into_iter().zip(&p.views) {
                    (render_figure("", source, &format!("The scene as {name} has it"), html! {
                        b { (name) } (what) " · radiosity. White is " (white) " W/m²; emitters clip."
                    }))
                }
                @if p.differ {
                    (render_figure("", &p.difference, "Difference in false colours", html! {
                        b { "A − B" } " · luminance of reflected radiosity, relative to its rms in B ("
                        (format_number(p.rms)) " W/m²); clipped beyond the range." (render_colour_bar(p.range))
                    }))
                    @if let Some(flip) = &p.flip {
                        (render_figure("", &flip.picture.data_uri(), "HDR-FLIP error map", html! {
                            b { "HDR-FLIP" } " · the visible difference between the alternating views, maximum over "
                            "the exposures determined by B: black is none (0), pale yellow maximal (1). Mean "
                            (format_number(flip.mean)) ", largest " (format_number(flip.max)) "."
                        }))
                    }
                }
            }
            p.small {
                "All from one automatic camera (at " (eye) " in the mesh's unit; back faces are transparent). Both views "
                "share one exposure: the 90th percentile of B's reflected radiosity is at 80 % of white. "
                "Reflected radiosity is interpolated between texels."
            }
        }
    }
}

/// Renders the note that replaces an empty difference.
fn no_difference_note() -> Markup {
    html! { p { "No texel differs: there is no difference to draw." } }
}

fn render_textures(p: &DiffPictures) -> Markup {
    html! {
        section #textures {
            h2 { "All textures" }
            div.grid {
                @if p.differ { (render_figure("pixels", &p.atlas_difference, "Atlas of the difference", html! {
                    b { "A − B" } " · every common texel, all faces side by side in file order; colours as above."
                    (render_colour_bar(p.range))
                })) }
                @for (name, source) in ["A", "B"].into_iter().zip(&p.atlases) {
                    (render_figure("pixels", source, &format!("Atlas of {name}"), html! {
                        b { (name) } " · radiosity of every texel, as it is stored."
                    }))
                }
            }
        }
    }
}

fn face_table(diff: &Diff) -> Markup {
    let mut order: Vec<&FaceDiff> = diff.faces.iter().collect();
    order.sort_by(|x, y| y.share.total_cmp(&x.share));
    let area: f64 = diff.faces.iter().map(|f| f.area).sum();
    let row = |part: &FaceDiff| {
        TableRow::new([
            number_cell(part.face),
            text_cell(&part.name),
            number_cell(format_percent(part.share)),
            number_cell(format_percent(part.area / area)),
            number_cell(format_percent(part.relative_rms)),
            number_cell(format_percent(part.bias)),
        ])
    };
    let rows = order.iter().take(MAX_LISTED_FACES).map(|part| row(part));
    html! {
        section #faces {
            h2 { "Face by face" }
            p {
                "Sorted by the share of the squared error. RMS and bias are relative to the face's own reflected "
                "radiosity, maximum over channels."
            }
            (render_table("", &["#Face", "Name", "#Of the error", "#Of the area", "#Relative RMS", "#Bias"], rows))
            @if order.len() > MAX_LISTED_FACES {
                p.small { "The other " (format_count((order.len() - MAX_LISTED_FACES) as u64)) " faces are in diff.json." }
            }
        }
    }
}
