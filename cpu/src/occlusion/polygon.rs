//! Planar convex polygons in f64, which the dense solver clips, measures and integrates over.
//!
//! Corners run counter-clockwise as seen from the front; lengths are in mesh units. A polygon
//! lives on the stack, because clipping is the inner loop of visibility.

use glam::DVec3;

/// Maximum number of corners. A cut adds at most one to a texel's four.
const MAX_CORNERS: usize = 16;

/// The plane normal · x = offset.
#[derive(Clone, Copy, Debug, Default)]
pub struct OrientedPlane {
    /// Direction of the positive side; heights are lengths if this is a unit vector.
    pub normal: DVec3,
    /// normal · x for any point x of the plane.
    pub offset: f64,
}

impl OrientedPlane {
    /// Returns the plane through `point`.
    pub fn through_point(point: DVec3, normal: DVec3) -> Self {
        Self {
            normal,
            offset: normal.dot(point),
        }
    }

    /// Returns the signed height of `point`.
    pub fn height_of(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// Returns the same plane with its sides exchanged.
    pub fn reversed(&self) -> Self {
        Self {
            normal: -self.normal,
            offset: -self.offset,
        }
    }
}

/// A planar convex polygon; empty when it has fewer than three corners.
#[derive(Clone, Copy, Debug)]
pub struct ConvexPolygon {
    corners: [DVec3; MAX_CORNERS],
    count: usize,
}

impl ConvexPolygon {
    /// The empty polygon.
    pub const EMPTY: Self = Self {
        corners: [DVec3::ZERO; MAX_CORNERS],
        count: 0,
    };

    /// Makes a polygon of the first 16 `corners`.
    pub fn new(corners: &[DVec3]) -> Self {
        let mut polygon = Self::EMPTY;
        polygon.count = corners.len().min(MAX_CORNERS);
        polygon.corners[..polygon.count].copy_from_slice(&corners[..polygon.count]);
        polygon
    }

    /// Returns the corners.
    pub fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    /// Returns true if the polygon has no area.
    pub fn is_empty(&self) -> bool {
        self.count < 3
    }

    /// Returns the edges, each from its first to its second corner.
    pub fn edges(&self) -> impl Iterator<Item = [DVec3; 2]> + '_ {
        (0..self.count).map(|k| [self.corners[k], self.corners[self.next_index(k)]])
    }

    fn next_index(&self, k: usize) -> usize {
        if k + 1 == self.count { 0 } else { k + 1 }
    }

    /// Returns the vector along the front whose length is the area.
    pub fn vector_area(&self) -> DVec3 {
        let Some(first) = self.corners().first() else {
            return DVec3::ZERO;
        };
        self.edges().map(|[a, b]| (a - first).cross(b - first)).sum::<DVec3>() * 0.5
    }

    /// Returns the centroid.
    pub fn centroid(&self) -> DVec3 {
        let first = self.corners[0];
        let normal = self.vector_area();
        let (mut moment, mut sum) = (DVec3::ZERO, 0.0);
        for [a, b] in self.edges() {
            let weight = (a - first).cross(b - first).dot(normal);
            moment += (a + b + first) / 3.0 * weight;
            sum += weight;
        }
        if sum > 0.0 { moment / sum } else { first }
    }

    /// Returns the lowest and the highest corner's height over `plane`.
    pub fn height_range(&self, plane: &OrientedPlane) -> [f64; 2] {
        self.corners()
            .iter()
            .map(|p| plane.height_of(*p))
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], h| {
                [low.min(h), high.max(h)]
            })
    }

    /// Returns the part on the positive side of `plane` (Sutherland & Hodgman 1974).
    pub fn clip_above(&self, plane: &OrientedPlane) -> Self {
        self.split_by(plane).0
    }

    /// Returns the parts on the positive and on the negative side. A cut that would need too many corners is not made:
    /// the polygon stays whole on the positive side.
    pub fn split_by(&self, plane: &OrientedPlane) -> (Self, Self) {
        let (mut above, mut below) = (Self::EMPTY, Self::EMPTY);
        let mut heights = [0.0; MAX_CORNERS];
        for (height, corner) in heights.iter_mut().zip(self.corners()) {
            *height = plane.height_of(*corner);
        }
        if heights[..self.count].iter().all(|h| *h >= 0.0) {
            return (*self, below);
        }
        if heights[..self.count].iter().all(|h| *h <= 0.0) {
            return (above, *self);
        }
        if self.count + 1 >= MAX_CORNERS {
            return (*self, below);
        }
        for k in 0..self.count {
            let (corner, next) = (self.corners[k], self.next_index(k));
            if heights[k] >= 0.0 {
                above.push(corner);
            }
            if heights[k] <= 0.0 {
                below.push(corner);
            }
            if heights[k] * heights[next] < 0.0 {
                let share = heights[k] / (heights[k] - heights[next]);
                let cut = corner + (self.corners[next] - corner) * share;
                above.push(cut);
                below.push(cut);
            }
        }
        (above, below)
    }

    fn push(&mut self, corner: DVec3) {
        if self.count < MAX_CORNERS {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    /// Returns convex pieces of at most four corners; a triangle repeats its third.
    pub fn quad_pieces(&self) -> impl Iterator<Item = [DVec3; 4]> + '_ {
        let c = &self.corners;
        (1..self.count.saturating_sub(1))
            .step_by(2)
            .map(|k| [c[0], c[k], c[k + 1], c[(k + 2).min(self.count - 1)]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hexagon() -> ConvexPolygon {
        let corners: Vec<DVec3> = (0..6)
            .map(|k| f64::from(k) * std::f64::consts::FRAC_PI_3)
            .map(|phi| DVec3::new(phi.cos(), phi.sin(), 2.0))
            .collect();
        ConvexPolygon::new(&corners)
    }

    #[test]
    fn halves_add_up_and_quads_tile() {
        let whole = hexagon();
        let area = whole.vector_area();
        // 3√3/2 within a dozen roundings.
        assert!((area - DVec3::Z * 1.5 * 3f64.sqrt()).length() < 1e-14);
        let cut = OrientedPlane::through_point(DVec3::new(0.1, 0.2, 2.0), DVec3::new(0.6, 0.8, 0.0));
        let (above, below) = whole.split_by(&cut);
        assert!((above.vector_area() + below.vector_area() - area).length() < 1e-14);
        assert!(above.height_range(&cut)[0] > -1e-15 && below.height_range(&cut)[1] < 1e-15);
        let moment = above.centroid() * above.vector_area().z + below.centroid() * below.vector_area().z;
        assert!((moment / area.z - DVec3::Z * 2.0).length() < 1e-14);
        let quads: DVec3 = whole
            .quad_pieces()
            .map(|quad| ConvexPolygon::new(&quad).vector_area())
            .sum();
        assert!((quads - area).length() < 1e-14);
    }
}
