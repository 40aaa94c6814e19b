//! Arrays of a step on the page of links: what `links_data.js` reads.
//!
//! ```text
//! nodes      parent, face, texel (none: the node has children): 3 u32 each
//! corners    of the nodes with children: 12 floats each
//! gathers    direct, coarse, final; of each:
//!   blocks     number of spots and of links: 2 u32
//!   spots      node u32; share of its area, H (3) as floats
//!   sources    node u32, mean radiosity (3) as floats: the nodes that have links
//!   links      node u32
//!   weights    w of each link and spot over 2 to the power `exponent`, as half floats: low bytes, then high bytes of the
//!              differences from the spot before; padded to whole words
//! ```
//! All of it is little-endian and deflated. Texels are in the order of files: each face of a step is one patch.

use super::super::data::WordWriter;
use half::f16;
use miniz_oxide::deflate::compress_to_vec;
use oracle::trace::links::{RecordedGather, TracedStep};
use oracle::trace::packing::{fold_difference, half_exponent};
use serde_json::{Value, json};

/// Level of compression.
const COMPRESSION_LEVEL: u8 = 9;
/// Texel of a node that has children.
const NO_TEXEL: u32 = u32::MAX;

/// A step's arrays, deflated, with their sizes for the script.
pub struct PackedStep {
    /// Sizes.
    pub head: Value,
    /// Arrays.
    pub deflated: Vec<u8>,
}

impl PackedStep {
    /// Packs the links of `step`.
    pub fn new(step: &TracedStep) -> Self {
        let mut words = WordWriter::default();
        let nodes = &step.links.nodes;
        for node in nodes {
            words.add_word(node.parent);
            words.add_word(node.face);
            words.add_word(node.texel.unwrap_or(NO_TEXEL));
        }
        let inner = nodes.iter().filter(|node| node.texel.is_none());
        let corners: Vec<_> = inner.flat_map(|node| node.corners).collect();
        corners.iter().for_each(|corner| words.add_floats(corner.to_array()));
        let links = &step.links;
        let gathers = [&links.direct, &links.coarse, &links.fine].map(|gather| pack_gather(gather, &mut words));
        Self {
            head: json!({
                "goal": step.goal,
                "corrections": links.corrections,
                "nodes": nodes.len(),
                "inner": corners.len() / 4,
                "gathers": gathers,
            }),
            deflated: compress_to_vec(&words.bytes, COMPRESSION_LEVEL),
        }
    }
}

/// Appends a gather and returns its sizes.
fn pack_gather(gather: &RecordedGather, words: &mut WordWriter) -> Value {
    let blocks = &gather.blocks;
    for block in blocks {
        words.add_word(block.spots.len() as u32);
        words.add_word(block.links.len() as u32);
    }
    let spots = blocks.iter().flat_map(|block| &block.spots);
    for spot in spots.clone() {
        words.add_word(spot.node);
        words.add_floats([spot.share]);
        words.add_floats(spot.irradiance.to_array());
    }
    let links = blocks.iter().flat_map(|block| &block.links);
    let mut sources: Vec<u32> = links.clone().map(|link| link.node).collect();
    sources.sort_unstable();
    sources.dedup();
    for node in &sources {
        words.add_word(*node);
        words.add_floats(gather.radiosity[*node as usize].mean.to_array());
    }
    links.clone().for_each(|link| words.add_word(link.node));
    let weights = blocks.iter().flat_map(|block| {
        let links = block.links.iter();
        links.map(|stored| &stored.link.weight[..block.spots.len()])
    });
    let exponent = half_exponent(weights.clone().flatten().copied().fold(0.0, f32::max));
    let mut planes = [Vec::new(), Vec::new()];
    for own in weights {
        let mut before = 0;
        for weight in own {
            let bits = f16::from_f64(f64::from(*weight) * f64::from(-exponent).exp2()).to_bits();
            let difference = bits.wrapping_sub(before);
            before = bits;
            for (plane, byte) in planes.iter_mut().zip(fold_difference(difference)) {
                plane.push(byte);
            }
        }
    }
    let weights = planes[0].len();
    words.bytes.extend(planes.concat());
    words.bytes.resize(words.bytes.len().next_multiple_of(4), 0);
    json!({
        "blocks": blocks.len(),
        "spots": spots.count(),
        "sources": sources.len(),
        "links": links.count(),
        "weights": weights,
        "exponent": exponent,
    })
}
