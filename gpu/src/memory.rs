//! What a solve takes on the device, before anything is allocated.

use crate::adapter::Gpu;
use crate::buffers::{LOG_BYTES, most_bytes};
use crate::records::{CellRecord, FaceRecord, PointRecord, ROW_BYTES, TexelRecord};
use common::constants::{LEVELS, LINK_BYTES};
use common::settings::{Transport, Visibility};
use glam::Vec4;

impl Gpu {
    /// Bytes of the links that are kept.
    pub fn link_bytes(&self, cells: u64, texels: u64) -> u64 {
        let row = 4 * texels.max(1);
        let places = (LINK_BYTES.min(most_bytes(self)) / row).clamp(1, cells.max(1));
        places.saturating_mul(row + ROW_BYTES)
    }

    /// Bytes of everything else that grows: records, state, item buffer and its depth, the tree.
    /// `points` is how many there are on a cell.
    pub fn state_bytes(
        &self,
        [faces, cells, texels]: [u64; 3],
        points: u64,
        transport: &Transport,
    ) -> u64 {
        let (pixels, tree) = match transport.visibility {
            // A CwBvh node of 80 bytes holds three faces or more.
            Visibility::Rays => (1, faces * 32),
            Visibility::Drawn(drawing) => (drawing.pixels(), 0),
        };
        let of = |count: u64, bytes: usize| count.saturating_mul(bytes as u64);
        [
            of(faces, size_of::<FaceRecord>() + 8 * LEVELS as usize),
            of(cells, size_of::<CellRecord>() + 16 + 4 + 4),
            of(texels, size_of::<TexelRecord>() + 4 * size_of::<Vec4>()),
            of(cells * points, size_of::<PointRecord>()),
            of(pixels, 8),
            tree,
            LOG_BYTES,
        ]
        .into_iter()
        .fold(0, u64::saturating_add)
    }
}
