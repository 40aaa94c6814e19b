//! `diff.html`: figures, pictures and faces of one difference, in one file that opens offline.

use super::pictures::Pictures;
use super::{Diff, FaceDiff};
use crate::show::number::{count, number, percent};
use crate::show::page::{Page, colour_bar, figure, notes, table, verdict};
use crate::show::report::tables::energy as power;
use crate::show::viewer;
use common::energy::Energy;
use common::solution::Stored;
use maud::{Markup, html};

/// Faces that the table lists.
const LISTED: usize = 200;

/// The page; `tolerance` is what the worst relative RMS may be, if it was said.
pub fn html(
    [a, b]: [&Stored; 2],
    diff: &Diff,
    pictures: &Pictures,
    tolerance: Option<f64>,
) -> String {
    let links = html! {
        a href="#top" { "Figures" }
        a href="#around" { "Look around" }
        a href="#views" { "What they see" }
        a href="#textures" { "All textures" }
        a href="#faces" { "Face by face" }
    };
    let body = html! {
        p.facts {
            "A: " code { (a.dir.display()) } " · " (count(a.radiosity.len() as u64)) " texels" br;
            "B (the truth): " code { (b.dir.display()) } " · "
            (count(b.radiosity.len() as u64)) " texels · "
            (count(diff.faces.len() as u64)) " faces · compared on "
            (count(diff.pair.areas.len() as u64)) " texels"
        }
        (notes(&diff.notes))
        (figures(diff, pictures))
        (views(pictures))
        (textures(pictures))
        (faces(diff))
        (viewer::once())
    };
    Page {
        title: "Radiosity: two results compared",
        bar: ("Parts", links),
        verdict: held(diff, tolerance),
        style: "",
        body,
    }
    .html()
}

/// The page of a result against what follows from its own light, of which the first gathering differs by
/// `one_bounce`.
pub fn checked(
    result: &Stored,
    (diff, one_bounce, energy): (&Diff, f64, &Energy),
    pictures: &Pictures,
    tolerance: Option<f64>,
) -> String {
    let links = html! {
        a href="#top" { "Figures" }
        a href="#energy" { "Energy" }
        a href="#around" { "Look around" }
        a href="#views" { "What they see" }
        a href="#textures" { "All textures" }
        a href="#faces" { "Face by face" }
    };
    let body = html! {
        p.facts {
            "A, the result: " code { (result.dir.display()) } " · "
            (count(result.radiosity.len() as u64)) " texels · "
            (count(diff.faces.len() as u64)) " faces" br;
            "B: what follows from its own light, " code { "E + ρKB" } " gathered anew at every texel, and what "
            "that changes, sent on until it was spent"
        }
        p {
            "The first gathering differs by " b { (percent(one_bounce)) } ", with all later bounces by "
            b { (percent(diff.worst())) } ". A result that solves the radiosity equation differs by nothing; its "
            "own emission and reflectances are taken as true."
        }
        (notes(&diff.notes))
        (figures(diff, pictures))
        section #energy {
            h2 { "Energy" }
            (power(&[("", energy)]))
        }
        (views(pictures))
        (textures(pictures))
        (faces(diff))
        (viewer::once())
    };
    Page {
        title: "Radiosity: a result judged by its own light",
        bar: ("Parts", links),
        verdict: held(diff, tolerance),
        style: "",
        body,
    }
    .html()
}

fn held(diff: &Diff, tolerance: Option<f64>) -> Markup {
    let worst = percent(diff.worst());
    let text = |sign: &str, most| html! { "relative RMS " (worst) " " (sign) " " (percent(most)) };
    match tolerance {
        Some(most) if diff.worst() <= most => verdict(Some(true), "Within", text("≤", most)),
        Some(most) => verdict(Some(false), "Beyond", text(">", most)),
        None => verdict(None, &worst, html! { "relative RMS, the worst channel" }),
    }
}

fn figures(diff: &Diff, pictures: &Pictures) -> Markup {
    let error = diff.standard_error;
    html! {
        p {
            "Reflected radiosity B − E, area-weighted, A against B. Where texels differ in number, both are "
            "averaged over common ones, by area and without loss."
        }
        (table("", &["", "#R", "#G", "#B"], html! {
            tr { td { "Relative RMS" } @for x in diff.relative_rms { td.n { (percent(x)) } } }
            tr { td { "Bias" } @for x in diff.bias { td.n { (percent(x)) } } }
            @if let Some(error) = error {
                tr {
                    td { "The truth's own standard error" }
                    @for x in error { td.n { (percent(x)) } }
                }
            }
            tr { td { "Largest difference ÷ rms" } td.n colspan="3" { (percent(diff.max_relative)) } }
            tr {
                td { "HDR-FLIP, mean over the view" }
                td.n colspan="3" {
                    @match &pictures.flip { Some(flip) => (number(flip.mean)), None => "–" }
                }
            }
        }))
    }
}

fn views(p: &Pictures) -> Markup {
    let white = number(f64::from(p.exposure.white));
    let eye = p
        .camera
        .eye
        .to_array()
        .map(|x| number(f64::from(x)))
        .join(", ");
    html! {
        section #around {
            h2 { "Look around" }
            @if !p.differ { (same()) }
            (p.around)
        }
        section #views {
            h2 { "What they see" }
            div.grid {
                @for ((name, what), source) in [("A", ""), ("B", ", the truth")].into_iter().zip(&p.views) {
                    (figure("", source, &format!("The scene as {name} has it"), html! {
                        b { (name) } (what) " · radiosity. White is " (white) " W/m²; emitters clip."
                    }))
                }
                @if p.differ {
                    (figure("", &p.difference, "Difference in false colours", html! {
                        b { "A − B" } " · luminance of reflected radiosity, relative to its rms in B ("
                        (number(p.rms)) " W/m²); clipped beyond the range." (colour_bar(p.range))
                    }))
                    @if let Some(flip) = &p.flip {
                        (figure("", &flip.picture.data_uri(), "HDR-FLIP error map", html! {
                            b { "HDR-FLIP" } " · what an eye would see if the two views alternated, at the worst of "
                            "the exposures that B asks for: black is nothing (0), pale yellow everything (1). Mean "
                            (number(flip.mean)) ", largest " (number(flip.max)) "."
                        }))
                    }
                }
            }
            p.small {
                "All from one automatic camera (at " (eye) " in the mesh's unit; backs are looked through). Both views "
                "share one exposure: the 90th percentile of what B's surfaces reflect is at 80 % of white. "
                "Reflected radiosity is interpolated between texels."
            }
        }
    }
}

/// In the place of what would be white all over.
fn same() -> Markup {
    html! { p { "No texel differs: there is no difference to draw." } }
}

fn textures(p: &Pictures) -> Markup {
    html! {
        section #textures {
            h2 { "All textures" }
            div.grid {
                @if p.differ { (figure("pixels", &p.atlas_difference, "Atlas of the difference", html! {
                    b { "A − B" } " · every common texel, all faces side by side in file order; colours as above."
                    (colour_bar(p.range))
                })) }
                @for (name, source) in ["A", "B"].into_iter().zip(&p.atlases) {
                    (figure("pixels", source, &format!("Atlas of {name}"), html! {
                        b { (name) } " · radiosity of every texel, as it is stored."
                    }))
                }
            }
        }
    }
}

fn faces(diff: &Diff) -> Markup {
    let mut order: Vec<&FaceDiff> = diff.faces.iter().collect();
    order.sort_by(|x, y| y.share.total_cmp(&x.share));
    let area: f64 = diff.faces.iter().map(|f| f.area).sum();
    let row = |part: &FaceDiff| {
        html! { tr {
            td.n { (part.face) }
            td { (part.name) }
            td.n { (percent(part.share)) }
            td.n { (percent(part.area / area)) }
            td.n { (percent(part.relative_rms)) }
            td.n { (percent(part.bias)) }
        } }
    };
    html! {
        section #faces {
            h2 { "Face by face" }
            p {
                "Sorted by the share of the squared error. RMS and bias are relative to the face's own light, the "
                "worst channel."
            }
            (table("", &["#Face", "Name", "#Of the error", "#Of the area", "#Relative RMS", "#Bias"], html! {
                @for part in order.iter().take(LISTED) { (row(part)) }
            }))
            @if order.len() > LISTED {
                p.small { "The other " (count((order.len() - LISTED) as u64)) " faces are in diff.json." }
            }
        }
    }
}
