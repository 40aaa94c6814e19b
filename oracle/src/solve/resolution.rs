//! Resolutions of the steps of an adaptive solve: texels per side of each face.

use super::adjacency::{limit_texel_widths, longest_side};
use super::regather::estimate::descending_order;
use common::Result;
use common::mesh::Mesh;
use common::resample::{area_average, shared_pieces};
use common::scene::{Face, Scene};
use glam::DVec3;

/// Width of the first step's texels, if that is cheap; the mesh is at most two units wide. Larger texels
/// would be few, and two steps on a few texels may agree by chance.
const FIRST_TEXEL_WIDTH: f64 = 0.25;
/// Texels across the smaller of two faces with a narrow gap between; half as many along the contact edge of a
/// sheet.
const TEXELS_ACROSS_GAP: f64 = 8.0;
/// Smallest width of a texel at a gap or sheet, as a share of the first step's width. In a mesh of many faces
/// most have a neighbour in front of them.
const MIN_WIDTH_SHARE: f64 = 0.0625;
/// Number of texels that is cheap to solve.
const CHEAP_TEXELS: u64 = 1 << 15;
/// Largest number of texels per side of a face, where they follow from the light.
pub const MAX_TEXELS_PER_SIDE: u32 = 64;

/// Requested texels per side of a face; `None`: they follow from the light.
pub type RequestedTexels<'a> = &'a dyn Fn(usize) -> Option<u32>;

/// Width of the first step's texels, in the scene's unit.
pub fn first_texel_width(scene: &Scene) -> Result<f64> {
    let whole = 2.0 * Mesh::uniform(scene, 1, 1)?.unit;
    let mut width = FIRST_TEXEL_WIDTH * whole / 2.0;
    while width < whole && count_texels(&limit_width(scene, width, |_| 1)) > CHEAP_TEXELS {
        width *= 2.0;
    }
    Ok(width)
}

/// Texels per side to solve on where `requested` are requested: those, or, if a tree of them would have nodes of
/// many children, a larger power of two, over which the result takes means. Then both of the first two steps
/// are finer than the result, so their difference includes the error of the resampling.
pub fn solved_texels(requested: u32) -> u32 {
    let mut rest = requested;
    for factor in [2, 3, 5, 7] {
        while rest > 1 && rest.is_multiple_of(factor) {
            rest /= factor;
        }
    }
    if rest == 1 {
        requested
    } else {
        let next = requested.checked_next_power_of_two();
        next.map_or(u32::MAX, |next| next.saturating_mul(2))
    }
}

/// Texels per side of the first step: half the requested number, more where they would be wide.
pub fn choose_first(scene: &Scene, requested: RequestedTexels, width: f64) -> Vec<u32> {
    let least = |f: usize| match requested(f).map(solved_texels) {
        Some(n) if n.is_multiple_of(2) => n / 2,
        Some(n) => n,
        None => 1,
    };
    refine_in_gaps(
        scene,
        limit_width(scene, width, least),
        (TEXELS_ACROSS_GAP, MIN_WIDTH_SHARE * width),
    )
}

/// Texels per side of the second step: at least the requested number, and more than in the first.
pub fn choose_second(scene: &Scene, requested: RequestedTexels, width: f64, first: &[u32]) -> Vec<u32> {
    let least = |f: usize| match requested(f).map(solved_texels) {
        Some(n) if first[f] < n || (first[f] == n && n % 2 == 1 && n > 1) => 2 * first[f],
        _ => first[f],
    };
    let finer = (2.0 * TEXELS_ACROSS_GAP, 0.5 * MIN_WIDTH_SHARE * width);
    refine_in_gaps(scene, limit_width(scene, 0.5 * width, least), finer)
}

/// Texels per side of each face: `least`, doubled until none is wider than `width`.
fn limit_width(scene: &Scene, width: f64, least: impl Fn(usize) -> u32) -> Vec<u32> {
    let side = |(f, face): (usize, &Face)| {
        let mut side = least(f).max(1);
        while f64::from(side) * width < longest_side(face) && side < MAX_TEXELS_PER_SIDE {
            side *= 2;
        }
        side
    };
    scene.faces.iter().enumerate().map(side).collect()
}

/// Refines `sides` at narrow gaps, which texels that reach out of the gap would light, and at the contact
/// edges of sheets, as far as that is cheap.
fn refine_in_gaps(scene: &Scene, sides: Vec<u32>, wanted: (f64, f64)) -> Vec<u32> {
    let mut widths = vec![f64::INFINITY; sides.len()];
    limit_texel_widths(&scene.faces, &sides, wanted, |f, width| {
        widths[f] = widths[f].min(width);
    });
    let limit = CHEAP_TEXELS.max(2 * count_texels(&sides));
    let mut wider = 1.0;
    loop {
        let mut finer = sides.clone();
        for ((face, side), width) in scene.faces.iter().zip(&mut finer).zip(&widths) {
            while f64::from(*side) * width * wider < longest_side(face) && *side < MAX_TEXELS_PER_SIDE {
                *side *= 2;
            }
        }
        if count_texels(&finer) <= limit {
            return finer;
        }
        wider *= 2.0;
    }
}

/// Number of all texels; triangles have as many as quads.
pub fn count_texels(sides: &[u32]) -> u64 {
    sides.iter().map(|side| u64::from(*side).pow(2)).sum()
}

/// Halves the texels of the faces with the largest `squares`, until the squares of the others sum to at most
/// `remaining`.
pub fn halve_largest(
    sides: &[u32],
    squares: &[f64],
    remaining: f64,
    may_refine: impl Fn(usize, u32) -> bool,
) -> Vec<u32> {
    let mut sides = sides.to_vec();
    let mut rest: f64 = squares.iter().sum();
    for f in descending_order(squares) {
        if rest <= remaining {
            break;
        }
        let side = &mut sides[f as usize];
        if may_refine(f as usize, *side) {
            *side *= 2;
        }
        rest -= squares[f as usize];
    }
    sides
}

/// Returns N×N for each N, the form that a mesh takes.
pub fn square_resolutions(sides: &[u32]) -> Vec<[u32; 2]> {
    sides.iter().map(|side| [*side; 2]).collect()
}

/// Resamples values of a face's texels from `from` to `to` texels per side: means over areas.
pub fn resample_face(values: &[DVec3], face: &Face, from: u32, to: u32) -> Vec<DVec3> {
    if from == to {
        return values.to_vec();
    }
    area_average(values, &shared_pieces(face, [from; 2], [to; 2]), [to; 2])
}

#[cfg(test)]
mod tests {
    use super::solved_texels;

    #[test]
    fn solved_texels_have_only_small_factors() {
        for requested in [1, 7, 8, 10, 24, 90, 100, 512] {
            assert_eq!(solved_texels(requested), requested);
        }
        for (requested, solved) in [(11, 32), (29, 64), (58, 128), (1021, 2048)] {
            assert_eq!(solved_texels(requested), solved);
        }
    }
}
