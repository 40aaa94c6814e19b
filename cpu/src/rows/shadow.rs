//! Shadow regions: octagons on a receiver's plane around the penumbra of an occluder. The shadows of a convex face from
//! all points of a convex patch lie in the hull of its corners' shadows from the patch's corners. Rows and the refinement
//! of links trace rays only to texels inside a region.

use crate::occlusion::polygon::{ConvexPolygon, OrientedPlane};
use crate::occlusion::shaft::OCCLUDER_MARGIN;
use crate::rows::receivers::ReceiverFace;
use glam::{DVec3, Vec2, Vec3, Vec4};

/// The region in which a shadow may fall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShadowRegion {
    /// No shadow.
    Nowhere,
    /// The octagon between these values of u, v, u + v and u − v in the receiver's frame.
    Within(Vec4, Vec4),
    /// The whole plane: the patch touches it, or a part of the face reaches almost as high as the patch, where shadows
    /// have no bound, and does not certainly cast them beside the receiver.
    Anywhere,
}

impl ShadowRegion {
    /// Returns true if the region may overlap the rectangle from `from` to `to` in the receiver's frame.
    pub fn may_overlap(&self, from: Vec2, to: Vec2) -> bool {
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

/// Share h of the height of the patch's lowest corner. The part of an occluder above 1 − h of that height casts its
/// shadow too far away for an octagon; below, a shadow is at most 1/h times as far from the patch as the occluder.
const MIN_HEIGHT_SHARE: f64 = 0.05;

/// Returns the region of the shadow of `occluder` on the plane of `receiver` from the patch with these `corners`.
pub fn penumbra_region(
    corners: &[Vec3; 4],
    occluder: &ConvexPolygon,
    plane: &OrientedPlane,
    receiver: &ReceiverFace,
) -> ShadowRegion {
    let patch = corners.map(|c| c.as_dvec3());
    let heights = patch.map(|c| plane.height_of(c));
    let lowest = heights.into_iter().fold(f64::INFINITY, f64::min);
    let highest = heights.into_iter().fold(0.0, f64::max);
    if lowest <= OCCLUDER_MARGIN {
        return ShadowRegion::Anywhere;
    }
    let raised = |height: f64| OrientedPlane {
        offset: plane.offset + height,
        ..*plane
    };
    let part = occluder.clip_above(&raised(-OCCLUDER_MARGIN));
    let part = part.clip_above(&raised(highest + OCCLUDER_MARGIN).reversed());
    if part.is_empty() {
        return ShadowRegion::Nowhere;
    }
    let (high_part, low_part) = part.split_by(&raised((1.0 - MIN_HEIGHT_SHARE) * lowest));
    // A shadow from height h stretches distances to the side by h/(h − height), least from the highest corner.
    let min_stretch = highest / (highest - (1.0 - MIN_HEIGHT_SHARE) * lowest);
    if !high_part.is_empty() && !falls_beyond(&high_part, &patch, receiver, min_stretch as f32) {
        return ShadowRegion::Anywhere;
    }
    if low_part.is_empty() {
        return ShadowRegion::Nowhere;
    }
    let (mut low, mut high) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
    for (from, above) in patch.iter().zip(heights) {
        for corner in low_part.corners() {
            let point = cast_shadow(*from, above, *corner, plane.height_of(*corner));
            let place = octagon_coordinates(receiver.frame.project_point(point.as_vec3()));
            low = low.min(place);
            high = high.max(place);
        }
    }
    // Rays treat outlines as wider by the occluder's margin. The shadow is wider by that times the largest stretch,
    // 1/MIN_HEIGHT_SHARE; the factor 8 leaves room for u ± v (√2) and for rays at a slant.
    let margin = Vec4::splat((8.0 * OCCLUDER_MARGIN / MIN_HEIGHT_SHARE) as f32);
    ShadowRegion::Within(low - margin, high + margin)
}

/// Returns true if the shadows of `high_part`, which is almost as high as the patch, certainly fall beside the receiver:
/// their distance to the side of the patch is at least `min_stretch` times that of the occluder.
fn falls_beyond(high_part: &ConvexPolygon, patch: &[DVec3; 4], receiver: &ReceiverFace, min_stretch: f32) -> bool {
    let rectangle = |points: &[DVec3]| {
        let places = points.iter().map(|p| receiver.frame.project_point(p.as_vec3()));
        places.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        })
    };
    let (from, face) = (rectangle(patch), rectangle(high_part.corners()));
    // Towards higher and lower coordinates, less the outline's margin.
    let margin = Vec2::splat(OCCLUDER_MARGIN as f32);
    let up = (face.0 - from.1 - margin).max(Vec2::ZERO) * min_stretch;
    let down = (from.0 - face.1 - margin).max(Vec2::ZERO) * min_stretch;
    let past = (up.cmpgt(Vec2::ZERO) & (from.0 + up).cmpgt(receiver.high + margin))
        | (down.cmpgt(Vec2::ZERO) & (from.1 - down).cmplt(receiver.low - margin));
    past.any()
}

/// Returns u, v, u + v and u − v.
fn octagon_coordinates(p: Vec2) -> Vec4 {
    Vec4::new(p.x, p.y, p.x + p.y, p.x - p.y)
}

/// Projects `through` from `from` to the plane; `above` and `height` are their heights.
fn cast_shadow(from: DVec3, above: f64, through: DVec3, height: f64) -> DVec3 {
    from + (through - from) * (above / (above - height))
}
