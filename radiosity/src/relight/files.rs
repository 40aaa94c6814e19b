//! Encodes `composite.exr`, `background.exr` and `composite.png`.

use super::composite::Composite;
use crate::report::picture::{EXPOSURE_PERCENTILE, Exposure, RgbaPicture, encode_srgb};
use common::Result;
use common::solution::pending::NamedBytes;
use common::solution::write::encode_exr_fast;
use glam::Vec3;
use rayon::prelude::*;

/// Encodes `background.exr` and `composite.exr`.
///
/// Errors: those of [`encode_exr_fast`].
pub fn encode_radiance(composite: &Composite) -> Result<Vec<NamedBytes>> {
    let [behind, any] = &composite.coverage;
    let exrs = [
        ("background.exr", &composite.background, behind),
        ("composite.exr", &composite.composite, any),
    ];
    let encoded = exrs.par_iter().map(|(name, colours, coverage)| {
        let bytes = encode_picture(composite.size, colours, coverage)?;
        Ok(((*name).to_owned(), bytes))
    });
    encoded.collect()
}

/// Encodes `composite.png`.
pub fn encode_composite(composite: &Composite, exposure: Exposure) -> Vec<u8> {
    tone_map_picture(composite.size, &composite.composite, &composite.coverage[1], exposure).encode_png()
}

/// Encodes colours as EXR; with channel A (colours premultiplied) only where some pixel is transparent.
///
/// Errors: those of [`encode_exr_fast`].
pub fn encode_picture(size: [u32; 2], colours: &[Vec3], coverage: &[f32]) -> Result<Vec<u8>> {
    let mut planes: Vec<(String, Vec<f32>)> = ["R", "G", "B"]
        .into_iter()
        .enumerate()
        .map(|(c, name)| (name.into(), colours.iter().map(|colour| colour[c]).collect()))
        .collect();
    if coverage.iter().any(|share| *share < 1.0) {
        planes.push(("A".into(), coverage.to_vec()));
    }
    encode_exr_fast(size, planes)
}

/// Chooses one exposure for background and composite: the 90th percentile of both, without emitters, is at 80 % of
/// white (W/m²/sr).
pub fn choose_exposure(composite: &Composite) -> Exposure {
    let colours = [&composite.background, &composite.composite];
    let pairs = colours.into_iter().zip(&composite.dark);
    let values = pairs.flat_map(|(colours, dark)| {
        let values = colours.iter().zip(dark);
        values.map(|(colour, share)| (colour.max_element(), *share))
    });
    Exposure::from_percentile(values, EXPOSURE_PERCENTILE)
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
