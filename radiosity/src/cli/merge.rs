//! `radiosity merge`.

use super::Outcome;
use super::console::message;
use crate::merge::brackets::{CameraResponse, ExposureStep, RadianceMap};
use crate::merge::{exposure_list, luminance_stops, merge_notes, page, photographs};
use crate::relight::files::write_exr;
use clap::Args;
use common::solution::{prepare_directory, write_file};
use common::{Error, Result};
use std::path::PathBuf;

/// The comment attribute of the EXR file.
const EXR_COMMENT: &str = "R G B: relative radiance, linear, in the camera's primaries; 1 gives code 128 in one second";

/// Arguments of `merge`.
#[derive(Args)]
pub struct MergeArguments {
    /// Photographs of one view, PNG or JPEG, aligned and of one size; or a .csv with columns `file` and `seconds`
    #[arg(value_name = "IMAGE", required = true)]
    images: Vec<PathBuf>,
    /// Exposure times, in the same order: 0.5 or 1/2
    #[arg(long, value_name = "S,S,…", value_delimiter = ',', value_parser = parse_exposure_time)]
    seconds: Vec<f64>,
    /// Folder for radiance.exr and merge.html
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// No summary
    #[arg(long)]
    quiet: bool,
}

fn parse_exposure_time(text: &str) -> std::result::Result<f64, String> {
    exposure_list::parse_seconds(text).ok_or_else(|| format!("{text} is not a number of seconds above 0"))
}

/// Merges the photographs and writes the map and its page.
pub fn run(arguments: &MergeArguments) -> Result<Outcome> {
    let exposures = list_exposures(arguments)?;
    let brackets = photographs::read_brackets(&exposures)?;
    let response = CameraResponse::from_brackets(&brackets)?;
    let merged = RadianceMap::new(&brackets, &response);
    let steps = brackets.exposure_steps(&response);
    for note in merge_notes(&brackets, &response, &steps) {
        message!("note: {note}");
    }
    let out = &arguments.out;
    prepare_directory(out)?;
    let html = page::render_page(&brackets, &response, &merged, &steps);
    let size = merged.size.map(|n| n as u32);
    write_exr(&out.join("radiance.exr"), size, &merged.radiance, &[], EXR_COMMENT)?;
    write_file(&out.join("merge.html"), html.as_bytes())?;
    if !arguments.quiet {
        print_summary(&merged, &steps, arguments);
    }
    Ok(Outcome::Done)
}

/// Returns files and exposure times, from the command line or the table.
fn list_exposures(arguments: &MergeArguments) -> Result<Vec<(PathBuf, f64)>> {
    let (images, seconds) = (&arguments.images, &arguments.seconds);
    if let ([table], true) = (&images[..], seconds.is_empty()) {
        return exposure_list::read_exposures(table);
    }
    if images.len() != seconds.len() {
        return Err(Error::Usage(format!(
            "{} images and {} --seconds: give one for each image, in the same order",
            images.len(),
            seconds.len()
        )));
    }
    Ok(images.iter().cloned().zip(seconds.iter().copied()).collect())
}

fn print_summary(merged: &RadianceMap, steps: &[ExposureStep], arguments: &MergeArguments) {
    let unseen = merged.unseen;
    message!(
        "{} exposures, {}×{} pixels, {:.1} stops from the 1st to the 99th percentile; saturated in all {}, black in all {}, in between {}",
        steps.len() + 1,
        merged.size[0],
        merged.size[1],
        luminance_stops(merged).unwrap_or(0.0),
        unseen.saturated,
        unseen.black,
        unseen.between,
    );
    message!("wrote {0}/radiance.exr and {0}/merge.html", arguments.out.display());
}
