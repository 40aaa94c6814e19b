//! Reads photographs from PNG and JPEG files of 8 bits per channel.

use crate::merge::brackets::{Photograph, check_picture_size};
use common::jpeg;
use common::{Error, Result, file};
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// Bytes that a decoder may take beside the pixels, whose number is checked. A colour profile of 8 MB can inflate to 8 GB; one
/// of more than these bytes is skipped.
const MAX_DECODER_BYTES: u64 = 1 << 25;

/// Reads photographs with their exposure times.
///
/// Errors: [`Error::Input`] with the file if it cannot be read.
pub fn read_photographs(paths: &[PathBuf], seconds: &[f64]) -> Result<Vec<Photograph>> {
    let exposures = paths.iter().zip(seconds);
    let read = |(path, seconds): (&PathBuf, &f64)| read_photograph(path, *seconds, paths.len());
    exposures.map(read).collect()
}

/// Reads a photograph, one of `count`; checks its size before decoding.
fn read_photograph(path: &Path, seconds: f64, count: usize) -> Result<Photograph> {
    let refuse = |message: String| Error::bad_input(path, "", message);
    let undecodable =
        |error: image::ImageError| refuse(format!("cannot be decoded ({error}): a PNG or JPEG file is needed"));
    let bytes = file::read_input(path, "")?;
    let mut reader = ImageReader::new(Cursor::new(&bytes))
        .with_guessed_format()
        .map_err(|error| refuse(format!("cannot be read: {error}")))?;
    let is_jpeg = reader.format() == Some(ImageFormat::Jpeg);
    if is_jpeg {
        jpeg::check_whole(&bytes).map_err(refuse)?;
    }
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(MAX_DECODER_BYTES);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(undecodable)?;
    let turned = decoder.orientation().map_err(undecodable)?;
    let (w, h) = decoder.dimensions();
    if is_jpeg {
        jpeg::check_sides((w, h)).map_err(refuse)?;
    }
    check_picture_size(path, [w as usize, h as usize], count)?;
    let bits = decoder.color_type();
    if !matches!(
        bits,
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8
    ) {
        return Err(refuse(format!(
            "has pixels of kind {bits:?}: 8 bits a channel are needed, as the camera wrote them"
        )));
    }
    // The decoder may panic on a damaged file; the error is the file's.
    let decoded = catch_unwind(AssertUnwindSafe(|| DynamicImage::from_decoder(decoder)));
    let decoded = decoded.map_err(|_| refuse("is damaged: copy it again".into()))?;
    let mut image = decoded.map_err(undecodable)?;
    image.apply_orientation(turned);
    // Transparency is ignored.
    let image = image.into_rgb8();
    Ok(Photograph {
        path: path.to_path_buf(),
        seconds,
        size: [image.width() as usize, image.height() as usize],
        pixels: image.pixels().map(|p| p.0).collect(),
    })
}
