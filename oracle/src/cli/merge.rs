//! `radiosity merge`.

use super::Outcome;
use super::tell::say;
use crate::merge::brackets::{Merged, Response, Step};
use crate::merge::fisheye::angular;
use crate::merge::{Range, doubts, list, page, read};
use crate::relight::files::write_exr;
use clap::Args;
use common::solution::{prepare, write_file};
use common::{Error, Result};
use std::path::PathBuf;

/// What the EXR file says of itself.
const COMMENT: &str =
    "R G B: relative radiance, linear, in the camera's primaries; 1 gives code 128 in one second";

/// Arguments of `merge`.
#[derive(Args)]
pub struct Arguments {
    /// Photographs of one view, PNG or JPEG, aligned and of one size
    #[arg(value_name = "IMAGE", required_unless_present = "exposures")]
    images: Vec<PathBuf>,
    /// How long each was exposed, in the same order: 0.5 or 1/2
    #[arg(long, value_name = "S,S,…", value_delimiter = ',', value_parser = seconds, required_unless_present = "exposures")]
    seconds: Vec<f64>,
    /// The same as a table: a column `file`, relative to it, and one of seconds
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["images", "seconds"])]
    exposures: Option<PathBuf>,
    /// Its column of seconds [default: the first of seconds_third_stop_exact, seconds, seconds_nominal]
    #[arg(long, value_name = "NAME", requires = "exposures")]
    column: Option<String>,
    /// The photographs are circular fisheyes, equidistant, of this field of view: write an angular map
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    fisheye: Option<f64>,
    /// Where radiance.exr and merge.html go
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// No summary
    #[arg(long)]
    quiet: bool,
}

fn seconds(text: &str) -> std::result::Result<f64, String> {
    list::seconds(text).ok_or_else(|| format!("{text} is not a number of seconds above 0"))
}

/// Merges and writes.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let exposures = exposures(arguments)?;
    let brackets = read::brackets(&exposures)?;
    let response = Response::recover(&brackets)?;
    let merged = Merged::new(&brackets, &response);
    let steps = brackets.steps(&response);
    for note in doubts(&brackets, &response, &steps) {
        say!("note: {note}");
    }
    let framed = arguments
        .fisheye
        .map(|degrees| angular(merged.size, &merged.radiance, degrees))
        .transpose()?;
    let (size, radiance) = match &framed {
        Some((side, map)) => ([*side; 2], map),
        None => (merged.size, &merged.radiance),
    };
    prepare(&arguments.out)?;
    let field = arguments.fisheye.map(|degrees| (degrees, size[0]));
    let html = page::html(&brackets, &response, &merged, &steps, field);
    write_exr(
        &arguments.out.join("radiance.exr"),
        size.map(|n| n as u32),
        radiance,
        &[],
        COMMENT,
    )?;
    write_file(&arguments.out.join("merge.html"), html.as_bytes())?;
    if !arguments.quiet {
        summary(&merged, &steps, arguments);
    }
    Ok(Outcome::Done)
}

/// Files and seconds, however they were given.
fn exposures(arguments: &Arguments) -> Result<Vec<(PathBuf, f64)>> {
    if let Some(path) = &arguments.exposures {
        return list::read(path, arguments.column.as_deref());
    }
    let (images, seconds) = (&arguments.images, &arguments.seconds);
    if images.len() != seconds.len() {
        return Err(Error::Usage(format!(
            "{} images and {} --seconds: give one for each image, in the same order",
            images.len(),
            seconds.len()
        )));
    }
    Ok(images
        .iter()
        .cloned()
        .zip(seconds.iter().copied())
        .collect())
}

fn summary(merged: &Merged, steps: &[Step], arguments: &Arguments) {
    let unseen = merged.unseen;
    say!(
        "{} exposures, {}×{} pixels, {:.1} stops from the 1st to the 99th percentile; saturated in all {}, black in all {}, in between {}",
        steps.len() + 1,
        merged.size[0],
        merged.size[1],
        Range::of(merged).map_or(0.0, |range| range.stops()),
        unseen.saturated,
        unseen.black,
        unseen.between,
    );
    say!(
        "wrote {0}/radiance.exr and {0}/merge.html",
        arguments.out.display()
    );
}
