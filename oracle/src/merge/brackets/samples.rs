//! Which pixels are asked for the camera's response: the same for the same photographs, spread over
//! the picture and over its brightness.

use super::{Brackets, weight};

/// Candidates a row and a column of the picture.
const LATTICE: usize = 192;
/// Kinds of brightness, and pixels taken of each.
const KINDS: usize = 64;
const OF_EACH: usize = 8;

/// A pixel that two exposures at least show well.
struct Candidate {
    pixel: usize,
    /// Sum of its codes.
    brightness: usize,
    /// How much it differs from its neighbours, in all exposures.
    roughness: u32,
}

/// At most 512 pixels for a channel.
///
/// A pixel's mean code over the exposures grows with its radiance, about as the logarithm does, so
/// equal shares for equal intervals of it bring all codes. Of pixels that lie together the
/// flattest is taken: an edge moves when the camera does.
pub(super) fn choose(brackets: &Brackets, channel: usize) -> Vec<usize> {
    let all = candidates(brackets, channel);
    let brightness = || all.iter().map(|c| c.brightness);
    let (Some(low), Some(high)) = (brightness().min(), brightness().max()) else {
        return Vec::new();
    };
    let kind = |c: &Candidate| (c.brightness - low) * KINDS / (high - low + 1);
    let mut kinds: Vec<Vec<&Candidate>> = vec![Vec::new(); KINDS];
    for candidate in &all {
        kinds[kind(candidate)].push(candidate);
    }
    let mut chosen = Vec::new();
    for members in kinds.iter().filter(|members| !members.is_empty()) {
        // In order of rows, so that each part is a band of the picture.
        for part in members.chunks(members.len().div_ceil(OF_EACH)) {
            let flattest = part.iter().min_by_key(|c| c.roughness);
            chosen.extend(flattest.map(|c| c.pixel));
        }
    }
    chosen
}

fn candidates(brackets: &Brackets, channel: usize) -> Vec<Candidate> {
    let [w, h] = brackets.size();
    let places = |n: usize| {
        let count = n.min(LATTICE);
        (0..count).map(move |k| (2 * k + 1) * n / (2 * count))
    };
    let at = places(h).flat_map(|y| places(w).map(move |x| (x, y)));
    at.filter_map(|(x, y)| {
        let pixel = y * w + x;
        // At the rim the neighbour is the pixel itself.
        let neighbours = [y * w + (x + 1).min(w - 1), (y + 1).min(h - 1) * w + x];
        let mut candidate = Candidate {
            pixel,
            brightness: 0,
            roughness: 0,
        };
        let (mut low, mut high) = (255, 0);
        for exposure in brackets.exposures() {
            let code = exposure.pixels[pixel][channel];
            candidate.brightness += usize::from(code);
            for neighbour in neighbours {
                let other = exposure.pixels[neighbour][channel];
                candidate.roughness += u32::from(code.abs_diff(other));
            }
            if weight(code) > 0.0 {
                (low, high) = (low.min(code), high.max(code));
            }
        }
        (low < high).then_some(candidate)
    })
    .collect()
}
