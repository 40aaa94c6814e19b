//! The hemicube unfolded: its top (side 0) is the inner half of the square, the four half sides (1
//! to 4: x, −x, y, −y) adjoin it, the square's corners stay empty. Twin of
//! `gpu/src/shaders/hemicube.wgsl`.

use common::constants::GUTTER;
use common::settings::Projection;
use glam::{Vec2, Vec3, Vec4};

/// The side to which the horizontal direction `p` points.
pub fn side_of(p: Vec2) -> u32 {
    if p.x.abs() >= p.y.abs() {
        return if p.x >= 0.0 { 1 } else { 2 };
    }
    if p.y >= 0.0 { 3 } else { 4 }
}

/// The direction in which a side lies.
pub fn axis(side: u32) -> Vec2 {
    let sign = if side & 1 == 1 { 1.0 } else { -1.0 };
    if side <= 2 {
        Vec2::new(sign, 0.0)
    } else {
        Vec2::new(0.0, sign)
    }
}

/// `p` turned so that the axis `e` is x.
pub fn turned(e: Vec2, p: Vec2) -> Vec2 {
    Vec2::new(e.x * p.x + e.y * p.y, e.x * p.y - e.y * p.x)
}

/// Undoes [`turned`].
pub fn back(e: Vec2, q: Vec2) -> Vec2 {
    Vec2::new(e.x * q.x - e.y * q.y, e.x * q.y + e.y * q.x)
}

/// Height above the plane that a side (or the disc) is parallel to: where it is positive, rays go
/// there.
pub fn height(side: u32, v: Vec3) -> f32 {
    if side == 0 {
        return v.z;
    }
    turned(axis(side), v.truncate()).x
}

/// The image of `v` on the plane of a side, as if the side lay to the right.
pub fn on_side(side: u32, v: Vec3, height: f32) -> Vec2 {
    if side == 0 {
        return v.truncate() / (2.0 * height);
    }
    let y = turned(axis(side), v.truncate()).y;
    Vec2::new(1.0 - v.z / (2.0 * height), y / (2.0 * height))
}

/// From the plane of a side to the square.
pub fn place(side: u32, q: Vec2) -> Vec2 {
    if side == 0 {
        return q;
    }
    back(axis(side), q)
}

/// The part (low, high) of its plane that a side fills; all of the square for a disc.
pub fn extent(projection: Projection, side: u32, size: u32) -> Vec4 {
    if projection != Projection::Hemicube {
        return Vec4::new(-1.0, -1.0, 1.0, 1.0);
    }
    if side == 0 {
        return Vec4::new(-0.5, -0.5, 0.5, 0.5);
    }
    let y = 0.5 + 2.0 * GUTTER / size as f32;
    Vec4::new(0.5, -y, 1.0, y)
}
