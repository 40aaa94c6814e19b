//! Decoding of EXR files to named planes of 32-bit floats.

use crate::error::{Error, Result};
use crate::file;
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::{FlatImage, ReadChannels, ReadLayers, Vec2, read};
use std::collections::BTreeMap;
use std::panic::catch_unwind;
use std::path::Path;

/// Maximum number of values in a file (4 GB), checked before they are allocated.
pub(crate) const MAX_VALUES: u64 = 1 << 30;

/// Planes of an image, of `width × height` values each, row by row from the upper left.
#[derive(Clone, Debug, Default)]
pub struct ImagePlanes {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Values by channel name.
    pub channels: BTreeMap<String, Vec<f32>>,
}

impl ImagePlanes {
    /// Reads the first layer of the EXR file at `path`; half floats and integers are converted.
    ///
    /// Errors: not an EXR, damaged, cut short, deep, subsampled, or of more than `max_pixels`.
    pub fn read(path: &Path, max_pixels: u64) -> Result<Self> {
        Self::decode(path, &file::read_input(path, "")?, max_pixels)
    }

    /// Decodes the `bytes` of the file at `path`.
    ///
    /// Errors: as of [`ImagePlanes::read`].
    pub fn decode(path: &Path, bytes: &[u8], max_pixels: u64) -> Result<Self> {
        let refuse = |message: String| Error::bad_input(path, "", message);
        check_header(bytes, max_pixels).map_err(refuse)?;
        let image = decode_layers(bytes)
            .map_err(|message| refuse(format!("cannot be decoded ({message}): write or copy it again")))?;
        let layer = image
            .layer_data
            .into_iter()
            .next()
            .ok_or_else(|| refuse("has no layer".into()))?;
        let channels = layer.channel_data.list.into_iter();
        Ok(Self {
            width: layer.size.0,
            height: layer.size.1,
            channels: channels
                .map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect()))
                .collect(),
        })
    }

    /// Returns the planes `prefix`R, G and B, if all three exist.
    pub fn colour_planes(&self, prefix: &str) -> Option<[&[f32]; 3]> {
        let plane = |letter| self.channels.get(&format!("{prefix}{letter}")).map(Vec::as_slice);
        Some([plane("R")?, plane("G")?, plane("B")?])
    }
}

/// Checks the header before memory is allocated for the pixels.
fn check_header(bytes: &[u8], max_pixels: u64) -> std::result::Result<(), String> {
    let meta = MetaData::read_from_buffered(bytes, true)
        .map_err(|error| format!("is not an EXR file that can be read ({error})"))?;
    let header = meta.headers.first().ok_or("has no layer")?;
    if meta.headers.iter().any(|header| header.deep) {
        return Err("holds deep pixels: a flat image is needed".into());
    }
    let Vec2(width, height) = header.layer_size;
    let pixels = (width as u64).saturating_mul(height as u64);
    if pixels > max_pixels || count_values(&meta) > MAX_VALUES {
        return Err(format!(
            "has {width}×{height} pixels of {} channels: more than can belong to the faces",
            header.channels.list.len()
        ));
    }
    match header.channels.list.iter().find(|c| c.sampling != Vec2(1, 1)) {
        Some(channel) => Err(format!("its channel {} is subsampled", channel.name)),
        None => Ok(()),
    }
}

/// Returns the number of values of all layers.
pub(crate) fn count_values(meta: &MetaData) -> u64 {
    let of_layer = |header: &Header| {
        let pixels = (header.layer_size.0 as u64).saturating_mul(header.layer_size.1 as u64);
        pixels.saturating_mul(header.channels.list.len() as u64)
    };
    meta.headers.iter().map(of_layer).fold(0, u64::saturating_add)
}

/// Decodes all layers at their largest level; half floats and integers stay what they are.
///
/// Errors: the decoder's, or that the file is damaged.
pub(crate) fn decode_layers(bytes: &[u8]) -> std::result::Result<FlatImage, String> {
    // Pedantic: a truncated file is an error, not a picture with a black part. On this thread: in the
    // decoder's own pool a panic over a damaged block would end the program.
    let decode = || {
        read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .pedantic()
            .non_parallel()
            .from_buffered(std::io::Cursor::new(bytes))
    };
    // The decoder may panic on a damaged file; the error is the file's.
    let image = catch_unwind(decode).map_err(|_| "damaged".to_owned())?;
    image.map_err(|error| error.to_string())
}
