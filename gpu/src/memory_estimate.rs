//! Estimates of the device memory of a solve, before anything is allocated. The program refuses a solve that does not
//! fit by them.

use crate::adapter::Gpu;
use crate::records::{FaceRecord, PatchRecord, PointRecord, ROW_BYTES, TexelRecord};
use crate::solver_buffers::{LOG_BYTES, max_binding_bytes};
use common::constants::MAX_LINK_BYTES;
use common::settings::{Transport, Visibility};
use glam::Vec4;

impl Gpu {
    /// Returns the bytes of the links that are kept.
    pub fn link_bytes(&self, patches: u64, texels: u64) -> u64 {
        let row = 4 * texels.max(1);
        let places = (MAX_LINK_BYTES.min(max_binding_bytes(self)) / row).clamp(1, patches.max(1));
        places.saturating_mul(row + ROW_BYTES)
    }

    /// Returns the bytes of all else that grows with the scene: records, state, item buffer and depth, BVH.
    /// `points` is the number of sample points of a patch.
    pub fn state_bytes(&self, [faces, patches, texels]: [u64; 3], points: u64, transport: &Transport) -> u64 {
        let (pixels, tree) = match transport.visibility {
            // A CwBvh node of 80 bytes holds three faces or more.
            Visibility::Rays => (1, faces * 32),
            Visibility::ItemBuffer(drawing) => (drawing.pixel_count(), 0),
        };
        let of = |count: u64, bytes: usize| count.saturating_mul(bytes as u64);
        [
            of(faces, size_of::<FaceRecord>()),
            of(patches, size_of::<PatchRecord>() + 16 + 4 + 4),
            of(texels, size_of::<TexelRecord>() + 4 * size_of::<Vec4>()),
            of(patches * points, size_of::<PointRecord>()),
            of(pixels, 8),
            tree,
            LOG_BYTES,
        ]
        .into_iter()
        .fold(0, u64::saturating_add)
    }
}
