//! Decoding of EXR files to named planes of 32-bit floats. Lightmaps, maps of captured rooms and OpenEXR panoramas are
//! read by it.

use crate::error::{Error, Result};
use crate::file;
use exr::meta::MetaData;
use exr::prelude::{AnyChannels, FlatSamples, Layer, ReadChannels, ReadLayers, Vec2, read};
use std::collections::BTreeMap;
use std::panic::catch_unwind;
use std::path::Path;

/// Maximum number of values in a file (4 GB), checked before they are allocated.
const MAX_VALUES: u64 = 1 << 30;

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
        let decoded = decode_layer(bytes, |meta| {
            if meta.headers.iter().any(|header| header.deep) {
                return Err("holds deep pixels: a flat image is needed".into());
            }
            let header = meta.headers.first().ok_or("has no layer")?;
            let Vec2(width, height) = header.layer_size;
            if (width as u64).saturating_mul(height as u64) > max_pixels {
                return Err(format!(
                    "has {width}×{height} pixels of {} channels: more than can belong to the faces",
                    header.channels.list.len()
                ));
            }
            Ok(0)
        });
        let layer = decoded.map_err(|message| Error::bad_input(path, "", message))?;
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

/// Decodes the layer that `choose` selects by the header, at its largest level; half floats and integers stay what they
/// are. The header is checked before memory is allocated for the sizes that it states.
///
/// Errors: that of `choose`; not an EXR, damaged, cut short, subsampled, or of too many values.
pub(crate) fn decode_layer(
    bytes: &[u8],
    choose: impl FnOnce(&MetaData) -> std::result::Result<usize, String>,
) -> std::result::Result<Layer<AnyChannels<FlatSamples>>, String> {
    let meta = MetaData::read_from_buffered(bytes, true)
        .map_err(|error| format!("is not an EXR file whose header can be read ({error})"))?;
    // Each chunk has an entry of 8 bytes in the offset table.
    let chunks = meta.headers.iter().map(|header| header.chunk_count as u64);
    let chunks = chunks.fold(0, u64::saturating_add);
    if chunks.saturating_mul(8) > bytes.len() as u64 {
        return Err(format!(
            "promises {chunks} blocks of pixels and is too short for their addresses: write or copy it again"
        ));
    }
    let chosen = choose(&meta)?;
    let values = meta.headers.iter().map(|header| {
        let pixels = (header.layer_size.0 as u64).saturating_mul(header.layer_size.1 as u64);
        pixels.saturating_mul(header.channels.list.len() as u64)
    });
    if values.fold(0, u64::saturating_add) > MAX_VALUES {
        return Err("has too many pixels in all channels: keep only R, G and B".into());
    }
    let channels = &meta.headers[chosen].channels.list;
    if let Some(channel) = channels.iter().find(|c| c.sampling != Vec2(1, 1)) {
        return Err(format!(
            "its channel {} is subsampled: write it as R, G, B",
            channel.name
        ));
    }
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
    let damaged = |reason: String| format!("cannot be decoded ({reason}): write or copy it again");
    // The decoder may panic on a damaged file; the error is the file's.
    let image = catch_unwind(decode).map_err(|_| damaged("damaged".into()))?;
    let layers = image.map_err(|error| damaged(error.to_string()))?.layer_data;
    layers.into_iter().nth(chosen).ok_or_else(|| "has no layer".into())
}
