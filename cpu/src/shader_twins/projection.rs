//! Projection of a shooter's hemisphere to the square of the item buffer, and back.
//!
//! Orthographic (the paper's Table 3) keeps projected solid angle, stereographic keeps angles.
//! Both are continued below the horizon, outside the disc, so that an edge that crosses the
//! horizon crosses the rim at the right place; Table 3 folds such an edge back into the disc. The
//! hemicube ([`crate::shader_twins::hemicube`]) keeps edges straight.

pub use common::dispatch::tile_index;

use crate::shader_twins::hemicube::{
    facing_side, project_to_side, rotate_from_axis, rotate_to_axis, side_axis, side_height, unfold_side,
};
use common::constants::GUTTER_PIXELS;
use common::settings::ItemBufferProjection;
use glam::{Vec2, Vec3};

/// Returns the image of a direction in the frame (any length but 0); for `paper` Table 3, lines 4 to 6.
pub fn project_direction(projection: ItemBufferProjection, v: Vec3) -> Vec2 {
    if projection == ItemBufferProjection::Hemicube {
        let side = if v.z >= v.x.abs().max(v.y.abs()) {
            0
        } else {
            facing_side(v.truncate())
        };
        return unfold_side(side, project_to_side(side, v, side_height(side, v)));
    }
    let u = v / v.dot(v).sqrt();
    match projection {
        ItemBufferProjection::Stereographic => u.truncate() / (1.0 + u.z).max(1e-3),
        ItemBufferProjection::Hemisphere => {
            let s = (u.x * u.x + u.y * u.y).sqrt();
            if u.z >= 0.0 {
                u.truncate()
            } else if s > 0.0 {
                u.truncate() * ((2.0 - s) / s)
            } else {
                Vec2::new(2.0, 0.0)
            }
        }
        ItemBufferProjection::Paper | ItemBufferProjection::Hemicube => u.truncate(),
    }
}

/// The direction of a point that is [`is_covered`]; not always of length 1.
pub fn unproject_point(projection: ItemBufferProjection, p: Vec2) -> Vec3 {
    let q = p.x * p.x + p.y * p.y;
    match projection {
        ItemBufferProjection::Hemicube => {
            if p.x.abs().max(p.y.abs()) <= 0.5 {
                return (p * 2.0).extend(1.0);
            }
            let e = side_axis(facing_side(p));
            let side = rotate_to_axis(e, p);
            rotate_from_axis(e, Vec2::new(1.0, 2.0 * side.y)).extend(2.0 - 2.0 * side.x)
        }
        ItemBufferProjection::Stereographic => {
            let z = (1.0 - q) / (1.0 + q);
            (p * (1.0 + z)).extend(z)
        }
        _ => p.extend((1.0 - q).max(0.0).sqrt()),
    }
}

/// Returns whether a point of the square belongs to the image. The hemicube's sides continue a little beyond
/// their folds, so that a lookup finds all neighbours of its pixel.
pub fn is_covered(projection: ItemBufferProjection, p: Vec2, size: u32) -> bool {
    if projection == ItemBufferProjection::Hemicube {
        return p.x.abs().min(p.y.abs()) <= 0.5 + 2.0 * GUTTER_PIXELS / size as f32;
    }
    p.x * p.x + p.y * p.y <= 1.0
}

/// Returns item buffer coordinates of a point of the square −1…1, in pixels from the upper left corner.
pub fn pixel_position(p: Vec2, size: u32) -> Vec2 {
    let n = size as f32;
    Vec2::new((p.x * 0.5 + 0.5) * n, (0.5 - p.y * 0.5) * n)
}

/// Returns the point at the centre of a pixel.
pub fn pixel_centre(x: u32, y: u32, size: u32) -> Vec2 {
    let n = size as f32;
    Vec2::new((x as f32 + 0.5) / n * 2.0 - 1.0, 1.0 - (y as f32 + 0.5) / n * 2.0)
}
