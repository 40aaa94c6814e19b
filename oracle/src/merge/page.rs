//! `merge.html`: response, pictures and exposures of one merge, in one file that opens offline.

use super::chart::{COLOURS, curves};
use super::pictures::{Pictures, colour};
use super::{Range, doubts};
use crate::merge::brackets::{Brackets, Merged, Response, Step};
use crate::show::number::{count, number, percent};
use crate::show::page::{Page, chart, css, figure, key, notes, table};
use crate::show::picture::NOT_A_NUMBER;
use maud::{Markup, html};
use std::path::Path;

/// The page; `framed` are field of view and side, if the file holds an angular map.
pub fn html(
    brackets: &Brackets,
    response: &Response,
    merged: &Merged,
    steps: &[Step],
    framed: Option<(f64, usize)>,
) -> String {
    let links = html! {
        a href="#top" { "Pictures" }
        a href="#response" { "Response" }
        a href="#exposures" { "Exposures" }
    };
    let body = html! {
        (facts(brackets, merged, framed))
        (notes(&doubts(brackets, response, steps)))
        (views(&Pictures::new(brackets, merged)))
        (curve(response))
        (exposures(brackets, merged, steps))
    };
    Page {
        title: "Radiosity: a radiance map from exposures",
        bar: ("Parts", links),
        verdict: html! {},
        style: "",
        body,
    }
    .html()
}

fn facts(brackets: &Brackets, merged: &Merged, framed: Option<(f64, usize)>) -> Markup {
    let [w, h] = merged.size;
    let unseen = merged.unseen;
    let row = |name: &str, pixels: usize, gets: &str| {
        let share = pixels as f64 / merged.radiance.len() as f64;
        html! { tr {
            td { (name) } td.n { (count(pixels as u64)) } td.n { (percent(share)) } td { (gets) }
        } }
    };
    html! {
        p.facts {
            (count(brackets.exposures().len() as u64)) " exposures · " (w) "×" (h) " pixels"
            @if let Some(range) = Range::of(merged) {
                " · " (number(range.stops())) " stops of luminance from the 1st to the 99th percentile"
            }
        }
        @if let Some((degrees, side)) = framed {
            p {
                code { "radiance.exr" } " holds the picture's circle, a field of view of " (number(degrees))
                "°, as an angular map of " (side) "×" (side) " pixels: 0 where nothing was photographed."
            }
        }
        p {
            "Relative radiance: 1 is what gives code 128 in one second, in each channel. A pixel is the mean of "
            "what its exposures say, each with the weight of its code, which is most at mid-scale and nothing at "
            "0 and 255 (Debevec and Malik 1997, eq. 6)."
        }
        (table("", &["Pixels of which a channel is", "#Pixels", "#Of all", "and what it gets"], html! {
            (row("saturated in all exposures", unseen.saturated,
                "what code 255 means in the shortest: it has at least as much"))
            (row("black in all exposures", unseen.black, "0"))
            (row("saturated in the longer, black in the shorter ones", unseen.between,
                "the geometric mean of what both allow: an exposure is missing in between"))
        }))
    }
}

fn views(pictures: &Pictures) -> Markup {
    let says = [
        (
            "Dark parts",
            "half of the pixels are brighter than 80 % of white",
        ),
        ("Most of it", "the 90th percentile is at 80 % of white"),
        (
            "Bright parts",
            "all but one pixel in 200 are below 80 % of white",
        ),
    ];
    let first = f64::from(pictures.merged[0].0.white);
    html! {
        div.grid {
            @for ((name, what), (exposure, source)) in says.into_iter().zip(&pictures.merged) {
                @let white = f64::from(exposure.white);
                (figure("", source, &format!("The merged picture: {name}"), html! {
                    b { (name) } " · " (what) ". White is " (number(white))
                    @if white > first { ", " (number((white / first).log2())) " stops above the first" }
                    "."
                }))
            }
            (figure("", &pictures.relied, "The exposure each pixel relied on", html! {
                b { "Relied on" } " · the exposure that weighs most in a pixel, from the longest (violet) to the "
                "shortest (yellow); magenta: none. The table below has the colours."
            }))
        }
    }
}

fn curve(response: &Response) -> Markup {
    let [r, g, b] = response.samples.map(|n| count(n as u64));
    let names = ["red", "green", "blue"];
    html! {
        section #response {
            h2 { "Response of the camera" }
            (chart(curves(response).as_deref(), "There is no curve to draw.", html! {
                @for (name, colour) in names.into_iter().zip(COLOURS) {
                    (key(colour, html! { (name) })) " "
                }
                "· which code an exposure gives, by least squares over " (r) ", " (g) " and " (b) " pixels "
                "(eq. 3). Code 128 is the same exposure in each channel, so that grey stays grey. At 0 and 255 "
                "the curves are drawn on straight."
            }))
        }
    }
}

/// The last part of a path.
fn name(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

/// As cameras show it.
fn seconds(seconds: f64) -> String {
    if seconds < 0.3 {
        format!("1/{}", number(1.0 / seconds))
    } else {
        number(seconds)
    }
}

fn exposures(brackets: &Brackets, merged: &Merged, steps: &[Step]) -> Markup {
    let all = brackets.exposures();
    let mut relied = vec![0_usize; all.len()];
    for k in merged.relied.iter().flatten() {
        relied[*k as usize] += 1;
    }
    let none = merged.relied.iter().filter(|k| k.is_none()).count();
    let share = |n: usize| percent(n as f64 / merged.radiance.len() as f64);
    let has = |k: usize, code: u8| {
        let pixels = all[k].pixels.iter();
        share(pixels.filter(|p| p.contains(&code)).count())
    };
    let row = |k: usize| {
        let step = k.checked_sub(1).map(|before| steps[before]);
        html! { tr {
            td title=(all[k].path.display()) {
                (key(&css(colour(k, all.len())), html! { code { (name(&all[k].path)) } }))
            }
            td.n { (seconds(all[k].seconds)) }
            td.n { @if let Some(step) = step { (format!("{:.2}", step.said)) } }
            td.n { @if let Some(step) = step {
                @match step.seen { Some(seen) => (format!("{seen:.2}").replace('-', "−")), None => "–" }
            } }
            td.n { (has(k, 255)) }
            td.n { (has(k, 0)) }
            td.n { (share(relied[k])) }
        } }
    };
    html! {
        section #exposures {
            h2 { "Exposures" }
            p {
                "A step is how much less light an exposure got than the one before it, in stops: as its seconds "
                "say, and as the pixels that both show say through the response."
            }
            (table("", &["Picture", "#Seconds", "#Step said", "#Step seen", "#With code 255", "#With code 0",
                "#Relied on"], html! {
                @for k in 0..all.len() { (row(k)) }
                @if none > 0 { tr {
                    td { (key(&css(NOT_A_NUMBER), html! { "none" })) }
                    td colspan="5" {}
                    td.n { (share(none)) }
                } }
            }))
        }
    }
}
