//! Merges the photographs into a radiance map by eq. 6 of Debevec and Malik: ln E = Σ w (g − ln Δt) / Σ w.

use super::{Brackets, CameraResponse, code_weight};
use glam::Vec3;

/// Numbers of pixels with a channel that no photograph exposes well.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UnseenPixels {
    /// Code 255 in all photographs: the value is the lower bound by the shortest exposure.
    pub saturated: usize,
    /// Code 0 in all photographs: the value is 0.
    pub black: usize,
    /// Code 255 in longer and 0 in shorter exposures: the value is the geometric mean of both bounds.
    pub between: usize,
}

/// Radiance map merged from photographs.
#[derive(Clone, Debug)]
pub struct RadianceMap {
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Relative radiance, row-major from the upper left: finite, not negative.
    pub radiance: Vec<Vec3>,
    /// Numbers of pixels that no photograph exposes well.
    pub unseen: UnseenPixels,
}

impl RadianceMap {
    /// Merges the photographs with a known response.
    pub fn new(brackets: &Brackets, response: &CameraResponse) -> Self {
        let ln_seconds = brackets.ln_seconds();
        let count = brackets.picture_size()[0] * brackets.picture_size()[1];
        let mut merged = Self {
            size: brackets.picture_size(),
            radiance: Vec::with_capacity(count),
            unseen: UnseenPixels::default(),
        };
        let mut codes = Vec::with_capacity(ln_seconds.len());
        for pixel in 0..count {
            codes.clear();
            codes.extend(brackets.photographs().iter().map(|e| e.pixels[pixel]));
            merged.merge_pixel(&codes, &ln_seconds, response);
        }
        merged
    }

    /// Merges and appends a pixel.
    fn merge_pixel(&mut self, codes: &[[u8; 3]], ln_seconds: &[f64], response: &CameraResponse) {
        let mut unseen = UnseenPixels::default();
        let mut radiance = Vec3::ZERO;
        for (c, curve) in response.curves.iter().enumerate() {
            if let Some(ln) = merge_channel(codes, ln_seconds, c, curve, &mut unseen) {
                radiance[c] = ln.exp().min(f64::from(f32::MAX)) as f32;
            }
        }
        self.radiance.push(radiance);
        self.unseen.saturated += unseen.saturated.min(1);
        self.unseen.black += unseen.black.min(1);
        self.unseen.between += unseen.between.min(1);
    }
}

/// Returns ln E of one channel of a pixel, none where it is black; counts a channel that no photograph exposes well.
fn merge_channel(
    codes: &[[u8; 3]],
    ln_seconds: &[f64],
    channel: usize,
    curve: &[f64; 256],
    unseen: &mut UnseenPixels,
) -> Option<f64> {
    let (mut sum, mut whole) = (0.0, 0.0);
    // ln E by the shortest saturated and by the longest black exposure: its bounds.
    let (mut above, mut below) = (None, None);
    for (codes, ln_seconds) in codes.iter().zip(ln_seconds) {
        let code = codes[channel];
        let weight = code_weight(code);
        let ln = curve[usize::from(code)] - ln_seconds;
        sum += weight * ln;
        whole += weight;
        match code {
            255 => above = Some(ln),
            0 => below = below.or(Some(ln)),
            _ => {}
        }
    }
    if whole > 0.0 {
        return Some(sum / whole);
    }
    match (above, below) {
        (Some(_), None) => unseen.saturated += 1,
        (Some(_), Some(_)) => unseen.between += 1,
        (None, _) => unseen.black += 1,
    }
    above.map(|above| below.map_or(above, |below| 0.5 * (above + below)))
}
