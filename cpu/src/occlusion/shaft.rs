//! The shaft between two convex polygons (Haines & Wallace 1994): their convex hull, by its own planes instead of those
//! of two boxes.

use crate::occlusion::polygon::{ConvexPolygon, OrientedPlane};
use common::constants::{CONTACT_DISTANCE, OUTLINE_MARGIN};
use glam::DVec3;

/// Rounding of a coordinate (mesh units): a face that enters the hull by less does not occlude.
pub const TOUCH_DISTANCE: f64 = CONTACT_DISTANCE as f64;

/// Least distance from the hull at which a face blocks no ray: the outline's margin and the rounding of
/// the crossing.
pub const OCCLUDER_MARGIN: f64 = 8.0 * OUTLINE_MARGIN as f64;

/// Planes with the hull on their positive side. Some may be missing: a shaft may be too wide, never too
/// narrow.
pub struct Shaft {
    ends: [ConvexPolygon; 2],
    planes: Vec<OrientedPlane>,
    low: DVec3,
    high: DVec3,
}

impl Shaft {
    /// Returns the shaft between two polygons that lie in front of each other's planes.
    pub fn new(a: &ConvexPolygon, plane_a: &OrientedPlane, b: &ConvexPolygon, plane_b: &OrientedPlane) -> Self {
        let mut shaft = Self::from_hull(a, b);
        shaft.planes.extend([*plane_a, *plane_b]);
        shaft
    }

    /// Returns the shaft of rays from `a`, which may lie partly behind `b`: rays start there as well.
    pub fn for_rays(a: &ConvexPolygon, plane_a: &OrientedPlane, b: &ConvexPolygon, plane_b: &OrientedPlane) -> Self {
        let mut shaft = Self::from_hull(a, b);
        shaft.planes.push(*plane_a);
        if a.height_range(plane_b)[0] >= -TOUCH_DISTANCE {
            shaft.planes.push(*plane_b);
        }
        shaft
    }

    fn from_hull(a: &ConvexPolygon, b: &ConvexPolygon) -> Self {
        let mut shaft = Self {
            ends: [*a, *b],
            planes: Vec::with_capacity(12),
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
        };
        for p in a.corners().iter().chain(b.corners()) {
            shaft.low = shaft.low.min(*p);
            shaft.high = shaft.high.max(*p);
        }
        shaft.add_supporting_planes(a, b);
        shaft.add_supporting_planes(b, a);
        shaft
    }

    /// Adds the planes through an edge of `a` and a corner of `b` that have both polygons on one side.
    fn add_supporting_planes(&mut self, a: &ConvexPolygon, b: &ConvexPolygon) {
        for [p, q] in a.edges() {
            let along = q - p;
            for corner in b.corners() {
                let normal = along.cross(corner - p).normalize_or_zero();
                if normal == DVec3::ZERO {
                    continue;
                }
                let plane = OrientedPlane::through_point(p, normal);
                let ([a_low, a_high], [b_low, b_high]) = (a.height_range(&plane), b.height_range(&plane));
                let (low, high) = (a_low.min(b_low), a_high.max(b_high));
                if low >= -TOUCH_DISTANCE / 16.0 {
                    self.planes.push(plane);
                    break;
                }
                if high <= TOUCH_DISTANCE / 16.0 {
                    self.planes.push(plane.reversed());
                    break;
                }
            }
        }
    }

    /// Returns true if a box lies outside or enters by `touch` at most.
    pub fn misses_box(&self, low: DVec3, high: DVec3, touch: f64) -> bool {
        if low.cmpgt(self.high + TOUCH_DISTANCE).any() || high.cmplt(self.low - TOUCH_DISTANCE).any() {
            return true;
        }
        self.planes.iter().any(|plane| {
            let positive = plane.normal.cmpge(DVec3::ZERO);
            plane.height_of(DVec3::select(positive, high, low)) <= touch
        })
    }

    /// Returns true if a polygon in `plane` hides nothing of one end from the other.
    pub fn misses_polygon(&self, polygon: &ConvexPolygon, plane: &OrientedPlane) -> bool {
        self.is_on_one_side(plane, TOUCH_DISTANCE) || self.is_outside(polygon, TOUCH_DISTANCE)
    }

    /// Returns true if a polygon in `plane` blocks no ray between points of the ends. A ray whose end
    /// touches the plane is not blocked, and outlines are wider by [`OCCLUDER_MARGIN`].
    pub fn blocks_no_ray(&self, polygon: &ConvexPolygon, plane: &OrientedPlane) -> bool {
        self.is_on_one_side(plane, TOUCH_DISTANCE / 4.0) || self.is_outside(polygon, -OCCLUDER_MARGIN)
    }

    /// Returns true if both ends lie on one side of `plane`.
    fn is_on_one_side(&self, plane: &OrientedPlane, touch: f64) -> bool {
        let [a, b] = self.ends.each_ref().map(|end| end.height_range(plane));
        a[0].min(b[0]) >= -touch || a[1].max(b[1]) <= touch
    }

    fn is_outside(&self, polygon: &ConvexPolygon, touch: f64) -> bool {
        let mut sides = self.planes.iter();
        sides.any(|side| polygon.height_range(side)[1] <= touch)
    }

    /// Returns true if a convex polygon in `plane` hides the ends from each other wholly: they lie on
    /// either side of it, and all sight lines between corners pass through it. Any other sight line
    /// crosses the plane at a convex combination of those crossings.
    pub fn hidden_by(&self, polygon: &ConvexPolygon, plane: &OrientedPlane) -> bool {
        let [a, b] = &self.ends;
        let ([a_low, a_high], [b_low, b_high]) = (a.height_range(plane), b.height_range(plane));
        let apart = (a_low >= -TOUCH_DISTANCE && b_high <= TOUCH_DISTANCE && a_high > b_low)
            || (a_high <= TOUCH_DISTANCE && b_low >= -TOUCH_DISTANCE && b_high > a_low);
        if !apart || a_high.max(b_high) <= TOUCH_DISTANCE || a_low.min(b_low) >= -TOUCH_DISTANCE {
            return false;
        }
        a.corners().iter().all(|p| {
            b.corners().iter().all(|q| {
                let (h, k) = (plane.height_of(*p), plane.height_of(*q));
                let share = if h == k { 0.5 } else { (h / (h - k)).clamp(0.0, 1.0) };
                let crossing = *p + (*q - *p) * share;
                polygon
                    .edges()
                    .all(|[c, d]| plane.normal.cross(d - c).dot(crossing - c) >= -1e-12)
            })
        })
    }
}
