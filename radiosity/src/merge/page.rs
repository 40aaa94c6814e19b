//! Composes `merge.html`: pictures, camera response and exposures of a merge.

use super::brackets::{Brackets, CameraResponse, ExposureStep, RadianceMap};
use super::{luminance_stops, merge_notes};
use crate::report::document::{Blocks, Cell, Figure, Row, Table, bold_text, code_text, render_document};
use crate::report::format::{format_count, format_number, format_percent};
use crate::report::picture::{Exposure, RgbaPicture, encode_srgb};
use crate::report::plot::{Axis, CPU_COLOUR, LineStyle, Plot, Series};
use std::f64::consts::LN_2;

/// Width and height of the response's plot in CSS pixels; the page scales it.
const PLOT_SIZE: [u32; 2] = [720, 380];
/// Approximate maximum pixels per side of a picture; larger ones are subsampled.
const MAX_PICTURE_SIDE: usize = 640;
/// Pictures: name, share of the pixels that it shows no brighter than 0.8 of white, and that in words.
const PICTURE_PERCENTILES: [(&str, f64, &str); 3] = [
    ("Dark parts", 0.5, "half of the pixels are brighter than 80 % of white"),
    ("Most of it", 0.9, "the 90th percentile is at 80 % of white"),
    (
        "Bright parts",
        0.995,
        "all but one pixel in 200 are below 80 % of white",
    ),
];

/// Renders the page.
pub fn render_page(
    brackets: &Brackets,
    response: &CameraResponse,
    merged: &RadianceMap,
    steps: &[ExposureStep],
) -> String {
    let mut opening = Blocks::default();
    let [w, h] = merged.size;
    let stops = luminance_stops(merged).map_or(String::new(), |stops| {
        let stops = format_number(stops);
        format!(" · {stops} stops of luminance from the 1st to the 99th percentile")
    });
    opening.add_remark(format!(
        "{} exposures · {w}×{h} pixels{stops}",
        brackets.photographs().len()
    ));
    opening.add_paragraph(
        "Relative radiance: 1 gives code 128 in one second, in each channel. A pixel is the mean of its exposures, \
         weighted by code with a hat function that is largest at mid-scale and 0 at 0 and 255 (Debevec and Malik \
         1997, eq. 6).",
    );
    opening.add_table(unseen_table(merged));
    opening.add_notes(merge_notes(brackets, response, steps));
    opening.add_figures(&draw_pictures(merged));

    let mut curves = Blocks::default();
    let [r, g, b] = response.samples.map(|n| format_count(n as u64));
    let caption = format!(
        "Code against exposure, by least squares over {r}, {g} and {b} pixels (eq. 3). Code 128 is the same exposure \
         in each channel, so that grey stays grey. The curves are extrapolated linearly to 0 and 255."
    );
    let plot = response_plot(response);
    curves.add_figure(&Figure::from_plot(&plot, "There is no curve to draw.", caption));
    let mut exposures = Blocks::default();
    exposures.add_paragraph(
        "A step is the ratio of one exposure to the next, in stops: nominal by exposure times, and measured by common \
         pixels through the response.",
    );
    exposures.add_table(exposure_table(brackets, merged, steps));
    let sections = [
        curves.into_section("response", "Response of the camera"),
        exposures.into_section("exposures", "Exposures"),
    ];
    render_document("Radiosity: a radiance map from exposures", &opening, &sections, "")
}

/// Returns the share of the pixels in per cent.
fn format_share_of(merged: &RadianceMap, pixels: usize) -> String {
    format_percent(pixels as f64 / merged.radiance.len() as f64)
}

fn unseen_table(merged: &RadianceMap) -> Table {
    let unseen = merged.unseen;
    let rows = [
        (
            "saturated in all exposures",
            unseen.saturated,
            "that of code 255 in the shortest exposure, a lower bound",
        ),
        ("black in all exposures", unseen.black, "0"),
        (
            "saturated in the longer, black in the shorter ones",
            unseen.between,
            "the geometric mean of both bounds: an exposure is missing in between",
        ),
    ];
    let rows = rows.map(|(name, pixels, value)| {
        let (count, share) = (format_count(pixels as u64), format_share_of(merged, pixels));
        Row::new([name, &count, &share, value])
    });
    Table::new(
        "Pixels with a channel that is;#Pixels;#Of all;Value of the channel",
        rows,
    )
}

/// Draws the map exposed for the dark half, for most pixels, and for all but the brightest.
fn draw_pictures(merged: &RadianceMap) -> Vec<Figure> {
    PICTURE_PERCENTILES
        .into_iter()
        .map(|(name, share, what)| {
            let values = merged.radiance.iter().map(|v| (v.max_element(), 1.0));
            let exposure = Exposure::from_percentile(values, share);
            let source = draw_thinned(merged.size, |k| encode_srgb(exposure.display_light(merged.radiance[k])));
            let says = format!(" · {what}. White is {}.", format_number(exposure.white.into()));
            Figure::from_picture(&source, &format!("The merged picture: {name}"), bold_text(name) + says)
        })
        .collect()
}

/// Draws a subsampled picture as a data URI.
fn draw_thinned([w, h]: [usize; 2], colour: impl Fn(usize) -> [u8; 3]) -> String {
    let step = w.max(h).div_ceil(MAX_PICTURE_SIDE).max(1);
    let pixels = |n: usize| n.div_ceil(step) as u32;
    let at = |x: u32, y: u32| Some(colour(y as usize * step * w + x as usize * step));
    RgbaPicture::from_pixels(pixels(w), pixels(h), at).data_uri()
}

/// Plots code against exposure (stops from that of code 128), as in Debevec and Malik 1997.
fn response_plot(response: &CameraResponse) -> Plot {
    let curve = |(name, colour, curve): (&str, &'static str, &[f64; 256])| {
        let points = curve.iter().zip(0..=255).map(|(g, code)| [g / LN_2, f64::from(code)]);
        Series {
            name: name.into(),
            ..Series::through_points(colour, LineStyle::with_width(2.0), points)
        }
    };
    let [red, green, blue] = &response.curves;
    let stops = || response.curves.iter().flatten().map(|g| g / LN_2);
    let ends = [
        stops().fold(f64::INFINITY, f64::min),
        stops().fold(f64::NEG_INFINITY, f64::max),
    ];
    let whole = |x: f64| format!("{x:.0}").replace('-', "−");
    let title = "exposure E Δt, stops from that of code 128";
    Plot {
        size: PLOT_SIZE,
        axes: [
            Axis::linear_scale(title, [ends[0].floor(), ends[1].ceil()], whole),
            Axis::linear_scale("code", [0.0, 256.0], whole),
        ],
        series: [
            ("red", "#cd3c3c", red),
            ("green", "#2c9650", green),
            ("blue", CPU_COLOUR, blue),
        ]
        .map(curve)
        .into(),
        legend_width: 90,
    }
}

fn exposure_table(brackets: &Brackets, merged: &RadianceMap, steps: &[ExposureStep]) -> Table {
    let all = brackets.photographs();
    let rows = all.iter().enumerate().map(|(k, photograph)| {
        let step = k.checked_sub(1).map(|before| steps[before]);
        let measured = step.map(|step| match step.measured {
            Some(stops) => format!("{stops:.2}").replace('-', "−"),
            None => "–".into(),
        });
        let has = |code: u8| {
            let pixels = photograph.pixels.iter().filter(|p| p.contains(&code));
            format_share_of(merged, pixels.count())
        };
        let path = &photograph.path;
        let file = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        let values = [
            format_number(photograph.seconds),
            step.map_or(String::new(), |step| format!("{:.2}", step.nominal)),
            measured.unwrap_or_default(),
            has(255),
            has(0),
        ];
        Row::new([Cell::from(code_text(file))].into_iter().chain(values.map(Cell::from)))
    });
    let heads = "Picture;#Seconds;#Nominal step;#Measured step;#With code 255;#With code 0";
    Table::new(heads, rows)
}
