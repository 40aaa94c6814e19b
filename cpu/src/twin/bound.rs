//! Where the image of a face may lie: a rectangle (low, high) that holds every pixel whose ray
//! meets the face. Twin of `gpu/src/shaders/bound.wgsl`.
//!
//! The coordinates of an image are largest on its outline: the edges above the horizon (above the
//! plane through the shooter that a side of the hemicube is parallel to), and between the points
//! where the outline crosses the horizon the rim. The shooter's centre and the rays are the same
//! for all pixels, so the rectangle alone decides which pixels ask; it may be too large, never
//! too small.

use crate::twin::hemicube::{extent, height, on_side};
use crate::twin::projection::project;
use crate::twin::view::View;
use common::constants::{CONTACT, OUTLINE};
use common::mesh::MeshFace;
use common::settings::Projection;
use glam::{Vec2, Vec3, Vec4};

const NOWHERE: Vec4 = Vec4::new(9.0, 9.0, -9.0, -9.0);
const EVERYWHERE: Vec4 = Vec4::new(-9.0, -9.0, 9.0, 9.0);

/// Below the horizon, the shooter itself, or the far side of a two-sided sheet.
pub fn hidden(view: &View, face: &MeshFace) -> bool {
    let a = face.corners[0] - view.frame.centre;
    let away = face.two_sided && face.normal.dot(a) >= 0.0;
    if face.sheet == view.sheet || face.normal == Vec3::ZERO || away {
        return true;
    }
    let mut highest = -1.0f32;
    for corner in face.corners {
        highest = highest.max(view.frame.to_local(corner).z);
    }
    highest <= CONTACT
}

/// The rectangle on the plane of `side`; empty where low ≥ high in an axis.
pub fn bound(view: &View, face: &MeshFace, side: u32) -> Vec4 {
    if hidden(view, face) {
        return NOWHERE;
    }
    let cube = view.projection == Projection::Hemicube;
    let mut limits = NOWHERE;
    let mut rises = Vec3::ZERO;
    let mut sets = Vec3::ZERO;
    let mut last = view.frame.to_local(face.corners[3]);
    for k in 0..4 {
        let mut a = last;
        let mut b = view.frame.to_local(face.corners[k]);
        last = b;
        let height_a = height(side, a);
        let height_b = height(side, b);
        if height_a < 0.0 && height_b < 0.0 {
            continue;
        }
        let near = nearest(a, b);
        let crossing = a + (b - a) * (height_a / (height_a - height_b));
        if height_a < 0.0 {
            a = crossing;
            rises = crossing;
        } else if height_b < 0.0 {
            b = crossing;
            sets = crossing;
        }
        if near < CONTACT {
            limits = EVERYWHERE;
        } else if cube {
            limits = corner(corner(limits, side, a, near), side, b, near);
        } else {
            limits = arc(view, limits, a, b, 4.0 * OUTLINE / near);
        }
    }
    // A face that crosses the horizon ends on the rim.
    if !cube && rises != sets {
        limits = arc(view, limits, sets, rises, 0.0);
    }
    // Roundings, and rasterisers that snap to 1/256 pixel.
    let pixel = 2.0 / view.size as f32;
    let most = extent(view.projection, side, view.size);
    let low = (low(limits) - pixel).max(low(most) - pixel);
    let high = (high(limits) + pixel).min(high(most) + pixel);
    Vec4::new(low.x, low.y, high.x, high.y)
}

fn low(limits: Vec4) -> Vec2 {
    Vec2::new(limits.x, limits.y)
}

fn high(limits: Vec4) -> Vec2 {
    Vec2::new(limits.z, limits.w)
}

/// Distance of the edge from the shooter: what lies near is seen wide, its outline's margin, too.
fn nearest(a: Vec3, b: Vec3) -> f32 {
    let d = b - a;
    let p = a + d * (-a.dot(d) / d.dot(d).max(1e-24)).clamp(0.0, 1.0);
    p.dot(p).sqrt()
}

/// An edge as seen on the hemisphere, in parts that leave their chords by little.
fn arc(view: &View, limits: Vec4, from_a: Vec3, to_b: Vec3, margin: f32) -> Vec4 {
    let a = unit(from_a);
    let b = unit(to_b);
    let cosine = a.dot(b);
    if cosine > 0.995 {
        return chord(view, limits, a, b, margin);
    }
    if cosine < -0.999 {
        return EVERYWHERE;
    }
    let m = unit(a + b);
    let n = unit(a + m);
    let o = unit(m + b);
    let limits = chord(view, limits, a, n, margin);
    let limits = chord(view, limits, n, m, margin);
    let limits = chord(view, limits, m, o, margin);
    chord(view, limits, o, b, margin)
}

/// Both images of an arc of γ ≤ π/4 bend less than a unit circle: the sagitta is below γ²/8, and
/// that below chord²/7.
fn chord(view: &View, limits: Vec4, a: Vec3, b: Vec3, margin: f32) -> Vec4 {
    let d = b - a;
    let bulge = d.dot(d) / 7.0 + margin;
    let p = project(view.projection, a);
    let q = project(view.projection, b);
    around(limits, p.min(q) - bulge, p.max(q) + bulge)
}

/// A side of the hemicube is a plane: straight edges stay straight. A corner at height 0 is far out.
fn corner(limits: Vec4, side: u32, v: Vec3, near: f32) -> Vec4 {
    let p = on_side(side, v, height(side, v).max(1e-12));
    let margin = 4.0 * OUTLINE / near;
    around(limits, p - margin, p + margin)
}

fn around(limits: Vec4, p: Vec2, q: Vec2) -> Vec4 {
    let low = low(limits).min(p);
    let high = high(limits).max(q);
    Vec4::new(low.x, low.y, high.x, high.y)
}

/// Direction; a corner at the shooter's centre has none.
pub fn unit(v: Vec3) -> Vec3 {
    v / v.dot(v).max(1e-24).sqrt()
}
