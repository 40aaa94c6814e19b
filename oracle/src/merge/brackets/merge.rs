//! The photographs as one radiance map, eq. 6 of Debevec and Malik: ln E = Σ w (g − ln Δt) / Σ w.

use super::{Brackets, Response, weight};
use glam::Vec3;

/// Pixels of which a channel is well exposed in no photograph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unseen {
    /// Code 255 in all: given what 255 means in the shortest exposure, of which it has at least
    /// as much.
    pub saturated: usize,
    /// Code 0 in all: 0.
    pub black: usize,
    /// 255 in the longer and 0 in the shorter exposures: the geometric mean of what both allow.
    pub between: usize,
}

/// A radiance map.
#[derive(Clone, Debug)]
pub struct Merged {
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Relative radiance, row by row from the upper left: finite, not negative.
    pub radiance: Vec<Vec3>,
    /// The exposure that weighs most in a pixel, over all channels; none where none has a weight.
    pub relied: Vec<Option<u32>>,
    /// What no photograph shows.
    pub unseen: Unseen,
}

/// What the photographs say of one value.
enum Value {
    /// ln E.
    Seen(f64),
    Saturated(f64),
    Black,
    Between(f64),
}

impl Merged {
    /// Merges with a known response.
    pub fn new(brackets: &Brackets, response: &Response) -> Self {
        let ln_seconds = brackets.ln_seconds();
        let count = brackets.size()[0] * brackets.size()[1];
        let mut merged = Self {
            size: brackets.size(),
            radiance: Vec::with_capacity(count),
            relied: Vec::with_capacity(count),
            unseen: Unseen::default(),
        };
        let mut codes = Vec::with_capacity(ln_seconds.len());
        for pixel in 0..count {
            codes.clear();
            codes.extend(brackets.exposures().iter().map(|e| e.pixels[pixel]));
            merged.pixel(&codes, &ln_seconds, response);
        }
        merged
    }

    fn pixel(&mut self, codes: &[[u8; 3]], ln_seconds: &[f64], response: &Response) {
        let mut kinds = [false; 3];
        let mut radiance = Vec3::ZERO;
        for (c, curve) in response.curves.iter().enumerate() {
            let ln = match value(codes, ln_seconds, c, curve) {
                Value::Seen(ln) => ln,
                Value::Saturated(ln) => {
                    kinds[0] = true;
                    ln
                }
                Value::Black => {
                    kinds[1] = true;
                    continue;
                }
                Value::Between(ln) => {
                    kinds[2] = true;
                    ln
                }
            };
            radiance[c] = ln.exp().min(f64::from(f32::MAX)) as f32;
        }
        self.radiance.push(radiance);
        self.unseen.saturated += usize::from(kinds[0]);
        self.unseen.black += usize::from(kinds[1]);
        self.unseen.between += usize::from(kinds[2]);
        let sure = |codes: &[u8; 3]| codes.iter().map(|z| weight(*z)).sum::<f64>() as u32;
        let weights = codes.iter().map(sure);
        let best = weights
            .zip(0_u32..)
            .max_by_key(|(weight, k)| (*weight, u32::MAX - k));
        self.relied
            .push(best.filter(|(weight, _)| *weight > 0).map(|(_, k)| k));
    }
}

fn value(codes: &[[u8; 3]], ln_seconds: &[f64], channel: usize, curve: &[f64; 256]) -> Value {
    let (mut sum, mut whole) = (0.0, 0.0);
    // The shortest exposure that is saturated, and the longest that is black: bounds of ln E.
    let (mut above, mut below) = (None, None);
    for (codes, ln_seconds) in codes.iter().zip(ln_seconds) {
        let code = codes[channel];
        let weight = weight(code);
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
        return Value::Seen(sum / whole);
    }
    match (above, below) {
        (Some(above), None) => Value::Saturated(above),
        (Some(above), Some(below)) => Value::Between(0.5 * (above + below)),
        (None, _) => Value::Black,
    }
}
