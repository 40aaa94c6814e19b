//! Visibility of the shooter from a texel, looked up in the shooter's item buffer.
//!
//! Exact: the pixel that holds the texel's projection has its ID, or that of a face in the same
//! place. 3×3: one of the nine pixels around it has, and none of the other faces seen there cuts the
//! segment from the shooter; the nine pixels name the faces that may occlude the texel, and those are intersected.

use crate::shader_twins::item_buffer::ItemBuffer;
use crate::shader_twins::projection::{pixel_position, project_direction};
use crate::shader_twins::view::{ShooterView, view_all_faces};
use common::intersect::{intersect_face, touches_plane};
use common::mesh::Mesh;
use common::rays::LineOfSight;
use common::settings::{ItemBufferSettings, Lookup};
use glam::Vec3;

/// Item buffers of a sample point: with the objects, and without them where that makes a difference.
pub struct SampleItemBuffers {
    view: ShooterView,
    lookup: Lookup,
    with: ItemBuffer,
    without: Option<ItemBuffer>,
}

impl SampleItemBuffers {
    /// Draws the item buffers of sample point `s` of a patch. Both show the same room.
    pub fn new(mesh: &Mesh, patch: u32, s: u32, drawing: &ItemBufferSettings) -> Self {
        let view = ShooterView::new(mesh, patch, s, drawing);
        let all = view_all_faces(mesh);
        let differ = mesh.room_faces < all && !mesh.is_object(mesh.patches[patch as usize].face);
        Self {
            view,
            lookup: drawing.lookup,
            with: ItemBuffer::draw_faces(mesh, &view, all),
            without: differ.then(|| ItemBuffer::draw_faces(mesh, &view, mesh.room_faces)),
        }
    }

    /// Takes item buffers drawn elsewhere: with the objects, and without them where that makes a difference.
    pub fn of_buffers(view: ShooterView, lookup: Lookup, (with, without): (ItemBuffer, Option<ItemBuffer>)) -> Self {
        Self {
            view,
            lookup,
            with,
            without,
        }
    }

    /// Returns the visibility between the sample point and the texel at `position` on `face`. Nothing of the room
    /// is visible with the objects that was not visible without them.
    pub fn find_sight(&self, mesh: &Mesh, position: Vec3, face: u32) -> LineOfSight {
        let ask = |buffer: &ItemBuffer| is_visible(mesh, buffer, &self.view, self.lookup, position, face);
        let before = match &self.without {
            Some(without) if !mesh.is_object(face) => ask(without),
            _ => true,
        };
        if !before {
            LineOfSight::Blocked
        } else if ask(&self.with) {
            LineOfSight::Clear
        } else if self.without.is_some() {
            LineOfSight::HiddenByObject
        } else {
            LineOfSight::Blocked
        }
    }
}

/// Returns whether the texel at `position` on `face` sees the shooter of `view` (Table 1, line 6).
pub fn is_visible(
    mesh: &Mesh,
    buffer: &ItemBuffer,
    view: &ShooterView,
    lookup: Lookup,
    position: Vec3,
    face: u32,
) -> bool {
    let p = pixel_position(
        project_direction(view.projection, view.frame.to_local(position)),
        buffer.size,
    );
    let last = buffer.size as i32 - 1;
    let x = (p.x.floor() as i32).clamp(0, last);
    let y = (p.y.floor() as i32).clamp(0, last);
    let mut found = false;
    let mut tested = 0;
    let reach = lookup.reach_pixels();
    for j in (y - reach).max(0)..=(y + reach).min(last) {
        for i in (x - reach).max(0)..=(x + reach).min(last) {
            let id = buffer.ids[(j as u32 * buffer.size + i as u32) as usize];
            if id == face + 1 || lies_on_face(mesh, id, position) {
                found = true;
            } else if reach > 0 && id != 0 && id != tested {
                if blocks_segment(mesh, view, id - 1, position, face) {
                    return false;
                }
                tested = id;
            }
        }
    }
    found
}

/// Returns whether the face of a pixel lies in the texel's plane: the far side of a thin wall has the same depth.
fn lies_on_face(mesh: &Mesh, id: u32, position: Vec3) -> bool {
    id != 0 && touches_plane(&mesh.faces[id as usize - 1], position)
}

/// Returns whether `occluder` cuts the segment from the shooter to the texel.
fn blocks_segment(mesh: &Mesh, view: &ShooterView, occluder: u32, position: Vec3, face: u32) -> bool {
    let occluder = &mesh.faces[occluder as usize];
    if occluder.sheet == mesh.faces[face as usize].sheet {
        return false;
    }
    let hit = intersect_face(occluder, view.frame.centre, position - view.frame.centre);
    hit.stops_ray(1.0) && !touches_plane(occluder, view.frame.centre) && !touches_plane(occluder, position)
}
