//! Selects the pixels that determine the camera's response, deterministically, spread over the picture and over
//! brightness.

use super::{Brackets, code_weight};

/// Maximum candidates per row and per column of the picture.
const CANDIDATES_PER_SIDE: usize = 192;
/// Number of brightness bins.
const BRIGHTNESS_BINS: usize = 64;
/// Maximum number of pixels selected per bin.
const PIXELS_PER_BIN: usize = 8;

/// Pixel that at least two photographs expose well.
struct Candidate {
    pixel: usize,
    /// Sum of the pixel's codes.
    brightness: usize,
    /// Sum of absolute code differences from two neighbours, in all photographs.
    roughness: u32,
}

/// Selects at most 512 pixels for a channel.
///
/// A pixel's mean code grows about logarithmically with radiance, so equal numbers per interval of it cover all codes.
/// Of pixels close together the one in the flattest surroundings is taken: edges suffer from camera motion.
pub(super) fn choose_pixels(brackets: &Brackets, channel: usize) -> Vec<usize> {
    let all = candidate_pixels(brackets, channel);
    let brightness = || all.iter().map(|c| c.brightness);
    let (Some(low), Some(high)) = (brightness().min(), brightness().max()) else {
        return Vec::new();
    };
    let kind = |c: &Candidate| (c.brightness - low) * BRIGHTNESS_BINS / (high - low + 1);
    let mut kinds: Vec<Vec<&Candidate>> = vec![Vec::new(); BRIGHTNESS_BINS];
    for candidate in &all {
        kinds[kind(candidate)].push(candidate);
    }
    let mut chosen = Vec::new();
    for members in kinds.iter().filter(|members| !members.is_empty()) {
        // The members are in row order, so each part is a band of the picture.
        for part in members.chunks(members.len().div_ceil(PIXELS_PER_BIN)) {
            let flattest = part.iter().min_by_key(|c| c.roughness);
            chosen.extend(flattest.map(|c| c.pixel));
        }
    }
    chosen
}

/// Returns the well-exposed pixels of a regular lattice, in row order.
fn candidate_pixels(brackets: &Brackets, channel: usize) -> Vec<Candidate> {
    let [w, h] = brackets.picture_size();
    let places = |n: usize| {
        let count = n.min(CANDIDATES_PER_SIDE);
        (0..count).map(move |k| (2 * k + 1) * n / (2 * count))
    };
    let at = places(h).flat_map(|y| places(w).map(move |x| (x, y)));
    at.filter_map(|(x, y)| {
        let pixel = y * w + x;
        // At the rim a pixel is its own neighbour.
        let neighbours = [y * w + (x + 1).min(w - 1), (y + 1).min(h - 1) * w + x];
        let mut candidate = Candidate {
            pixel,
            brightness: 0,
            roughness: 0,
        };
        let (mut low, mut high) = (255, 0);
        for exposure in brackets.photographs() {
            let code = exposure.pixels[pixel][channel];
            candidate.brightness += usize::from(code);
            for neighbour in neighbours {
                let other = exposure.pixels[neighbour][channel];
                candidate.roughness += u32::from(code.abs_diff(other));
            }
            if code_weight(code) > 0.0 {
                (low, high) = (low.min(code), high.max(code));
            }
        }
        (low < high).then_some(candidate)
    })
    .collect()
}
