//! Where on a receiver's plane a face may occlude a point from some point of a cell: an octagon around
//! the penumbra. The shadows of a convex face from all points of a convex cell lie in the hull
//! of its corners' shadows from the cell's corners.

use crate::occlusion::polygon::{Plane, Polygon};
use crate::occlusion::shaft::WIDER;
use crate::rows::receivers::Receiver;
use glam::{DVec3, Vec2, Vec3, Vec4};

/// Where shadows fall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shadow {
    /// Nowhere.
    Nowhere,
    /// Between these values of u, v, u + v and u − v in the receiver's frame.
    Within(Vec4, Vec4),
    /// Anywhere: the face reaches as high above the receiver as the cell, and stands beside it.
    Anywhere,
}

impl Shadow {
    /// Whether it may touch the rectangle from `low` to `high` in the receiver's frame.
    pub fn falls(&self, from: Vec2, to: Vec2) -> bool {
        match self {
            Self::Nowhere => false,
            Self::Anywhere => true,
            Self::Within(low, high) => {
                let least = Vec4::new(from.x, from.y, from.x + from.y, from.x - to.y);
                let most = Vec4::new(to.x, to.y, to.x + to.y, to.x - from.y);
                low.cmple(most).all() && least.cmple(*high).all()
            }
        }
    }
}

/// What is nearer to the cell than this share of the cell's height casts its shadow too far away.
const NEAREST: f64 = 0.05;

/// The shadow of `occluder` on the plane `plane` of `receiver` from the cell with these `corners`.
pub fn shadow(
    corners: &[Vec3; 4],
    occluder: &Polygon,
    plane: &Plane,
    receiver: &Receiver,
) -> Shadow {
    let cell = corners.map(|c| c.as_dvec3());
    let heights = cell.map(|c| plane.height(c));
    let lowest = heights.into_iter().fold(f64::INFINITY, f64::min);
    let highest = heights.into_iter().fold(0.0, f64::max);
    if lowest <= WIDER {
        return Shadow::Anywhere;
    }
    let raised = |height: f64| Plane {
        offset: plane.offset + height,
        ..*plane
    };
    let part = occluder.above(&raised(-WIDER));
    let part = part.above(&raised(highest + WIDER).reversed());
    if part.is_empty() {
        return Shadow::Nowhere;
    }
    let (near, far) = part.split(&raised((1.0 - NEAREST) * lowest));
    // From the cell's highest corner the least: h/(h − height).
    let farther = highest / (highest - (1.0 - NEAREST) * lowest);
    if !near.is_empty() && !beyond(&near, &cell, receiver, farther as f32) {
        return Shadow::Anywhere;
    }
    if far.is_empty() {
        return Shadow::Nowhere;
    }
    let (mut low, mut high) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
    for (from, above) in cell.iter().zip(heights) {
        for corner in far.corners() {
            let point = cast(*from, above, *corner, plane.height(*corner));
            let place = octagon(receiver.frame.of(point.as_vec3()));
            low = low.min(place);
            high = high.max(place);
        }
    }
    // An outline is wider for rays; its shadow grows with it.
    let margin = Vec4::splat((8.0 * WIDER / NEAREST) as f32);
    Shadow::Within(low - margin, high + margin)
}

/// Whether the shadows of what is almost as high as the cell fall beyond the receiver: they lie
/// `farther` to the side than the face does.
fn beyond(near: &Polygon, cell: &[DVec3; 4], receiver: &Receiver, farther: f32) -> bool {
    let rectangle = |points: &[DVec3]| {
        let places = points.iter().map(|p| receiver.frame.of(p.as_vec3()));
        places.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        })
    };
    let (from, face) = (rectangle(cell), rectangle(near.corners()));
    // Towards higher and towards lower coordinates, less the outline's margin.
    let margin = Vec2::splat(WIDER as f32);
    let up = (face.0 - from.1 - margin).max(Vec2::ZERO) * farther;
    let down = (from.0 - face.1 - margin).max(Vec2::ZERO) * farther;
    let past = (up.cmpgt(Vec2::ZERO) & (from.0 + up).cmpgt(receiver.high + margin))
        | (down.cmpgt(Vec2::ZERO) & (from.1 - down).cmplt(receiver.low - margin));
    past.any()
}

/// u, v, u + v and u − v.
pub fn octagon(p: Vec2) -> Vec4 {
    Vec4::new(p.x, p.y, p.x + p.y, p.x - p.y)
}

fn cast(from: DVec3, above: f64, through: DVec3, height: f64) -> DVec3 {
    from + (through - from) * (above / (above - height))
}
