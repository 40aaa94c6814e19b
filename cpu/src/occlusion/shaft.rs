//! The shaft between two convex polygons: their convex hull, and what may enter it
//! (Haines & Wallace 1994, with the hull's own planes instead of those of two boxes).

use crate::occlusion::polygon::{Plane, Polygon};
use common::constants::{CONTACT, OUTLINE};
use glam::DVec3;

/// Rounding of a coordinate (mesh units): what enters the hull by less does not block.
pub const TOUCH: f64 = CONTACT as f64;

/// How far from the hull a face must stay to stop no ray: the outline's margin and the rounding of
/// the crossing.
pub const WIDER: f64 = 8.0 * OUTLINE as f64;

/// Planes with the hull on their positive side, not always all: a shaft may be too wide, never too
/// narrow.
pub struct Shaft {
    ends: [Polygon; 2],
    planes: Vec<Plane>,
    low: DVec3,
    high: DVec3,
}

impl Shaft {
    /// The shaft between two polygons that lie in front of each other's planes.
    pub fn new(a: &Polygon, plane_a: &Plane, b: &Polygon, plane_b: &Plane) -> Self {
        let mut shaft = Self::hull(a, b);
        shaft.planes.extend([*plane_a, *plane_b]);
        shaft
    }

    /// The shaft of rays from `a`, which may lie partly behind `b`: rays start there as well.
    pub fn rays(a: &Polygon, plane_a: &Plane, b: &Polygon, plane_b: &Plane) -> Self {
        let mut shaft = Self::hull(a, b);
        shaft.planes.push(*plane_a);
        if a.heights(plane_b)[0] >= -TOUCH {
            shaft.planes.push(*plane_b);
        }
        shaft
    }

    fn hull(a: &Polygon, b: &Polygon) -> Self {
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
        shaft.supporting(a, b);
        shaft.supporting(b, a);
        shaft
    }

    /// The planes through an edge of `a` and a corner of `b` that have both on one side.
    fn supporting(&mut self, a: &Polygon, b: &Polygon) {
        for [p, q] in a.edges() {
            let along = q - p;
            for corner in b.corners() {
                let normal = along.cross(corner - p).normalize_or_zero();
                if normal == DVec3::ZERO {
                    continue;
                }
                let plane = Plane::through(p, normal);
                let ([a_low, a_high], [b_low, b_high]) = (a.heights(&plane), b.heights(&plane));
                let (low, high) = (a_low.min(b_low), a_high.max(b_high));
                if low >= -TOUCH / 16.0 {
                    self.planes.push(plane);
                    break;
                }
                if high <= TOUCH / 16.0 {
                    self.planes.push(plane.reversed());
                    break;
                }
            }
        }
    }

    /// Whether a box lies outside, where what enters by `touch` does not count.
    pub fn misses_box(&self, low: DVec3, high: DVec3, touch: f64) -> bool {
        if low.cmpgt(self.high + TOUCH).any() || high.cmplt(self.low - TOUCH).any() {
            return true;
        }
        self.planes.iter().any(|plane| {
            let positive = plane.normal.cmpge(DVec3::ZERO);
            plane.height(DVec3::select(positive, high, low)) <= touch
        })
    }

    /// Whether a polygon in `plane` hides nothing of one end from the other.
    pub fn misses(&self, polygon: &Polygon, plane: &Plane) -> bool {
        self.beside(plane, TOUCH) || self.outside(polygon, TOUCH)
    }

    /// Whether a polygon in `plane` stops no ray between points of the ends. A ray whose end
    /// touches the plane is not stopped, and outlines are wider by [`WIDER`].
    pub fn clears(&self, polygon: &Polygon, plane: &Plane) -> bool {
        self.beside(plane, TOUCH / 4.0) || self.outside(polygon, -WIDER)
    }

    /// Whether both ends lie on one side of `plane`.
    fn beside(&self, plane: &Plane, touch: f64) -> bool {
        let [a, b] = self.ends.each_ref().map(|end| end.heights(plane));
        a[0].min(b[0]) >= -touch || a[1].max(b[1]) <= touch
    }

    fn outside(&self, polygon: &Polygon, touch: f64) -> bool {
        let mut sides = self.planes.iter();
        sides.any(|side| polygon.heights(side)[1] <= touch)
    }

    /// Whether a convex polygon in `plane` hides the ends from each other altogether: they lie on
    /// either side of it, and all sight lines between corners pass through it. Any other sight line
    /// crosses the plane at a convex combination of those crossings.
    pub fn hidden_by(&self, polygon: &Polygon, plane: &Plane) -> bool {
        let [a, b] = &self.ends;
        let ([a_low, a_high], [b_low, b_high]) = (a.heights(plane), b.heights(plane));
        let apart = (a_low >= -TOUCH && b_high <= TOUCH && a_high > b_low)
            || (a_high <= TOUCH && b_low >= -TOUCH && b_high > a_low);
        if !apart || a_high.max(b_high) <= TOUCH || a_low.min(b_low) >= -TOUCH {
            return false;
        }
        a.corners().iter().all(|p| {
            b.corners().iter().all(|q| {
                let (h, k) = (plane.height(*p), plane.height(*q));
                let share = if h == k {
                    0.5
                } else {
                    (h / (h - k)).clamp(0.0, 1.0)
                };
                let crossing = *p + (*q - *p) * share;
                polygon
                    .edges()
                    .all(|[c, d]| plane.normal.cross(d - c).dot(crossing - c) >= -1e-12)
            })
        })
    }
}
