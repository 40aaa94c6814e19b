//! The item buffer's pixels against their twin's.

use super::tally::Tally;
use common::constants::{DEPTH_SCALE, OUTLINE};
use common::intersect::intersect;
use common::mesh::Mesh;
use common::settings::Raster;
use cpu::twin::item_buffer::ItemBuffer;
use cpu::twin::projection::{covered, pixel_centre, unproject};
use cpu::twin::view::View;
use glam::Vec2;
use rayon::prelude::*;

/// Pixels on boundaries that are asked again in every view.
const ASKED: usize = 64;
/// Roundings by which another adapter's arithmetic may move a ray, or a depth: three dot products,
/// a quotient and a root, each up to 5 ulp where WGSL is weaker.
const ROUNDINGS: f32 = 32.0;

/// Rasterisers may snap vertices to 1/256 pixel, and a vertex's rounding moves it by less: a
/// pixel centre lies that close to an edge for 2 of 256 pixels on a boundary. Doubled, because
/// each boundary pixel has edges on two sides.
pub const PIXEL_SHARE: f64 = 4.0 / 256.0;

/// Every pixel of one view. By pixels: 1 where a pixel differs though no rounding decides it.
/// Tessellated: pixels that differ over pixels on a boundary.
pub fn whole(mesh: &Mesh, view: &View, buffer: &ItemBuffer) -> Tally {
    let twin = ItemBuffer::draw(mesh, view, mesh.room);
    if buffer.ids.len() != twin.ids.len() {
        return [f64::NAN].into_iter().collect();
    }
    let differing: Vec<usize> = (0..twin.ids.len())
        .filter(|k| twin.ids[*k] != buffer.ids[*k])
        .collect();
    let mut tally = Tally::default();
    match view.projection.raster() {
        Raster::Tessellated => {
            let boundary = boundaries(&twin).count().max(1);
            tally.add(differing.len() as f64 / boundary as f64);
        }
        Raster::Pixel => {
            tally.alike((twin.ids.len() - differing.len()) as u64);
            for k in differing {
                tally.same(decided_by_rounding(mesh, view, k as u32, buffer.ids[k]));
            }
        }
    }
    tally
}

/// Some pixels on the boundaries of one view, where a raster errs first; by pixels only.
pub fn some(mesh: &Mesh, view: &View, buffer: &ItemBuffer) -> Tally {
    if view.projection.raster() == Raster::Tessellated {
        return Tally::default();
    }
    let all: Vec<usize> = boundaries(buffer).collect();
    let step = all.len().div_ceil(ASKED).max(1);
    let asked: Vec<usize> = all.into_iter().step_by(step).collect();
    let of = |k: &usize| {
        let id = buffer.ids[*k];
        let wrong = !decided_by_rounding(mesh, view, *k as u32, id);
        f64::from(u8::from(wrong))
    };
    asked
        .par_iter()
        .map(of)
        .collect::<Vec<_>>()
        .into_iter()
        .collect()
}

/// Pixels whose right or lower neighbour has another ID.
pub fn boundaries(buffer: &ItemBuffer) -> impl Iterator<Item = usize> {
    let n = buffer.size as usize;
    let ids = &buffer.ids;
    (0..ids.len()).filter(move |k| {
        (k % n + 1 < n && ids[*k] != ids[k + 1]) || (k + n < ids.len() && ids[*k] != ids[k + n])
    })
}

/// Whether a ray that is moved by as much as rounding may move it shows `id` in pixel `k`.
fn decided_by_rounding(mesh: &Mesh, view: &View, k: u32, id: u32) -> bool {
    let d = ROUNDINGS * f32::EPSILON;
    let moves = [Vec2::ZERO, Vec2::X, -Vec2::X, Vec2::Y, -Vec2::Y];
    moves
        .into_iter()
        .any(|step| twin(mesh, view, k, step * d, id))
}

/// Whether pixel `k`, moved by `step` on the square −1…1, shows `id`.
fn twin(mesh: &Mesh, view: &View, k: u32, step: Vec2, id: u32) -> bool {
    let p = pixel_centre(k % view.size, k / view.size, view.size) + step;
    if !covered(view.projection, p, view.size) {
        return id == 0;
    }
    let direction = view.frame.to_world(unproject(view.projection, p));
    let slack = ROUNDINGS * f32::EPSILON;
    let (mut nearest, mut mine) = (f32::INFINITY, None);
    for (face, number) in mesh.faces.iter().zip(1..) {
        if cpu::twin::bound::hidden(view, face) {
            continue;
        }
        let hit = intersect(face, view.frame.centre, direction);
        // Within rounding of the outline the face may be there or not.
        if hit.t <= 0.0 || hit.inside < -OUTLINE - slack {
            continue;
        }
        let depth = hit.t * DEPTH_SCALE;
        if number == id {
            mine = Some(depth);
        }
        if hit.inside >= -OUTLINE + slack {
            nearest = nearest.min(depth);
        }
    }
    match mine {
        Some(depth) => depth <= nearest * (1.0 + slack),
        None => id == 0 && nearest == f32::INFINITY,
    }
}
