//! What a shooter sees: a small item buffer of each shooter's hemisphere, drawn by the CPU's twin, compressed.

use common::mesh::Mesh;
use common::settings::{ItemBufferProjection, ItemBufferSettings, Visibility};
use cpu::shader_twins::frame::Frame;
use cpu::shader_twins::item_buffer::ItemBuffer;
use cpu::shader_twins::view::{ShooterView, view_all_faces};
use miniz_oxide::deflate::compress_to_vec;

/// Maximum pixels per side.
const MAX_SIZE: u32 = 64;
/// Level of compression.
const COMPRESSION_LEVEL: u8 = 9;

/// Item buffer of a shooter, compressed.
#[derive(Clone, Debug)]
pub struct PackedHemisphere {
    /// Frame of the shooter's first sample point.
    pub frame: Frame,
    /// Deflated number of the nearest face of each pixel, from 1, or 0 for none: first all low bytes, then all high bytes.
    pub deflated: Vec<u8>,
}

/// Returns the settings by which the hemispheres of a solve are drawn: those of its own item buffer, but at most 64 pixels per
/// side. For rays the projection is orthographic, so that areas are form factors.
pub fn hemisphere_settings(visibility: Visibility) -> ItemBufferSettings {
    let own = visibility.item_buffer().unwrap_or(ItemBufferSettings {
        projection: ItemBufferProjection::Hemisphere,
        ..ItemBufferSettings::DEFAULT
    });
    ItemBufferSettings {
        size: own.size.min(MAX_SIZE),
        ..own
    }
}

impl PackedHemisphere {
    /// Draws the item buffer of the first sample point of `patch`.
    pub fn new(mesh: &Mesh, patch: u32, drawing: &ItemBufferSettings) -> Self {
        let view = ShooterView::new(mesh, patch, 0, drawing);
        let ids = ItemBuffer::draw_faces(mesh, &view, view_all_faces(mesh)).ids;
        // A trace has far fewer faces than 16 bits can number.
        let ids = ids.iter().map(|id| u16::try_from(*id).unwrap_or(0).to_le_bytes());
        let [low, high] = [0, 1].map(|plane| ids.clone().map(move |bytes| bytes[plane]));
        let bytes: Vec<u8> = low.chain(high).collect();
        Self {
            frame: view.frame,
            deflated: compress_to_vec(&bytes, COMPRESSION_LEVEL),
        }
    }

    /// Returns the number of bytes.
    pub fn byte_count(&self) -> usize {
        self.deflated.len()
    }
}
