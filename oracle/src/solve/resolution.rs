//! Resolutions of the steps of an adaptive solve: texels W×H of each face, more along a side that is much longer.

use super::adjacency::limit_texel_widths;
use super::regather::estimate::descending_order;
use common::Result;
use common::mesh::Mesh;
use common::resample::{area_average, halve_even, shared_pieces};
use common::scene::{Face, Scene};
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Width of the first step's texels as a share of half the extent, if that is cheap. Larger texels would be few, and two
/// steps on a few texels may agree by chance.
const FIRST_TEXEL_WIDTH: f64 = 0.25;
/// Texels across the smaller of two faces with a narrow gap between; half as many along the contact edge of a
/// sheet.
const TEXELS_ACROSS_GAP: f64 = 8.0;
/// Smallest width of a texel at a gap or sheet, as a share of the first step's width. In a mesh of many faces
/// most have a neighbour in front of them.
const MIN_WIDTH_SHARE: f64 = 0.0625;
/// Number of texels that is cheap to solve.
const CHEAP_TEXELS: u64 = 1 << 15;
/// Largest growth of a face's number of texels in one step: what is known of smaller ones is a guess.
const MAX_GROWTH: u64 = 16;
/// Number of texels of a face from which on they are not made narrower.
const MAX_FACE_TEXELS: u64 = 64 * 64;

/// Requested texels W×H of a face; `None`: they follow from the light.
pub type RequestedTexels<'a> = &'a dyn Fn(usize) -> Option<[u32; 2]>;

/// Width of the first step's texels, in the scene's unit: a share of the scene's extent, or in a corridor of a few times
/// its width.
pub fn first_texel_width(scene: &Scene) -> Result<f64> {
    let mut whole = 2.0 * Mesh::uniform(scene, 1, 1)?.unit;
    let [low, high] = scene.bounds();
    let mut extents = (high - low).to_array();
    extents.sort_by(f64::total_cmp);
    while whole > 4.0 * extents[1] && extents[1] > 0.0 {
        whole /= 2.0;
    }
    let mut width = FIRST_TEXEL_WIDTH * whole / 2.0;
    while width < whole && count_texels(&limit_width(scene, width, |_| [1; 2])) > CHEAP_TEXELS {
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

/// Texels of the first step: half the requested number per side, more where they would be wide.
pub fn choose_first(scene: &Scene, requested: RequestedTexels, width: f64) -> Vec<[u32; 2]> {
    let least = |f: usize| requested(f).map_or([1; 2], |texels| halve_even(texels.map(solved_texels)));
    refine_in_gaps(
        scene,
        limit_width(scene, width, least),
        (TEXELS_ACROSS_GAP, MIN_WIDTH_SHARE * width),
    )
}

/// Texels of the second step: at least the requested number per side, and more than in the first.
pub fn choose_second(scene: &Scene, requested: RequestedTexels, width: f64, first: &[[u32; 2]]) -> Vec<[u32; 2]> {
    let side = |first: u32, wanted: u32| match solved_texels(wanted) {
        n if first < n || (first == n && n % 2 == 1 && n > 1) => 2 * first,
        _ => first,
    };
    let least = |f: usize| requested(f).map_or(first[f], |wanted| [0, 1].map(|k| side(first[f][k], wanted[k])));
    let finer = (2.0 * TEXELS_ACROSS_GAP, 0.5 * MIN_WIDTH_SHARE * width);
    refine_in_gaps(scene, limit_width(scene, 0.5 * width, least), finer)
}

/// Texels of each face: `least`, halved until none is wider than `width`.
fn limit_width(scene: &Scene, width: f64, least: impl Fn(usize) -> [u32; 2]) -> Vec<[u32; 2]> {
    let faces = scene.faces.iter().enumerate();
    faces.map(|(f, face)| narrow_texels(face, least(f), width)).collect()
}

/// Halves texels of a face until none is wider than `width`, or there are many.
fn narrow_texels(face: &Face, mut texels: [u32; 2], width: f64) -> [u32; 2] {
    let lengths = face.grid_lengths();
    let is_wide = |texels: [u32; 2]| (0..2).any(|k| f64::from(texels[k]) * width < lengths[k]);
    while is_wide(texels) && count_texels(&[texels]) < MAX_FACE_TEXELS {
        texels = face.halve_texels(texels);
    }
    texels
}

/// Refines `texels` at narrow gaps, which texels that reach out of the gap would light, and at the contact
/// edges of sheets, as far as that is cheap.
fn refine_in_gaps(scene: &Scene, texels: Vec<[u32; 2]>, wanted: (f64, f64)) -> Vec<[u32; 2]> {
    let mut widths = vec![f64::INFINITY; texels.len()];
    limit_texel_widths(&scene.faces, &texels, wanted, |f, width| {
        widths[f] = widths[f].min(width);
    });
    let limit = CHEAP_TEXELS.max(2 * count_texels(&texels));
    let mut wider = 1.0;
    loop {
        let finer = (scene.faces.iter().zip(&texels).zip(&widths))
            .map(|((face, texels), width)| narrow_texels(face, *texels, width * wider))
            .collect::<Vec<_>>();
        if count_texels(&finer) <= limit {
            return finer;
        }
        wider *= 2.0;
    }
}

/// Returns the smaller number of each side.
pub fn coarser_texels(a: [u32; 2], b: [u32; 2]) -> [u32; 2] {
    [0, 1].map(|k| a[k].min(b[k]))
}

/// Number of all texels; triangles have as many as quads.
pub fn count_texels(resolutions: &[[u32; 2]]) -> u64 {
    resolutions.iter().map(|[w, h]| u64::from(*w) * u64::from(*h)).sum()
}

/// Halves the texels of the faces with the largest `squares`, until the squares of the others sum to at most
/// `remaining`.
pub fn halve_largest(
    faces: &[Face],
    texels: &[[u32; 2]],
    squares: &[f64],
    remaining: f64,
    may_refine: impl Fn(usize) -> bool,
) -> Vec<[u32; 2]> {
    let mut halved = texels.to_vec();
    let mut rest: f64 = squares.iter().sum();
    for f in descending_order(squares) {
        if rest <= remaining {
            break;
        }
        let k = f as usize;
        if may_refine(k) {
            halved[k] = faces[k].halve_texels(texels[k]);
        }
        rest -= squares[k];
    }
    halved
}

/// Error that the texels of a face cause.
#[derive(Clone, Copy, Debug)]
pub struct TexelError {
    /// Its square; a negative one counts as none.
    pub square: f64,
    /// The square on texels half as wide over that.
    pub ratio: f64,
}

/// Halves the texels of faces where that reduces the `errors` most per texel, until the sum of their squares is at most
/// `remaining` times that before, or more than `most` texels would result. Each face's number grows 16 times at most; the
/// others need not err less than those that would have to grow more.
pub fn halve_by_cost(
    faces: &[Face],
    texels: &[[u32; 2]],
    errors: &[TexelError],
    (remaining, most): (f64, u64),
) -> Vec<[u32; 2]> {
    let mut halved = texels.to_vec();
    let mut all = count_texels(texels);
    let mut queue: BinaryHeap<(u64, Reverse<usize>)> = BinaryHeap::new();
    // The bits of numbers of one sign are in their order.
    let per_texel = |square: f64, texels: [u32; 2]| (square / count_texels(&[texels]) as f64).to_bits();
    let positive = errors.iter().map(|error| error.square.max(0.0));
    let mut rest: f64 = positive.clone().sum();
    let goal = remaining * rest;
    let mut of_grown = 0.0;
    for (f, square) in positive.enumerate().filter(|(_, square)| *square > 0.0) {
        queue.push((per_texel(square, texels[f]), Reverse(f)));
    }
    while let Some((bits, Reverse(f))) = queue.pop() {
        let finer = faces[f].halve_texels(halved[f]);
        let [before, after] = [halved[f], finer].map(|texels| count_texels(&[texels]));
        if rest <= goal.max(2.0 * of_grown) || all + after - before > most {
            break;
        }
        halved[f] = finer;
        all += after - before;
        let square = f64::from_bits(bits) * before as f64;
        let left = square * errors[f].ratio;
        rest -= square - left;
        if after < MAX_GROWTH * count_texels(&[texels[f]]) {
            queue.push((per_texel(left, halved[f]), Reverse(f)));
        } else {
            of_grown += left;
        }
    }
    halved
}

/// Resamples values of a face's texels from `from` to `to` texels: means over areas.
pub fn resample_face(values: &[DVec3], face: &Face, from: [u32; 2], to: [u32; 2]) -> Vec<DVec3> {
    if from == to {
        return values.to_vec();
    }
    area_average(values, &shared_pieces(face, from, to), to)
}

#[cfg(test)]
mod tests {
    use super::{TexelError, halve_by_cost, solved_texels};
    use common::scene::Face;
    use glam::{DVec3, Vec3};

    /// A face whose square is 16 times another's gets 16 times its texels, up to the largest growth; none gets any without
    /// need.
    #[test]
    fn texels_are_halved_where_it_pays() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let faces = vec![Face::quad("face", corners, Vec3::ZERO, Vec3::ONE); 4];
        let halve = |squares: [f64; 4], remaining, most| {
            let errors = squares.map(|square| TexelError { square, ratio: 0.25 });
            halve_by_cost(&faces, &[[2; 2]; 4], &errors, (remaining, most))
        };
        assert_eq!(halve([16.0, 1.0, 0.0, -1.0], 1.0, 999), [[2; 2]; 4]);
        assert_eq!(
            halve([16.0, 1.0, 0.0, -1.0], 0.2, 999),
            [[8, 8], [2, 2], [2, 2], [2, 2]]
        );
        assert_eq!(
            halve([16.0, 2.0, 0.0, -1.0], 0.1, 999),
            [[8, 8], [4, 4], [2, 2], [2, 2]]
        );
        assert_eq!(
            halve([16.0, 1.0, 0.0, -1.0], 0.08, 28),
            [[4, 4], [2, 2], [2, 2], [2, 2]]
        );
        // The first keeps 1/16, and the second is less.
        assert_eq!(
            halve([1.0, 0.06, 0.0, 0.0], 1e-9, 999),
            [[8, 8], [2, 2], [2, 2], [2, 2]]
        );
    }

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
