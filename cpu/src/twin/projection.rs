//! The hemisphere of a shooter on the square of the item buffer, and back. Twin of
//! `gpu/src/shaders/projection.wgsl`.
//!
//! Orthographic (the paper's Table 3) keeps projected solid angle, stereographic keeps angles.
//! Both are continued below the horizon, outside the disc, so that an edge that crosses the
//! horizon crosses the rim at the right place; Table 3 folds such an edge back into the disc. The
//! hemicube ([`crate::twin::hemicube`]) keeps edges straight.

use crate::twin::hemicube::{axis, back, height, on_side, place, side_of, turned};
use common::constants::GUTTER;
use common::settings::Projection;
use glam::{Vec2, Vec3};

/// The image of a direction in the frame (any length but 0); for `paper` Table 3, lines 4 to 6.
pub fn project(projection: Projection, v: Vec3) -> Vec2 {
    if projection == Projection::Hemicube {
        let side = if v.z >= v.x.abs().max(v.y.abs()) {
            0
        } else {
            side_of(v.truncate())
        };
        return place(side, on_side(side, v, height(side, v)));
    }
    let u = v / v.dot(v).sqrt();
    match projection {
        Projection::Stereographic(_) => u.truncate() / (1.0 + u.z).max(1e-3),
        Projection::Hemisphere(_) => {
            let s = (u.x * u.x + u.y * u.y).sqrt();
            if u.z >= 0.0 {
                u.truncate()
            } else if s > 0.0 {
                u.truncate() * ((2.0 - s) / s)
            } else {
                Vec2::new(2.0, 0.0)
            }
        }
        Projection::Paper | Projection::Hemicube => u.truncate(),
    }
}

/// The direction of a point that is [`covered`]; not always of length 1.
pub fn unproject(projection: Projection, p: Vec2) -> Vec3 {
    let q = p.x * p.x + p.y * p.y;
    match projection {
        Projection::Hemicube => {
            if p.x.abs().max(p.y.abs()) <= 0.5 {
                return (p * 2.0).extend(1.0);
            }
            let e = axis(side_of(p));
            let side = turned(e, p);
            back(e, Vec2::new(1.0, 2.0 * side.y)).extend(2.0 - 2.0 * side.x)
        }
        Projection::Stereographic(_) => {
            let z = (1.0 - q) / (1.0 + q);
            (p * (1.0 + z)).extend(z)
        }
        _ => p.extend((1.0 - q).max(0.0).sqrt()),
    }
}

/// Whether a point of the square shows anything. The hemicube's sides go on a little beyond their
/// folds, so that a lookup finds all neighbours of its pixel.
pub fn covered(projection: Projection, p: Vec2, size: u32) -> bool {
    if projection == Projection::Hemicube {
        return p.x.abs().min(p.y.abs()) <= 0.5 + 2.0 * GUTTER / size as f32;
    }
    p.x * p.x + p.y * p.y <= 1.0
}

/// Item buffer coordinates of a point of the square −1…1, in pixels from the upper left corner.
pub fn pixels(p: Vec2, size: u32) -> Vec2 {
    let n = size as f32;
    Vec2::new((p.x * 0.5 + 0.5) * n, (0.5 - p.y * 0.5) * n)
}

/// The point at the centre of a pixel.
pub fn pixel_centre(x: u32, y: u32, size: u32) -> Vec2 {
    let n = size as f32;
    Vec2::new(
        (x as f32 + 0.5) / n * 2.0 - 1.0,
        1.0 - (y as f32 + 0.5) / n * 2.0,
    )
}
