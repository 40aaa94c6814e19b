//! Compares the pixels of the GPU's item buffer with those of the CPU twin. The checks of stages and of visibility call
//! it.

use super::snapped_triangles;
use super::statistics::{Elements, ErrorTally, ValueSource};
use common::constants::{DEPTH_SCALE, OUTLINE_MARGIN};
use common::intersect::intersect_face;
use common::mesh::Mesh;
use common::settings::ItemBufferProjection;
use cpu::shader_twins::item_buffer::ItemBuffer;
use cpu::shader_twins::projection::{is_covered, pixel_centre, unproject_point};
use cpu::shader_twins::view::ShooterView;
use glam::Vec2;
use rayon::prelude::*;

/// Largest number of boundary pixels that are checked in a view.
const MAX_PIXELS_PER_VIEW: usize = 64;
/// Roundings by which an adapter's arithmetic may move a ray or a depth: three dot products, a quotient and a
/// root, each up to 5 ulp in WGSL.
const MAX_RAY_ROUNDINGS: f32 = 32.0;

/// Names of the values of a pixel.
const VALUE_NAMES: [&str; 2] = ["face + 1", "number of pixels"];
const FACE_NUMBER: usize = 0;
const PIXEL_COUNT: usize = 1;

/// Starts a tally of pixels that show another face than they may.
pub fn pixel_tally(name: &'static str, projection: Option<ItemBufferProjection>) -> ErrorTally {
    let pixels = Elements {
        name: "pixel",
        count: 0,
        lanes: 1,
    };
    let reason = match projection {
        Some(ItemBufferProjection::Paper) => {
            "pixels that differ from the twin's, though no vertex within a step of the rasteriser's grid decides them"
        }
        _ => "pixels that show a different face from the one that their ray meets, with no edge within rounding",
    };
    ErrorTally::new(name, (0.0, reason), pixels, &VALUE_NAMES)
}

/// Checks all pixels of a view. Counts 1 for each different pixel that rounding does not decide.
pub fn check_all_pixels(
    mesh: &Mesh,
    view: &ShooterView,
    buffer: &ItemBuffer,
    source: ValueSource,
    tally: &mut ErrorTally,
) {
    let twin = ItemBuffer::draw_faces(mesh, view, mesh.room_faces);
    if buffer.ids.len() != twin.ids.len() {
        let lengths = [buffer, &twin].map(|drawn| drawn.ids.len() as u32);
        return tally.add(source, [0, PIXEL_COUNT], lengths, f64::NAN);
    }
    let differing: Vec<usize> = (0..twin.ids.len()).filter(|k| twin.ids[*k] != buffer.ids[*k]).collect();
    tally.add_equal((twin.ids.len() - differing.len()) as u64);
    for k in differing {
        let ids = [buffer.ids[k], twin.ids[k]];
        let wrong = !may_show(mesh, view, k as u32, ids[0]);
        tally.add(source, [k, FACE_NUMBER], ids, f64::from(u8::from(wrong)));
    }
}

/// Checks some boundary pixels of a view, where errors are most likely.
pub fn check_boundary_pixels(
    mesh: &Mesh,
    view: &ShooterView,
    buffer: &ItemBuffer,
    source: ValueSource,
    tally: &mut ErrorTally,
) {
    let all: Vec<usize> = boundary_pixels(buffer).collect();
    let step = all.len().div_ceil(MAX_PIXELS_PER_VIEW).max(1);
    let checked: Vec<usize> = all.into_iter().step_by(step).collect();
    let of = |k: &usize| !may_show(mesh, view, *k as u32, buffer.ids[*k]);
    let wrong: Vec<bool> = checked.par_iter().map(of).collect();
    for (k, wrong) in checked.into_iter().zip(wrong) {
        let shown = |id: &u32| may_show(mesh, view, k as u32, *id);
        let twin = match wrong {
            true => (0..=mesh.faces.len() as u32).find(shown).unwrap_or(0),
            false => buffer.ids[k],
        };
        tally.add(
            source,
            [k, FACE_NUMBER],
            [buffer.ids[k], twin],
            f64::from(u8::from(wrong)),
        );
    }
}

/// Replaces IDs of no face by 0, so that those that remain are indices.
pub fn remove_unknown_ids(mesh: &Mesh, buffer: &mut ItemBuffer) {
    let unknown = buffer.ids.iter_mut().filter(|id| **id as usize > mesh.faces.len());
    unknown.for_each(|id| *id = 0);
}

/// Iterates over the pixels whose right or lower neighbour has another ID.
pub fn boundary_pixels(buffer: &ItemBuffer) -> impl Iterator<Item = usize> {
    let n = buffer.size as usize;
    let ids = &buffer.ids;
    (0..ids.len())
        .filter(move |k| (k % n + 1 < n && ids[*k] != ids[k + 1]) || (k + n < ids.len() && ids[*k] != ids[k + n]))
}

/// True if pixel `k` may show face `id` − 1, or nothing for 0.
fn may_show(mesh: &Mesh, view: &ShooterView, k: u32, id: u32) -> bool {
    match view.projection {
        ItemBufferProjection::Paper => snapped_triangles::may_show(mesh, view, k, id),
        _ => decided_by_rounding(mesh, view, k, id),
    }
}

/// True if a ray through pixel `k`, moved within rounding, meets `id`.
fn decided_by_rounding(mesh: &Mesh, view: &ShooterView, k: u32, id: u32) -> bool {
    let d = MAX_RAY_ROUNDINGS * f32::EPSILON;
    let moves = [Vec2::ZERO, Vec2::X, -Vec2::X, Vec2::Y, -Vec2::Y];
    moves.into_iter().any(|step| twin_shows(mesh, view, k, step * d, id))
}

/// True if the ray through pixel `k`, moved by `step` on the square −1…1, may meet `id`.
fn twin_shows(mesh: &Mesh, view: &ShooterView, k: u32, step: Vec2, id: u32) -> bool {
    let p = pixel_centre(k % view.size, k / view.size, view.size) + step;
    if !is_covered(view.projection, p, view.size) {
        return id == 0;
    }
    let direction = view.frame.to_world(unproject_point(view.projection, p));
    let slack = MAX_RAY_ROUNDINGS * f32::EPSILON;
    let (mut nearest, mut own_depth) = (f32::INFINITY, None);
    for (face, number) in mesh.faces.iter().zip(1..) {
        if cpu::shader_twins::image_bound::is_hidden_face(view, face) {
            continue;
        }
        let hit = intersect_face(face, view.frame.centre, direction);
        // Within rounding of the outline the face may be there or not.
        if hit.t <= 0.0 || hit.inside < -OUTLINE_MARGIN - slack {
            continue;
        }
        let depth = hit.t * DEPTH_SCALE;
        if number == id {
            own_depth = Some(depth);
        }
        if hit.inside >= -OUTLINE_MARGIN + slack {
            nearest = nearest.min(depth);
        }
    }
    match own_depth {
        Some(depth) => depth <= nearest * (1.0 + slack),
        None => id == 0 && nearest == f32::INFINITY,
    }
}
