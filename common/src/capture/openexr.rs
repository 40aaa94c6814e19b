//! Decodes OpenEXR maps with the crate `exr`: all its compressions, scanlines and tiles. [`super::panorama`] reads
//! files by it.
//!
//! Rules: the map is the display window, with 0 outside the data window; the largest level of a mip map; the first
//! layer with R, G and B, or with `name.R`, `name.G` and `name.B`, else the first with Y alone (grey). Deep pixels
//! and subsampled chroma are refused. Other primaries than Rec. 709 are converted.

use super::colour::{Primaries, REC709_PRIMARIES, convert_pixels};
use super::{DecodedMap, MapProjection, check_size};
use crate::solution::pixels::decode_layer;
use exr::meta::MetaData;
use exr::meta::attribute::EnvironmentMap;
use exr::meta::header::Header;
use exr::prelude::Vec2;
use glam::{DVec2, Vec3};

/// Decodes a whole file.
pub(super) fn decode_bytes(bytes: &[u8]) -> Result<DecodedMap, String> {
    let mut chosen = None;
    let layer = decode_layer(bytes, |meta| {
        let (k, names) = choose_layer(meta)?;
        let header = &meta.headers[k];
        let (Vec2(w, h), display) = (header.layer_size, header.shared_attributes.display_window);
        check_size(w as u64, h as u64)?;
        check_size(display.size.0 as u64, display.size.1 as u64)?;
        chosen = Some((header.clone(), names));
        Ok(k)
    })?;
    let (header, names) = chosen.ok_or("has no layer")?;
    let (Vec2(w, h), display) = (header.layer_size, header.shared_attributes.display_window);
    let size = [display.size.0, display.size.1];
    let (data, origin) = (header.own_attributes.layer_position, display.position);
    let offset = [(data.0, origin.0), (data.1, origin.1)].map(|(a, b)| i64::from(a) - i64::from(b));
    let mut notes = Vec::new();
    if names.len() == 1 {
        notes.push(format!("has luminance only (channel {}): grey", names[0]));
    } else if names[0] != "R" {
        notes.push(format!("its channels {} were read", names.join(", ")));
    }
    if [w, h] != size || offset != [0, 0] {
        notes.push(format!(
            "its data window of {w}×{h} pixels lies at {}, {} of its display window of {}×{}, which is the map: 0 outside",
            offset[0], offset[1], size[0], size[1]
        ));
    }
    let mut pixels = vec![Vec3::ZERO; size[0] * size[1]];
    for channel in layer.channel_data.list {
        let name = channel.name.to_string();
        for c in (0..3).filter(|c| *names.get(*c).unwrap_or(&names[0]) == name) {
            for (k, value) in channel.sample_data.values_as_f32().enumerate() {
                let place = [(k % w) as i64 + offset[0], (k / w) as i64 + offset[1]].map(usize::try_from);
                if let [Ok(x), Ok(y)] = place
                    && x < size[0]
                    && y < size[1]
                {
                    pixels[y * size[0] + x][c] = value;
                }
            }
        }
    }
    if let Some(primaries) = other_primaries(&header) {
        notes.push(match convert_pixels(primaries, &mut pixels) {
            true => "its primaries were converted to Rec. 709".into(),
            false => "its primaries make no colour space: Rec. 709 is assumed".into(),
        });
    }
    Ok(DecodedMap {
        size,
        pixels,
        projection: header.own_attributes.environment_map.map(|map| match map {
            EnvironmentMap::LatitudeLongitude => MapProjection::LatLong,
            EnvironmentMap::Cube => MapProjection::Cube,
        }),
        notes,
    })
}

/// Returns the file's primaries, unless they are those of Rec. 709 to the three digits in which files write them.
fn other_primaries(header: &Header) -> Option<Primaries> {
    let c = header.shared_attributes.chromaticities?;
    let primaries = [c.red, c.green, c.blue, c.white].map(|v| DVec2::new(f64::from(v.0), f64::from(v.1)));
    let differ = (0..4).any(|k| (primaries[k] - REC709_PRIMARIES[k]).length() >= 1e-3);
    differ.then_some(primaries)
}

/// Chooses the first layer with colours, or else the first with luminance; returns its index and its channels' names.
fn choose_layer(meta: &MetaData) -> Result<(usize, Vec<String>), String> {
    let flat = || meta.headers.iter().enumerate().filter(|(_, header)| !header.deep);
    let layer = flat()
        .find_map(|(k, header)| Some((k, colour_channels(header)?)))
        .or_else(|| flat().find_map(|(k, header)| Some((k, vec![luminance_channel(header)?]))));
    let Some((layer, channels)) = layer else {
        return Err(match meta.headers.iter().any(|header| header.deep) {
            true => "holds deep pixels: flatten it".into(),
            false => "has neither channels R, G, B nor Y: a radiance map is needed".into(),
        });
    };
    let list = &meta.headers[layer].channels.list;
    let has = |name: &str| list.iter().any(|c| c.name.to_string() == name);
    if channels.len() == 1 && (has("RY") || has("BY")) {
        return Err("holds luminance and chroma (Y, RY, BY): write it as R, G, B".into());
    }
    Ok((layer, channels))
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
