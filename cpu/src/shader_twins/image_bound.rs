//! Bound of the image of a face: a rectangle (low, high) that holds every pixel whose ray meets the face.
//!
//! The coordinates of an image are largest on its outline: the edges above the horizon (above the
//! plane through the shooter that a side of the hemicube is parallel to), and between the points
//! where the outline crosses the horizon the rim. The shooter's centre and the rays are the same
//! for all pixels, so the rectangle alone decides which pixels are tested; it may be too large, never too small.

use crate::shader_twins::hemicube::{project_to_side, side_extent, side_height};
use crate::shader_twins::projection::project_direction;
use crate::shader_twins::view::ShooterView;
use common::constants::{CONTACT_DISTANCE, OUTLINE_MARGIN};
use common::mesh::MeshFace;
use common::settings::ItemBufferProjection;
use glam::{Vec2, Vec3, Vec4};

const EMPTY_BOUND: Vec4 = Vec4::new(9.0, 9.0, -9.0, -9.0);
const FULL_BOUND: Vec4 = Vec4::new(-9.0, -9.0, 9.0, 9.0);

/// Returns whether a face is below the horizon, the shooter itself, or the far side of a two-sided sheet.
pub fn is_hidden_face(view: &ShooterView, face: &MeshFace) -> bool {
    let a = face.corners[0] - view.frame.centre;
    let away = face.two_sided && face.normal.dot(a) >= 0.0;
    if face.sheet == view.sheet || face.normal == Vec3::ZERO || away {
        return true;
    }
    let mut highest = -1.0f32;
    for corner in face.corners {
        highest = highest.max(view.frame.to_local(corner).z);
    }
    highest <= CONTACT_DISTANCE
}

/// Returns the rectangle on the plane of `side`; empty where low ≥ high in an axis.
pub fn image_bound(view: &ShooterView, face: &MeshFace, side: u32) -> Vec4 {
    if is_hidden_face(view, face) {
        return EMPTY_BOUND;
    }
    let cube = view.projection == ItemBufferProjection::Hemicube;
    let mut limits = EMPTY_BOUND;
    let mut rises = Vec3::ZERO;
    let mut sets = Vec3::ZERO;
    let mut last = view.frame.to_local(face.corners[3]);
    for k in 0..4 {
        let mut a = last;
        let mut b = view.frame.to_local(face.corners[k]);
        last = b;
        let height_a = side_height(side, a);
        let height_b = side_height(side, b);
        if height_a < 0.0 && height_b < 0.0 {
            continue;
        }
        let near = edge_distance(a, b);
        let crossing = a + (b - a) * (height_a / (height_a - height_b));
        if height_a < 0.0 {
            a = crossing;
            rises = crossing;
        } else if height_b < 0.0 {
            b = crossing;
            sets = crossing;
        }
        if near < CONTACT_DISTANCE {
            limits = FULL_BOUND;
        } else if cube {
            limits = bound_corner(bound_corner(limits, side, a, near), side, b, near);
        } else {
            limits = bound_arc(view.projection, limits, a, b, 4.0 * OUTLINE_MARGIN / near);
        }
    }
    // A face that crosses the horizon ends on the rim.
    if !cube && rises != sets {
        limits = bound_arc(view.projection, limits, sets, rises, 0.0);
    }
    // Roundings, and rasterisers that snap to 1/256 pixel.
    let pixel = 2.0 / view.size as f32;
    let most = side_extent(view.projection, side, view.size);
    let low = (lower_corner(limits) - pixel).max(lower_corner(most) - pixel);
    let high = (upper_corner(limits) + pixel).min(upper_corner(most) + pixel);
    Vec4::new(low.x, low.y, high.x, high.y)
}

fn lower_corner(limits: Vec4) -> Vec2 {
    Vec2::new(limits.x, limits.y)
}

fn upper_corner(limits: Vec4) -> Vec2 {
    Vec2::new(limits.z, limits.w)
}

/// Returns the distance of an edge from the shooter: the nearer an edge, the wider its image and its outline's
/// margin.
pub fn edge_distance(a: Vec3, b: Vec3) -> f32 {
    let d = b - a;
    let p = a + d * (-a.dot(d) / d.dot(d).max(1e-24)).clamp(0.0, 1.0);
    p.dot(p).sqrt()
}

/// Returns `limits` with an edge's image on the hemisphere, in arcs that are near their chords.
pub fn bound_arc(projection: ItemBufferProjection, limits: Vec4, from_a: Vec3, to_b: Vec3, margin: f32) -> Vec4 {
    let a = unit_vector(from_a);
    let b = unit_vector(to_b);
    let cosine = a.dot(b);
    if cosine > 0.995 {
        return bound_chord(projection, limits, a, b, margin);
    }
    if cosine < -0.999 {
        return FULL_BOUND;
    }
    let m = unit_vector(a + b);
    let n = unit_vector(a + m);
    let o = unit_vector(m + b);
    let limits = bound_chord(projection, limits, a, n, margin);
    let limits = bound_chord(projection, limits, n, m, margin);
    let limits = bound_chord(projection, limits, m, o, margin);
    bound_chord(projection, limits, o, b, margin)
}

/// Both images of an arc of γ ≤ π/4 bend less than a unit circle: the sagitta is below γ²/8, and
/// that below chord²/7.
fn bound_chord(projection: ItemBufferProjection, limits: Vec4, a: Vec3, b: Vec3, margin: f32) -> Vec4 {
    let d = b - a;
    let bulge = d.dot(d) / 7.0 + margin;
    let p = project_direction(projection, a);
    let q = project_direction(projection, b);
    include_rectangle(limits, p.min(q) - bulge, p.max(q) + bulge)
}

/// Includes a corner on a side of the hemicube, a plane: straight edges stay straight. A corner at height 0 is far out.
pub fn bound_corner(limits: Vec4, side: u32, v: Vec3, near: f32) -> Vec4 {
    let p = project_to_side(side, v, side_height(side, v).max(1e-12));
    let margin = 4.0 * OUTLINE_MARGIN / near;
    include_rectangle(limits, p - margin, p + margin)
}

fn include_rectangle(limits: Vec4, p: Vec2, q: Vec2) -> Vec4 {
    let low = lower_corner(limits).min(p);
    let high = upper_corner(limits).max(q);
    Vec4::new(low.x, low.y, high.x, high.y)
}

/// Returns the direction of `v`; a corner at the shooter's centre has none.
pub fn unit_vector(v: Vec3) -> Vec3 {
    v / v.dot(v).max(1e-24).sqrt()
}
