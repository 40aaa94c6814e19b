//! Renders `merge.html`: pictures, camera response and exposures of a merge.

use super::chart::{CHANNEL_COLOURS, render_response_chart};
use super::pictures::{MergePictures, exposure_colour};
use super::{LuminanceRange, merge_notes};
use crate::merge::brackets::{Brackets, CameraResponse, ExposureStep, RadianceMap};
use crate::report::format::{format_count, format_number, format_percent};
use crate::report::page::{Page, css_colour, render_chart, render_colour_key, render_figure, render_notes};
use crate::report::picture::NOT_A_NUMBER;
use crate::report::table::{TableRow, number_cell, render_table, text_cell};
use maud::{Markup, html};
use std::path::Path;

/// Renders the page; `framed` is field of view and side if the file holds an angular map.
pub fn render_page(
    brackets: &Brackets,
    response: &CameraResponse,
    merged: &RadianceMap,
    steps: &[ExposureStep],
    framed: Option<(f64, usize)>,
) -> String {
    let links = html! {
        a href="#top" { "Pictures" }
        a href="#response" { "Response" }
        a href="#exposures" { "Exposures" }
    };
    let body = html! {
        (render_facts(brackets, merged, framed))
        (render_notes(&merge_notes(brackets, response, steps)))
        (render_views(&MergePictures::new(brackets, merged)))
        (render_response(response))
        (exposure_table(brackets, merged, steps))
    };
    Page {
        title: "Radiosity: a radiance map from exposures",
        bar: ("Parts", links),
        verdict: html! {},
        style: "",
        body,
    }
    .to_html()
}

fn render_facts(brackets: &Brackets, merged: &RadianceMap, framed: Option<(f64, usize)>) -> Markup {
    let [w, h] = merged.size;
    let unseen = merged.unseen;
    let row = |name: &str, pixels: usize, gets: &str| {
        let share = pixels as f64 / merged.radiance.len() as f64;
        let [pixels, share] = [format_count(pixels as u64), format_percent(share)].map(number_cell);
        TableRow::new([text_cell(name), pixels, share, text_cell(gets)])
    };
    html! {
        p.facts {
            (format_count(brackets.photographs().len() as u64)) " exposures · " (w) "×" (h) " pixels"
            @if let Some(range) = LuminanceRange::from_map(merged) {
                " · " (format_number(range.stop_count())) " stops of luminance from the 1st to the 99th percentile"
            }
        }
        @if let Some((degrees, side)) = framed {
            p {
                code { "radiance.exr" } " holds the picture's circle, a field of view of " (format_number(degrees))
                "°, as an angular map of " (side) "×" (side) " pixels: 0 outside the circle."
            }
        }
        p {
            "Relative radiance: 1 gives code 128 in one second, in each channel. A pixel is the mean of its exposures, "
            "weighted by code with a hat function that is largest at mid-scale and 0 at 0 and 255 (Debevec and Malik "
            "1997, eq. 6)."
        }
        (render_table("", &["Pixels with a channel that is", "#Pixels", "#Of all", "Value of the channel"], [
            row("saturated in all exposures", unseen.saturated,
                "that of code 255 in the shortest exposure, a lower bound"),
            row("black in all exposures", unseen.black, "0"),
            row("saturated in the longer, black in the shorter ones", unseen.between,
                "the geometric mean of both bounds: an exposure is missing in between"),
        ]))
    }
}

fn render_views(pictures: &MergePictures) -> Markup {
    let says = [
        ("Dark parts", "half of the pixels are brighter than 80 % of white"),
        ("Most of it", "the 90th percentile is at 80 % of white"),
        ("Bright parts", "all but one pixel in 200 are below 80 % of white"),
    ];
    let first = f64::from(pictures.merged[0].0.white);
    html! {
        div.grid {
            @for ((name, what), (exposure, source)) in says.into_iter().zip(&pictures.merged) {
                @let white = f64::from(exposure.white);
                (render_figure("", source, &format!("The merged picture: {name}"), html! {
                    b { (name) } " · " (what) ". White is " (format_number(white))
                    @if white > first { ", " (format_number((white / first).log2())) " stops above the first" }
                    "."
                }))
            }
            (render_figure("", &pictures.dominant, "The dominant exposure of each pixel", html! {
                b { "Dominant exposure" } " · the exposure with the largest weight in a pixel, from the longest "
                "(violet) to the shortest (yellow); magenta: none. The table below has the colours."
            }))
        }
    }
}

fn render_response(response: &CameraResponse) -> Markup {
    let [r, g, b] = response.samples.map(|n| format_count(n as u64));
    let names = ["red", "green", "blue"];
    html! {
        section #response {
            h2 { "Response of the camera" }
            (render_chart(render_response_chart(response).as_deref(), "There is no curve to draw.", html! {
                @for (name, colour) in names.into_iter().zip(CHANNEL_COLOURS) {
                    (render_colour_key(colour, html! { (name) })) " "
                }
                "· code against exposure, by least squares over " (r) ", " (g) " and " (b) " pixels (eq. 3). Code 128 "
                "is the same exposure in each channel, so that grey stays grey. The curves are extrapolated linearly to "
                "0 and 255."
            }))
        }
    }
}

/// Returns the last part of a path.
fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

/// Formats an exposure time like cameras do.
fn format_seconds(seconds: f64) -> String {
    if seconds < 0.3 {
        format!("1/{}", format_number(1.0 / seconds))
    } else {
        format_number(seconds)
    }
}

fn exposure_table(brackets: &Brackets, merged: &RadianceMap, steps: &[ExposureStep]) -> Markup {
    let all = brackets.photographs();
    let mut relied = vec![0_usize; all.len()];
    for k in merged.dominant.iter().flatten() {
        relied[*k as usize] += 1;
    }
    let none = merged.dominant.iter().filter(|k| k.is_none()).count();
    let share = |n: usize| format_percent(n as f64 / merged.radiance.len() as f64);
    let has = |k: usize, code: u8| {
        let pixels = all[k].pixels.iter();
        share(pixels.filter(|p| p.contains(&code)).count())
    };
    let row = |k: usize| {
        let step = k.checked_sub(1).map(|before| steps[before]);
        let nominal = step.map(|step| format!("{:.2}", step.nominal));
        let measured = step.map(|step| match step.measured {
            Some(stops) => format!("{stops:.2}").replace('-', "−"),
            None => "–".into(),
        });
        let colour = css_colour(exposure_colour(k, all.len()));
        let key = render_colour_key(&colour, html! { code { (file_name(&all[k].path)) } });
        TableRow::new([
            text_cell(key).with_title(all[k].path.display()),
            number_cell(format_seconds(all[k].seconds)),
            number_cell(nominal.unwrap_or_default()),
            number_cell(measured.unwrap_or_default()),
            number_cell(has(k, 255)),
            number_cell(has(k, 0)),
            number_cell(share(relied[k])),
        ])
    };
    let none_row = (none > 0).then(|| {
        let key = render_colour_key(&css_colour(NOT_A_NUMBER), html! { "none" });
        TableRow::new([
            text_cell(key),
            text_cell("").with_column_span(5),
            number_cell(share(none)),
        ])
    });
    let rows = (0..all.len()).map(row).chain(none_row);
    let heads = [
        "Picture",
        "#Seconds",
        "#Nominal step",
        "#Measured step",
        "#With code 255",
        "#With code 0",
        "#Dominant",
    ];
    html! {
        section #exposures {
            h2 { "Exposures" }
            p {
                "A step is the ratio of one exposure to the next, in stops: nominal by exposure times, and measured by "
                "common pixels through the response."
            }
            (render_table("", &heads, rows))
        }
    }
}
