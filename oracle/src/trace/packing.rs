//! Compression of a shooter's links: form factor, visible share and occluder of every texel.
//!
//! Form factors and shares are half floats, which have 11 significant bits: each is rounded by at most [`HALF_ROUNDING`] of
//! itself. Form factors are first divided by a power of two, so that the largest lies just below the largest half float and none
//! that matters is subnormal. Each number is replaced by its difference from a prediction by its neighbours on the face, which
//! is small where light varies smoothly; then the bytes are deflated (RFC 1951).

use common::mesh::{Mesh, TexelKind};
use half::f16;
use miniz_oxide::deflate::compress_to_vec;

/// Largest relative error of a number that was rounded to a half float.
pub const HALF_ROUNDING: f32 = 1.0 / 2048.0;
/// Exponent of the largest form factor of a shooter after scaling: half floats reach to 2¹⁶.
const TOP_EXPONENT: i32 = 14;
/// Level of compression: beyond it the time doubles for a hundredth of the size.
const COMPRESSION_LEVEL: u8 = 7;

/// Links of a patch, compressed.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedLinks {
    /// Number of the patch.
    pub patch: u32,
    /// True if it shot the captured light of a room.
    pub is_captured: bool,
    /// Form factors are stored over 2 to this power.
    pub exponent: i32,
    /// True if some texel does not see the whole patch; else no shares and occluders are stored.
    pub is_occluded: bool,
    /// True if an item buffer shows some texel what rays do not, or hides it; else no share errors are stored.
    pub is_wrong: bool,
    /// Deflated planes: low bytes and high bytes of the form factors, the shares, the occluders and the share errors.
    pub deflated: Vec<u8>,
}

/// Links of a patch to all texels, in the order of files (face after face, row by row).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TexelLinks {
    /// Form factor F from each texel, as if nothing were between: the CPU's, or F · V of the solver where that is more or differs
    /// by rounding only. 0 where objects leave captured light as it was.
    pub form_factors: Vec<f32>,
    /// Share V of the patch that each texel sees, 0 to 1; what a body covers is not seen. Below 0 where objects hide captured
    /// light.
    pub shares: Vec<f32>,
    /// Number of a face that hides part of the patch, from 1; 0 for none that is known.
    pub occluders: Vec<u16>,
    /// V less the share that rays between the same points find; 0 of solves by rays, and in relights.
    pub share_errors: Vec<f32>,
}

/// Texels in the order of files, and their places on their faces.
pub struct TexelOrder {
    /// The mesh's number of each texel.
    pub texels: Vec<usize>,
    /// Place of each texel on its face.
    places: Vec<FacePlace>,
}

/// Place of a texel on its face.
#[derive(Clone, Copy)]
struct FacePlace {
    /// Number of the texel on the face.
    index: usize,
    /// Texels per row.
    width: usize,
    is_quad: bool,
}

impl FacePlace {
    /// Predicts the value at `at` by those before it: on a quad left + upper − upper left, on a triangle the one before the
    /// last, which is turned alike; else the one before.
    fn predict_value(self, values: &[u16], at: usize) -> u16 {
        let value = |back: usize| values[at - back];
        let Self { index, width, is_quad } = self;
        match (is_quad, index / width, index % width) {
            (true, 1.., 1..) => value(1).wrapping_add(value(width)).wrapping_sub(value(width + 1)),
            (true, 1.., 0) => value(width),
            (false, ..) if index > 1 => value(2),
            _ if at > 0 => value(1),
            _ => 0,
        }
    }
}

impl TexelOrder {
    /// Lists the texels of `mesh`.
    pub fn new(mesh: &Mesh) -> Self {
        let texels = mesh.texels_in_face_order();
        let place = |k: &usize| {
            let texel = &mesh.texels[*k];
            FacePlace {
                index: texel.index as usize,
                width: mesh.faces[texel.face as usize].resolution[0] as usize,
                is_quad: texel.kind == TexelKind::Quad,
            }
        };
        Self {
            places: texels.iter().map(place).collect(),
            texels,
        }
    }

    /// Appends the low, then the high bytes of the differences of values from their predictions.
    fn append_planes(&self, values: &[u16], bytes: &mut Vec<u8>) {
        let places = self.places.iter().enumerate();
        let differences = places.map(|(at, place)| values[at].wrapping_sub(place.predict_value(values, at)));
        let folded: Vec<[u8; 2]> = differences.map(fold_difference).collect();
        for plane in 0..2 {
            bytes.extend(folded.iter().map(|pair| pair[plane]));
        }
    }
}

/// Returns low and high byte of a difference, so that small ones of both signs become small numbers.
pub fn fold_difference(difference: u16) -> [u8; 2] {
    ((difference << 1) ^ ((difference as i16) >> 15) as u16).to_le_bytes()
}

/// Returns the exponent of the power of two over which numbers up to `largest` lie just below the largest half float.
pub fn half_exponent(largest: f32) -> i32 {
    match largest {
        0.0 => 0,
        largest => largest.log2().floor() as i32 - TOP_EXPONENT,
    }
}

impl PackedLinks {
    /// Compresses the links of `patch`.
    pub fn new(patch: u32, is_captured: bool, links: &TexelLinks, order: &TexelOrder) -> Self {
        let exponent = half_exponent(links.form_factors.iter().copied().fold(0.0, f32::max));
        let is_occluded = links.shares.iter().any(|share| *share != 1.0);
        let is_wrong = links.share_errors.iter().any(|error| *error != 0.0);
        let halves = |values: &[f32], scale: f64| -> Vec<u16> {
            let scaled = values.iter().map(|x| f16::from_f64(f64::from(*x) * scale));
            scaled.map(f16::to_bits).collect()
        };
        let mut bytes = Vec::new();
        let scale = f64::from(-exponent).exp2();
        order.append_planes(&halves(&links.form_factors, scale), &mut bytes);
        if is_occluded {
            order.append_planes(&halves(&links.shares, 1.0), &mut bytes);
            order.append_planes(&links.occluders, &mut bytes);
        }
        if is_wrong {
            order.append_planes(&halves(&links.share_errors, 1.0), &mut bytes);
        }
        Self {
            patch,
            is_captured,
            exponent,
            is_occluded,
            is_wrong,
            deflated: compress_to_vec(&bytes, COMPRESSION_LEVEL),
        }
    }

    /// Returns the number of bytes.
    pub fn byte_count(&self) -> usize {
        self.deflated.len()
    }
}
