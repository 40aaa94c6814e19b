//! Arrays of a trace's page: what `trace_data.js` reads.
//!
//! ```text
//! initial B, initial r   3 floats per texel each
//! patch of each texel    u32
//! patches                face u32; area (scene units²), open share, centre (3), corners (12) as floats
//! shooters               patch, exponent, bits (1: occluded; 2: of captured light; 4: with share errors), bytes of links and hemisphere: 5 u32; frame
//!                        of the hemisphere: point, x, y, z as 12 floats
//! shots                  shooter u32; B_i (3), unshot power, absorbed, unshot, escaped, closure as floats (0 in a
//!                        relight)
//! rankings               patch u32, power, RANKED_PATCHES times per shot
//! ```
//! All of it is little-endian and deflated. Texels are in the order of files, power is in watts if the file's unit of length is
//! the metre.

use common::energy::EnergyBalance;
use common::mesh::Mesh;
use miniz_oxide::deflate::compress_to_vec;
use oracle::trace::{PartBytes, RANKED_PATCHES, ShotTrace, TracedShot};

/// Level of compression.
const COMPRESSION_LEVEL: u8 = 9;
/// Words of a shot and its ranking.
const SHOT_WORDS: usize = 9 + 2 * RANKED_PATCHES;
/// Words of a shooter, besides its links and hemisphere.
const SHOOTER_WORDS: usize = 5 + 12;
/// Bytes of a shot and of a shooter on the page, not compressed.
pub const PART_BYTES: PartBytes = PartBytes {
    shot: 4 * SHOT_WORDS,
    shooter: 4 * SHOOTER_WORDS,
};
/// Number of no patch, after the last of a ranking.
const NO_PATCH: u32 = u32::MAX;

/// First shots and links of a trace that a page has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShownPart {
    /// Number of shots.
    pub shots: usize,
    /// Number of links.
    pub links: usize,
}

/// Packs all arrays but the links and hemispheres themselves.
pub fn pack_arrays(trace: &ShotTrace, mesh: &Mesh, shown: ShownPart) -> Vec<u8> {
    let mut words = WordWriter::default();
    let order = mesh.texels_in_face_order();
    for field in [&trace.initial.radiosity, &trace.initial.residual] {
        for k in &order {
            words.add_floats(field[*k].truncate().to_array());
        }
    }
    let mut patch_of = vec![NO_PATCH; order.len()];
    for (number, patch) in (0..).zip(&mesh.patches) {
        patch_of[patch.texels()].fill(number);
    }
    order.iter().for_each(|k| words.add_word(patch_of[*k]));
    let area_unit = mesh.area_unit() as f32;
    for patch in &mesh.patches {
        words.add_word(patch.face);
        words.add_floats([patch.shooter.area * area_unit, patch.open_share]);
        words.add_floats(patch.shooter.centre.to_array());
        for corner in patch.shooter.corners {
            words.add_floats(corner.to_array());
        }
    }
    for (links, hemisphere) in trace.links[..shown.links].iter().zip(&trace.hemispheres) {
        words.add_word(links.patch);
        words.add_word(links.exponent.cast_unsigned());
        let bits = [links.is_occluded, links.is_captured, links.is_wrong].map(u32::from);
        words.add_word(bits[0] + 2 * bits[1] + 4 * bits[2]);
        words.add_word(links.deflated.len() as u32);
        words.add_word(hemisphere.deflated.len() as u32);
        let frame = hemisphere.frame;
        for vector in [frame.centre, frame.tangent, frame.bitangent, frame.normal] {
            words.add_floats(vector.to_array());
        }
    }
    for shot in &trace.shots[..shown.shots] {
        add_shot(&mut words, shot, area_unit);
    }
    for shot in &trace.shots[..shown.shots] {
        for rank in 0..RANKED_PATCHES {
            let (patch, power) = shot.ranking.get(rank).copied().unwrap_or((NO_PATCH, 0.0));
            words.add_word(patch);
            words.add_floats([power * area_unit]);
        }
    }
    compress_to_vec(&words.bytes, COMPRESSION_LEVEL)
}

fn add_shot(words: &mut WordWriter, traced: &TracedShot, area_unit: f32) {
    words.add_word(traced.links as u32);
    words.add_floats(traced.radiosity.to_array());
    words.add_floats([traced.shot.unshot * area_unit]);
    words.add_floats(energy_parts(traced.energy.as_ref()).map(|part| part as f32));
}

/// Returns absorbed, unshot, escaped and closure, summed over the channels; 0 where they are not known.
pub fn energy_parts(energy: Option<&EnergyBalance>) -> [f64; 4] {
    energy.map_or([0.0; 4], |energy| {
        let parts = [energy.absorbed, energy.unshot, energy.escaped, energy.closure];
        parts.map(|part| part.iter().sum())
    })
}

/// Bytes of words of 32 bits.
#[derive(Default)]
pub struct WordWriter {
    /// The bytes, little-endian.
    pub bytes: Vec<u8>,
}

impl WordWriter {
    /// Adds a word.
    pub fn add_word(&mut self, word: u32) {
        self.bytes.extend(word.to_le_bytes());
    }

    /// Adds floats.
    pub fn add_floats<const N: usize>(&mut self, values: [f32; N]) {
        values.iter().for_each(|value| self.add_word(value.to_bits()));
    }
}
