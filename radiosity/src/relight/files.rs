//! Writes `composite.exr`, `background.exr` and `composite.png`.

use super::composite::Composite;
use crate::report::picture::{Exposure, RgbaPicture, encode_srgb};
use common::solution::write_file;
use common::{Error, Result};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, Vec2, WritableImage,
};
use glam::Vec3;
use rayon::prelude::*;
use std::path::Path;

/// Comment attribute of the EXR files.
const EXR_COMMENT: &str = "R G B: radiance in W/m2/sr, linear Rec. 709";

/// Writes the three files into `dir`, each atomically.
///
/// Errors: a file cannot be written.
pub fn write_pictures(dir: &Path, composite: &Composite, exposure: Exposure) -> Result<()> {
    let [behind, any] = &composite.coverage;
    let exrs = [
        ("background.exr", &composite.background, behind),
        ("composite.exr", &composite.composite, any),
    ];
    let exrs = || {
        exrs.par_iter().try_for_each(|(name, colours, coverage)| {
            write_exr(&dir.join(name), composite.size, colours, coverage, EXR_COMMENT)
        })
    };
    let png = || tone_map_picture(composite.size, &composite.composite, any, exposure).encode_png();
    let (written, png) = rayon::join(exrs, png);
    written?;
    write_file(&dir.join("composite.png"), &png)
}

/// Writes an EXR file of 32-bit floats, lossless and atomically; with channel A (colours premultiplied) only where
/// some pixel is transparent. `comment` describes the channels.
///
/// Errors: the file cannot be written.
pub fn write_exr(path: &Path, size: [u32; 2], colours: &[Vec3], coverage: &[f32], comment: &str) -> Result<()> {
    let bytes = encode_exr(size, colours, coverage, comment).map_err(|error| Error::Write {
        path: path.to_path_buf(),
        source: std::io::Error::other(error),
    })?;
    write_file(path, &bytes)
}

/// Encodes an EXR file.
fn encode_exr(
    [w, h]: [u32; 2],
    colours: &[Vec3],
    coverage: &[f32],
    comment: &str,
) -> std::result::Result<Vec<u8>, String> {
    if w == 0 || h == 0 {
        return Err("a picture without pixels".into());
    }
    let plane = |name: &str, values: Vec<f32>| AnyChannel::new(name, FlatSamples::F32(values));
    let mut channels: Vec<_> = ["R", "G", "B"]
        .into_iter()
        .enumerate()
        .map(|(c, name)| plane(name, colours.iter().map(|v| v[c]).collect()))
        .collect();
    if coverage.iter().any(|share| *share < 1.0) {
        channels.push(plane("A", coverage.to_vec()));
    }
    let attributes = LayerAttributes {
        comments: Some(comment.into()),
        ..LayerAttributes::default()
    };
    let layer = Layer::new(
        Vec2(w as usize, h as usize),
        attributes,
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels.into_iter().collect()),
    );
    let mut bytes = std::io::Cursor::new(Vec::new());
    let written = Image::from_layer(layer).write().to_buffered(&mut bytes);
    written.map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

/// Chooses one exposure for background and composite: the 90th percentile of both, without emitters, is at 80 % of
/// white (W/m²/sr).
pub fn choose_exposure(composite: &Composite) -> Exposure {
    let colours = [&composite.background, &composite.composite];
    let pairs = colours.into_iter().zip(&composite.dark);
    Exposure::from_percentile(pairs.flat_map(|(colours, dark)| {
        let values = colours.iter().zip(dark);
        values.map(|(colour, share)| (colour.max_element(), *share))
    }))
}

/// Converts premultiplied radiances to an sRGB picture at an exposure.
pub fn tone_map_picture([w, h]: [u32; 2], colours: &[Vec3], coverage: &[f32], exposure: Exposure) -> RgbaPicture {
    let pixels = colours.iter().zip(coverage).flat_map(|(colour, share)| {
        let whole = if *share > 0.0 { *colour / *share } else { Vec3::ZERO };
        let [r, g, b] = encode_srgb(exposure.display_light(whole));
        [r, g, b, (share.clamp(0.0, 1.0) * 255.0).round() as u8]
    });
    RgbaPicture {
        width: w,
        height: h,
        rgba: pixels.collect(),
    }
}
