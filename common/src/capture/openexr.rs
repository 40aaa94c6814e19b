//! Decodes OpenEXR maps with the crate `exr`: all its compressions, scanlines and tiles.
//!
//! Rules: the map is the display window, with 0 outside the data window; the largest
//! level of a mip map; the first layer with R, G and B, or with `name.R`, `name.G` and `name.B`,
//! else the first with Y alone (grey). Deep pixels and subsampled chroma are refused. Other
//! primaries than Rec. 709 are converted. The header is checked against the file's length before
//! memory is allocated for the sizes that it states.

use super::colour::Primaries;
use super::{DecodeFailure, DecodedMap, MapProjection, check_size};
use exr::meta::MetaData;
use exr::meta::attribute::EnvironmentMap;
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel, Vec2, read};
use glam::{DVec2, Vec3};
use std::io::Cursor;
use std::panic::catch_unwind;

/// Tests for OpenEXR's magic number at the start of `bytes`.
pub(super) fn is_openexr(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01])
}

/// Decodes a whole file.
pub(super) fn decode_bytes(bytes: &[u8]) -> Result<DecodedMap, DecodeFailure> {
    // The decoder uses indices of a damaged file unchecked; its panics are reported as damage.
    catch_unwind(|| {
        let plan = LayerPlan::new(bytes)?;
        let mut pixels = plan.decode_pixels(bytes)?;
        let mut notes = plan.notes;
        if let Some(primaries) = plan.primaries {
            notes.push(match primaries.convert_pixels(&mut pixels) {
                true => "its primaries were converted to Rec. 709".into(),
                false => "its primaries make no colour space: Rec. 709 is assumed".into(),
            });
        }
        Ok(DecodedMap {
            size: plan.frame.size,
            pixels,
            projection: plan.projection,
            notes,
        })
    })
    .unwrap_or_else(|_| Err("is damaged: write or copy it again".into()))
}

/// Position of the data window in the display window.
#[derive(Clone, Copy)]
struct Frame {
    /// The display window's width and height.
    size: [usize; 2],
    /// The data window's upper left corner in it.
    offset: [i64; 2],
}

impl Frame {
    /// Returns the map's index of a pixel of the data window, if it lies in the display window.
    fn index(self, at: Vec2<usize>) -> Option<usize> {
        let place = |at: usize, axis: usize| {
            let place = usize::try_from(at as i64 + self.offset[axis]).ok()?;
            (place < self.size[axis]).then_some(place)
        };
        Some(place(at.1, 1)? * self.size[0] + place(at.0, 0)?)
    }
}

/// The part of a file to read: a layer's channels and their place in the map.
struct LayerPlan {
    frame: Frame,
    /// Names of three channels (R, G, B) or of one (luminance).
    channels: Vec<String>,
    projection: Option<MapProjection>,
    /// The file's primaries; `None` for Rec. 709.
    primaries: Option<Primaries>,
    notes: Vec<String>,
}

impl LayerPlan {
    fn new(bytes: &[u8]) -> Result<Self, DecodeFailure> {
        let meta = MetaData::read_from_buffered(bytes, true)
            .map_err(|error| format!("has no header that can be read ({error})"))?;
        // Each chunk has an entry of 8 bytes in the offset table.
        let chunks = |h: &Header| h.chunk_count as u64;
        let chunks = meta.headers.iter().map(chunks).fold(0, u64::saturating_add);
        if chunks.saturating_mul(8) > bytes.len() as u64 {
            return Err(format!(
                "promises {chunks} blocks of pixels and is too short for their addresses: write or copy it again"
            )
            .into());
        }
        let (header, channels) = choose_layer(&meta)?;
        let frame = frame_of_header(header)?;
        let mut notes = Vec::new();
        if channels.len() == 1 {
            notes.push(format!("has luminance only (channel {}): grey", channels[0]));
        } else if channels[0] != "R" {
            notes.push(format!("its channels {} were read", channels.join(", ")));
        }
        let Vec2(w, h) = header.layer_size;
        if [w, h] != frame.size || frame.offset != [0, 0] {
            notes.push(format!(
                "its data window of {w}×{h} pixels lies at {}, {} of its display window of {}×{}, which is the map: 0 outside",
                frame.offset[0], frame.offset[1], frame.size[0], frame.size[1]
            ));
        }
        let vector = |v: Vec2<f32>| DVec2::new(f64::from(v.0), f64::from(v.1));
        let primaries = header
            .shared_attributes
            .chromaticities
            .map(|c| Primaries([c.red, c.green, c.blue, c.white].map(vector)));
        Ok(Self {
            frame,
            channels,
            projection: header.own_attributes.environment_map.map(|map| match map {
                EnvironmentMap::LatitudeLongitude => MapProjection::LatLong,
                EnvironmentMap::Cube => MapProjection::Cube,
            }),
            primaries: primaries.filter(|p| !p.are_rec709()),
            notes,
        })
    }

    /// Decodes the pixels of the display window.
    ///
    /// Decoding runs on this thread: in the decoder's own pool a panic over a damaged block would end
    /// the program. It is pedantic: a file that was cut short is an error, not a map with a black part.
    fn decode_pixels(&self, bytes: &[u8]) -> Result<Vec<Vec3>, DecodeFailure> {
        let frame = self.frame;
        let length = frame.size[0] * frame.size[1];
        let put = move |pixels: &mut Vec<[f32; 3]>, at: Vec2<usize>, value: [f32; 3]| {
            if let Some(pixel) = frame.index(at).and_then(|index| pixels.get_mut(index)) {
                *pixel = value;
            }
        };
        let start = read().no_deep_data().largest_resolution_level();
        let pixels = match &self.channels[..] {
            [r, g, b] => start
                .specific_channels()
                .required(r.as_str())
                .required(g.as_str())
                .required(b.as_str())
                .collect_pixels(
                    move |_, _| vec![[0_f32; 3]; length],
                    move |pixels, at, (r, g, b): (f32, f32, f32)| put(pixels, at, [r, g, b]),
                )
                .first_valid_layer()
                .all_attributes()
                .pedantic()
                .non_parallel()
                .from_buffered(Cursor::new(bytes))
                .map(|image| image.layer_data.channel_data.pixels),
            [y, ..] => start
                .specific_channels()
                .required(y.as_str())
                .collect_pixels(
                    move |_, _| vec![[0_f32; 3]; length],
                    move |pixels, at, (y,): (f32,)| put(pixels, at, [y; 3]),
                )
                .first_valid_layer()
                .all_attributes()
                .pedantic()
                .non_parallel()
                .from_buffered(Cursor::new(bytes))
                .map(|image| image.layer_data.channel_data.pixels),
            [] => return Err("has no channels".into()),
        };
        let pixels = pixels.map_err(|error| format!("cannot be decoded ({error}): write or copy it again"))?;
        Ok(pixels.into_iter().map(Vec3::from).collect())
    }
}

/// Chooses the first layer with colours, or else the first with luminance; returns its channels' names too.
fn choose_layer(meta: &MetaData) -> Result<(&Header, Vec<String>), String> {
    let flat = || meta.headers.iter().filter(|header| !header.deep);
    let layer = flat()
        .find_map(|header| Some((header, colour_channels(header)?)))
        .or_else(|| flat().find_map(|header| Some((header, vec![luminance_channel(header)?]))));
    let Some((header, channels)) = layer else {
        return Err(match meta.headers.iter().any(|header| header.deep) {
            true => "holds deep pixels: flatten it".into(),
            false => "has neither channels R, G, B nor Y: a radiance map is needed".into(),
        });
    };
    let list = &header.channels.list;
    if let Some(channel) = list.iter().find(|c| c.sampling != Vec2(1, 1)) {
        return Err(format!(
            "its channel {} is subsampled (luminance and chroma): write it as R, G, B",
            channel.name
        ));
    }
    let has = |name: &str| list.iter().any(|c| c.name.to_string() == name);
    if channels.len() == 1 && (has("RY") || has("BY")) {
        return Err("holds luminance and chroma (Y, RY, BY): write it as R, G, B".into());
    }
    Ok((header, channels))
}

/// Returns the names R, G and B, or the first three such names with a common prefix.
fn colour_channels(header: &Header) -> Option<Vec<String>> {
    let names: Vec<String> = header.channels.list.iter().map(|c| c.name.to_string()).collect();
    let prefixes = names
        .iter()
        .filter_map(|name| name.strip_suffix(".R").map(|p| format!("{p}.")));
    std::iter::once(String::new())
        .chain(prefixes)
        .map(|prefix| ["R", "G", "B"].map(|letter| format!("{prefix}{letter}")))
        .find(|three| three.iter().all(|name| names.contains(name)))
        .map(|three| three.to_vec())
}

fn luminance_channel(header: &Header) -> Option<String> {
    let names = header.channels.list.iter().map(|c| c.name.to_string());
    names.into_iter().find(|name| name == "Y" || name.ends_with(".Y"))
}

fn frame_of_header(header: &Header) -> Result<Frame, String> {
    let Vec2(w, h) = header.layer_size;
    check_size(w as u64, h as u64)?;
    let display = header.shared_attributes.display_window;
    let size = [display.size.0, display.size.1];
    check_size(size[0] as u64, size[1] as u64)?;
    let (data, origin) = (header.own_attributes.layer_position, display.position);
    Ok(Frame {
        size,
        offset: [
            i64::from(data.0) - i64::from(origin.0),
            i64::from(data.1) - i64::from(origin.1),
        ],
    })
}
