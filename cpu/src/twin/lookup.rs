//! Whether a texel sees the shooter, asked of the item buffer. Twin of
//! `gpu/src/shaders/lookup.wgsl`.
//!
//! Exact: the pixel that holds the texel's projection has its ID, or that of a face in the same
//! place. 3×3: one of the nine pixels around it has, and none of the other faces seen there cuts the
//! segment from the shooter; the nine pixels name the faces that may hide the texel, those are asked
//! exactly.

use crate::twin::item_buffer::ItemBuffer;
use crate::twin::projection::{pixels, project};
use crate::twin::view::View;
use common::intersect::{intersect, touches};
use common::mesh::Mesh;
use common::rays::Sight;
use common::settings::{Drawing, Lookup};
use glam::Vec3;

/// The item buffers of one point of a cell: with the objects and, where it and they differ, without.
pub struct Buffers {
    view: View,
    lookup: Lookup,
    with: ItemBuffer,
    without: Option<ItemBuffer>,
}

impl Buffers {
    /// Draws them for point `s` of `cell`. The room is drawn alike in both.
    pub fn new(mesh: &Mesh, cell: u32, s: u32, drawing: &Drawing) -> Self {
        let view = View::new(mesh, cell, s, drawing);
        let all = mesh.faces.len() as u32;
        let differ = mesh.room < all && !mesh.is_object(mesh.cells[cell as usize].face);
        Self {
            view,
            lookup: drawing.lookup,
            with: ItemBuffer::draw(mesh, &view, all),
            without: differ.then(|| ItemBuffer::draw(mesh, &view, mesh.room)),
        }
    }

    /// How the texel at `position` on `face` sees the point: nothing of the room is seen now that
    /// was not seen without the objects.
    pub fn sight(&self, mesh: &Mesh, position: Vec3, face: u32) -> Sight {
        let ask =
            |buffer: &ItemBuffer| visible(mesh, buffer, &self.view, self.lookup, position, face);
        let before = match &self.without {
            Some(without) if !mesh.is_object(face) => ask(without),
            _ => true,
        };
        if !before {
            Sight::Blocked
        } else if ask(&self.with) {
            Sight::Clear
        } else if self.without.is_some() {
            Sight::Hidden
        } else {
            Sight::Blocked
        }
    }
}

/// Whether the texel at `position` on `face` sees the shooter of `view` (Table 1, line 6).
pub fn visible(
    mesh: &Mesh,
    buffer: &ItemBuffer,
    view: &View,
    lookup: Lookup,
    position: Vec3,
    face: u32,
) -> bool {
    let p = pixels(
        project(view.projection, view.frame.to_local(position)),
        buffer.size,
    );
    let last = buffer.size as i32 - 1;
    let x = (p.x.floor() as i32).clamp(0, last);
    let y = (p.y.floor() as i32).clamp(0, last);
    let mut found = false;
    let mut asked = 0;
    let reach = lookup.reach();
    for j in (y - reach).max(0)..=(y + reach).min(last) {
        for i in (x - reach).max(0)..=(x + reach).min(last) {
            let id = buffer.ids[(j as u32 * buffer.size + i as u32) as usize];
            if id == face + 1 || lies_on(mesh, id, position) {
                found = true;
            } else if reach > 0 && id != 0 && id != asked {
                if blocks(mesh, view, id - 1, position, face) {
                    return false;
                }
                asked = id;
            }
        }
    }
    found
}

/// Whether what a pixel shows lies in the texel's own place: the far side of a thin wall, drawn at the
/// same depth.
fn lies_on(mesh: &Mesh, id: u32, position: Vec3) -> bool {
    id != 0 && touches(&mesh.faces[id as usize - 1], position)
}

/// Whether `occluder` cuts the segment from the shooter to the texel.
fn blocks(mesh: &Mesh, view: &View, occluder: u32, position: Vec3, face: u32) -> bool {
    let occluder = &mesh.faces[occluder as usize];
    if occluder.sheet == mesh.faces[face as usize].sheet {
        return false;
    }
    let hit = intersect(occluder, view.frame.centre, position - view.frame.centre);
    hit.between(1.0) && !touches(occluder, view.frame.centre) && !touches(occluder, position)
}
