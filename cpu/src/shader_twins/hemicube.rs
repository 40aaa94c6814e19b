//! The hemicube unfolded: its top (side 0) is the central square of half the width, the four half sides (1 to 4: x, −x,
//! y, −y) adjoin it. The square's corners stay empty but for the gutters by which sides are widened.

use common::constants::GUTTER_PIXELS;
use common::settings::ItemBufferProjection;
use glam::{Vec2, Vec3, Vec4};

/// Returns the side to which the horizontal direction `p` points.
pub fn facing_side(p: Vec2) -> u32 {
    if p.x.abs() >= p.y.abs() {
        return if p.x >= 0.0 { 1 } else { 2 };
    }
    if p.y >= 0.0 { 3 } else { 4 }
}

/// Returns the outward normal of side 1 to 4.
pub fn side_axis(side: u32) -> Vec2 {
    let sign = if side & 1 == 1 { 1.0 } else { -1.0 };
    if side <= 2 {
        Vec2::new(sign, 0.0)
    } else {
        Vec2::new(0.0, sign)
    }
}

/// Returns `p` in the frame whose x axis is `e`.
pub fn rotate_to_axis(e: Vec2, p: Vec2) -> Vec2 {
    Vec2::new(e.x * p.x + e.y * p.y, e.x * p.y - e.y * p.x)
}

/// Undoes [`rotate_to_axis`].
pub fn rotate_from_axis(e: Vec2, q: Vec2) -> Vec2 {
    Vec2::new(e.x * q.x - e.y * q.y, e.x * q.y + e.y * q.x)
}

/// Returns the component of `v` along the outward normal of a side, z for side 0; it is positive for rays to the side.
/// The round projections use side 0.
pub fn side_height(side: u32, v: Vec3) -> f32 {
    if side == 0 {
        return v.z;
    }
    rotate_to_axis(side_axis(side), v.truncate()).x
}

/// Projects `v` onto a side, in the coordinates of side 1 for the sides 1 to 4.
pub fn project_to_side(side: u32, v: Vec3, height: f32) -> Vec2 {
    if side == 0 {
        return v.truncate() / (2.0 * height);
    }
    let y = rotate_to_axis(side_axis(side), v.truncate()).y;
    Vec2::new(1.0 - v.z / (2.0 * height), y / (2.0 * height))
}

/// Returns a projected point's place on the square.
pub fn unfold_side(side: u32, q: Vec2) -> Vec2 {
    if side == 0 {
        return q;
    }
    rotate_from_axis(side_axis(side), q)
}

/// Returns the part (low, high) of its plane that a side fills; all of the square for a disc.
pub fn side_extent(projection: ItemBufferProjection, side: u32, size: u32) -> Vec4 {
    if projection != ItemBufferProjection::Hemicube {
        return Vec4::new(-1.0, -1.0, 1.0, 1.0);
    }
    if side == 0 {
        return Vec4::new(-0.5, -0.5, 0.5, 0.5);
    }
    let y = 0.5 + 2.0 * GUTTER_PIXELS / size as f32;
    Vec4::new(0.5, -y, 1.0, y)
}
