//! Where on a face's plane a face may hide a point of it from some point of a cell: the penumbra's
//! outer rectangle. The shadows of a convex face from all points of a convex cell lie in the hull
//! of its corners' shadows from the cell's corners.

use crate::polygon::{Plane, Polygon};
use crate::receivers::Frame;
use crate::shaft::WIDER;
use glam::{DVec3, Vec2, Vec3};

/// Where shadows fall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shadow {
    /// Nowhere.
    Nowhere,
    /// In a rectangle of the receiver's frame.
    Within(Vec2, Vec2),
    /// Anywhere: the face reaches as high above the receiver as the cell.
    Anywhere,
}

/// A corner nearer than this share of the cell's height to it has its shadow too far away.
const NEAREST: f64 = 0.05;

/// The shadow of `occluder` on `receiver` from the cell with these `corners`.
pub fn shadow(corners: &[Vec3; 4], occluder: &Polygon, receiver: &Plane, frame: &Frame) -> Shadow {
    let cell = corners.map(|c| c.as_dvec3());
    let heights = cell.map(|c| receiver.height(c));
    let lowest = heights.into_iter().fold(f64::INFINITY, f64::min);
    let highest = heights.into_iter().fold(0.0, f64::max);
    if lowest <= WIDER {
        return Shadow::Anywhere;
    }
    let part = between(occluder, receiver, highest);
    if part.is_empty() {
        return Shadow::Nowhere;
    }
    if part.heights(receiver)[1] > (1.0 - NEAREST) * lowest {
        return Shadow::Anywhere;
    }
    let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for (from, above) in cell.iter().zip(heights) {
        for corner in part.corners() {
            let point = cast(*from, above, *corner, receiver.height(*corner));
            let place = frame.of(point.as_vec3());
            low = low.min(place);
            high = high.max(place);
        }
    }
    // An outline is wider for rays; its shadow grows with it.
    let margin = Vec2::splat((4.0 * WIDER / NEAREST) as f32);
    Shadow::Within(low - margin, high + margin)
}

/// The part of `occluder` between the receiver and the cell's highest corner.
fn between(occluder: &Polygon, receiver: &Plane, highest: f64) -> Polygon {
    let floor = Plane {
        offset: receiver.offset - WIDER,
        ..*receiver
    };
    let ceiling = Plane {
        offset: receiver.offset + highest + WIDER,
        ..*receiver
    };
    occluder.above(&floor).above(&ceiling.reversed())
}

fn cast(from: DVec3, above: f64, through: DVec3, height: f64) -> DVec3 {
    from + (through - from) * (above / (above - height))
}
