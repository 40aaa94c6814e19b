//! What is asked of whoever finds links.

use crate::hierarchy::block::{Block, Receivers};
use crate::hierarchy::light::Glow;
use crate::hierarchy::world::{Thresholds, What};
use glam::Vec3;
use std::ops::Range;

/// What is asked for.
pub struct Question<'a> {
    /// What is gathered.
    pub what: What<'a>,
    /// Of every node and cluster.
    pub glow: &'a [Glow],
    /// What links may leave out.
    pub thresholds: Thresholds,
    /// Who receives.
    pub receivers: &'a Receivers,
    /// A face's reflectance over the RMS of the reflected light, by channel.
    pub scale: &'a (dyn Fn(u32) -> Vec3 + Sync),
    /// Which part of the whole solve this is.
    pub part: Range<f64>,
}

impl Question<'_> {
    /// The scale of a block on several faces: the largest.
    pub fn scale_of(&self, block: &Block) -> Vec3 {
        let faces = block.faces[..block.count].iter();
        faces.fold(Vec3::ZERO, |most, face| most.max((self.scale)(*face)))
    }
}
