//! Reads photographs from PNG and JPEG files of 8 bits per channel.

use crate::merge::brackets::{Brackets, Photograph, check_photograph, check_seconds};
use common::jpeg;
use common::{Error, Result, file};
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// Reads the photographs of a list.
///
/// Errors: [`Error::Input`] with the file if it cannot be read; those of [`Brackets::new`].
pub fn read_brackets(list: &[(PathBuf, f64)]) -> Result<Brackets> {
    for (path, seconds) in list {
        check_seconds(path, *seconds)?;
    }
    let mut exposures: Vec<Photograph> = Vec::with_capacity(list.len());
    for (path, seconds) in list {
        let first = exposures.first().map(|e| (e.path.as_path(), e.size));
        let (size, pixels) = read_photograph(path, first, list.len())?;
        exposures.push(Photograph {
            path: path.clone(),
            seconds: *seconds,
            size,
            pixels,
        });
    }
    Brackets::new(exposures)
}

/// Reads size and codes of a photograph; checks its size against the `first` one before decoding.
fn read_photograph(
    path: &Path,
    first: Option<(&Path, [usize; 2])>,
    count: usize,
) -> Result<([usize; 2], Vec<[u8; 3]>)> {
    let refuse = |message: String| Error::bad_input(path, "", message);
    let undecodable =
        |error: image::ImageError| refuse(format!("cannot be decoded ({error}): a PNG or JPEG file is needed"));
    let bytes = file::read_input(path, "")?;
    let mut reader = ImageReader::new(Cursor::new(&bytes))
        .with_guessed_format()
        .map_err(|error| refuse(format!("cannot be read: {error}")))?;
    if reader.format() == Some(ImageFormat::Jpeg) {
        jpeg::check_whole(&bytes).map_err(refuse)?;
    }
    // `check_photograph` refuses large pictures with this program's message.
    reader.no_limits();
    let mut decoder = reader.into_decoder().map_err(undecodable)?;
    let turned = decoder.orientation().map_err(undecodable)?;
    let (w, h) = decoder.dimensions();
    check_photograph(path, [w as usize, h as usize], None, count)?;
    let bits = decoder.color_type();
    if !matches!(
        bits,
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8
    ) {
        return Err(refuse(format!(
            "has pixels of kind {bits:?}: 8 bits a channel are needed, as the camera wrote them"
        )));
    }
    let mut image = DynamicImage::from_decoder(decoder).map_err(undecodable)?;
    image.apply_orientation(turned);
    // Transparency is ignored.
    let image = image.into_rgb8();
    let size = [image.width() as usize, image.height() as usize];
    check_photograph(path, size, first, count)?;
    Ok((size, image.pixels().map(|p| p.0).collect()))
}
