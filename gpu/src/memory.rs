//! What a solve takes on the device, before anything is allocated.

use crate::adapter::Gpu;
use crate::buffers::{LOG_BYTES, most_bytes};
use crate::records::{CellRecord, FaceRecord, PointRecord, ROW_BYTES, TexelRecord};
use common::constants::{LEVELS, LINK_BYTES};
use common::settings::{Settings, Visibility};
use glam::Vec4;

impl Gpu {
    /// Bytes of the links that are kept.
    pub fn link_bytes(&self, cells: u64, texels: u64) -> u64 {
        let row = 4 * texels.max(1);
        let places = (LINK_BYTES.min(most_bytes(self)) / row).clamp(1, cells.max(1));
        places.saturating_mul(row + ROW_BYTES)
    }

    /// Bytes of everything else that grows: records, state, item buffer and its depth, the tree.
    pub fn state_bytes(&self, faces: u64, cells: u64, texels: u64, settings: &Settings) -> u64 {
        let rays = settings.visibility == Visibility::Rays;
        let pixels = if rays {
            1
        } else {
            u64::from(settings.item_buffer).pow(2)
        };
        // A CwBvh node of 80 bytes holds three faces or more.
        let tree = if rays { faces * 32 } else { 0 };
        let of = |count: u64, bytes: usize| count.saturating_mul(bytes as u64);
        [
            of(faces, size_of::<FaceRecord>() + 8 * LEVELS as usize),
            of(cells, size_of::<CellRecord>() + 16 + 4 + 4),
            of(texels, size_of::<TexelRecord>() + 4 * size_of::<Vec4>()),
            of(
                cells * u64::from(settings.samples),
                size_of::<PointRecord>(),
            ),
            of(pixels, 8),
            tree,
            LOG_BYTES,
        ]
        .into_iter()
        .fold(0, u64::saturating_add)
    }
}
