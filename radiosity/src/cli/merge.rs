//! `radiosity merge`: makes a radiance map of bracketed photographs.

use super::Outcome;
use super::console::message;
use crate::merge::brackets::{Brackets, CameraResponse, RadianceMap};
use crate::merge::{luminance_stops, merge_notes, page, photographs};
use crate::relight::files::encode_picture;
use clap::Args;
use common::solution::{prepare_folder, write_files};
use common::{Error, Result};
use std::path::PathBuf;

/// Arguments of `merge`.
#[derive(Args)]
pub struct MergeArguments {
    /// Photographs of one view, PNG or JPEG, aligned and of one size
    #[arg(value_name = "IMAGE", required = true)]
    images: Vec<PathBuf>,
    /// Exposure times, in the same order: 0.5 or 1/2
    #[arg(long, value_name = "S,S,…", required = true, value_delimiter = ',', value_parser = parse_seconds)]
    seconds: Vec<f64>,
    /// Folder for radiance.exr and merge.html
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
}

/// Parses "0.0125" or "1/80".
fn parse_seconds(text: &str) -> std::result::Result<f64, String> {
    let (above, below) = text.split_once('/').unwrap_or((text, "1"));
    match (above.trim().parse::<f64>(), below.trim().parse::<f64>()) {
        (Ok(a), Ok(b)) if a / b > 0.0 && (a / b).is_finite() => Ok(a / b),
        _ => Err(format!("{text} is not a number of seconds above 0")),
    }
}

/// Merges the photographs and writes the map and its page.
pub fn run(arguments: &MergeArguments) -> Result<Outcome> {
    let MergeArguments { images, seconds, out } = arguments;
    if images.len() != seconds.len() {
        return Err(Error::Usage(format!(
            "{} images and {} --seconds: give one for each image, in the same order",
            images.len(),
            seconds.len()
        )));
    }
    let brackets = Brackets::new(photographs::read_photographs(images, seconds)?)?;
    let response = CameraResponse::from_brackets(&brackets)?;
    prepare_folder(out, &["radiance.exr", "merge.html"])?;
    let merged = RadianceMap::new(&brackets, &response);
    let steps = brackets.exposure_steps(&response);
    for note in merge_notes(&brackets, &response, &steps) {
        message!("note: {note}");
    }
    let html = page::render_page(&brackets, &response, &merged, &steps);
    let [width, height] = merged.size;
    let map = encode_picture([width as u32, height as u32], &merged.radiance, &[])?;
    write_files(out, [("radiance.exr", map), ("merge.html", html.into_bytes())])?;
    message!(
        "{} exposures, {width}×{height} pixels, {:.1} stops from the 1st to the 99th percentile; saturated in all {}, black in all {}, in between {}",
        images.len(),
        luminance_stops(&merged).unwrap_or(0.0),
        merged.unseen.saturated,
        merged.unseen.black,
        merged.unseen.between,
    );
    message!("wrote {0}/radiance.exr and {0}/merge.html", out.display());
    Ok(Outcome::Done)
}
