//! Planar convex polygons in f64: what the matrix solver clips, measures and integrates over.
//!
//! Corners run counter-clockwise as seen from the front; lengths in the mesh's unit. A polygon
//! lives on the stack: clipping is the inner loop of visibility.

use glam::DVec3;

/// Corners that a polygon can hold. A cut adds at most one to a texel's four.
const MOST: usize = 16;

/// The plane normal · x = offset.
#[derive(Clone, Copy, Debug, Default)]
pub struct Plane {
    /// Towards the positive side; heights are lengths where it is a unit vector.
    pub normal: DVec3,
    /// normal · any point of the plane.
    pub offset: f64,
}

impl Plane {
    /// The plane through `point`.
    pub fn through(point: DVec3, normal: DVec3) -> Self {
        Self {
            normal,
            offset: normal.dot(point),
        }
    }

    /// How far `point` lies on the positive side.
    pub fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// The same plane seen from its other side.
    pub fn reversed(&self) -> Self {
        Self {
            normal: -self.normal,
            offset: -self.offset,
        }
    }
}

/// A planar convex polygon; empty when it has fewer than three corners.
#[derive(Clone, Copy, Debug)]
pub struct Polygon {
    corners: [DVec3; MOST],
    count: usize,
}

impl Polygon {
    /// The empty polygon.
    pub const EMPTY: Self = Self {
        corners: [DVec3::ZERO; MOST],
        count: 0,
    };

    /// The polygon of `corners`, of which the first 16 count.
    pub fn new(corners: &[DVec3]) -> Self {
        let mut polygon = Self::EMPTY;
        polygon.count = corners.len().min(MOST);
        polygon.corners[..polygon.count].copy_from_slice(&corners[..polygon.count]);
        polygon
    }

    /// The corners.
    pub fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    /// Whether nothing is left.
    pub fn is_empty(&self) -> bool {
        self.count < 3
    }

    /// The edges, each from its first to its second corner.
    pub fn edges(&self) -> impl Iterator<Item = [DVec3; 2]> + '_ {
        (0..self.count).map(|k| [self.corners[k], self.corners[self.next(k)]])
    }

    fn next(&self, k: usize) -> usize {
        if k + 1 == self.count { 0 } else { k + 1 }
    }

    /// Along the front, as long as the area.
    pub fn vector_area(&self) -> DVec3 {
        let Some(first) = self.corners().first() else {
            return DVec3::ZERO;
        };
        self.edges()
            .map(|[a, b]| (a - first).cross(b - first))
            .sum::<DVec3>()
            * 0.5
    }

    /// The mean of the area.
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

    /// Lowest and highest corner over `plane`.
    pub fn heights(&self, plane: &Plane) -> [f64; 2] {
        self.corners()
            .iter()
            .map(|p| plane.height(*p))
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], h| {
                [low.min(h), high.max(h)]
            })
    }

    /// The part on the positive side of `plane` (Sutherland & Hodgman 1974).
    pub fn above(&self, plane: &Plane) -> Self {
        self.split(plane).0
    }

    /// The parts on the positive and on the negative side. A cut for which there is no room is not
    /// made: the polygon stays whole on the positive side.
    pub fn split(&self, plane: &Plane) -> (Self, Self) {
        let (mut above, mut below) = (Self::EMPTY, Self::EMPTY);
        let mut heights = [0.0; MOST];
        for (height, corner) in heights.iter_mut().zip(self.corners()) {
            *height = plane.height(*corner);
        }
        if heights[..self.count].iter().all(|h| *h >= 0.0) {
            return (*self, below);
        }
        if heights[..self.count].iter().all(|h| *h <= 0.0) {
            return (above, *self);
        }
        if self.count + 1 >= MOST {
            return (*self, below);
        }
        for k in 0..self.count {
            let (corner, next) = (self.corners[k], self.next(k));
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
        if self.count < MOST {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    /// The polygon as convex pieces of at most four corners; a triangle repeats its third.
    pub fn quads(&self) -> impl Iterator<Item = [DVec3; 4]> + '_ {
        let c = &self.corners;
        (1..self.count.saturating_sub(1))
            .step_by(2)
            .map(|k| [c[0], c[k], c[k + 1], c[(k + 2).min(self.count - 1)]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hexagon() -> Polygon {
        let corners: Vec<DVec3> = (0..6)
            .map(|k| f64::from(k) * std::f64::consts::FRAC_PI_3)
            .map(|phi| DVec3::new(phi.cos(), phi.sin(), 2.0))
            .collect();
        Polygon::new(&corners)
    }

    #[test]
    fn halves_add_up_and_quads_tile() {
        let whole = hexagon();
        let area = whole.vector_area();
        // 3√3/2, and a dozen roundings.
        assert!((area - DVec3::Z * 1.5 * 3f64.sqrt()).length() < 1e-14);
        let cut = Plane::through(DVec3::new(0.1, 0.2, 2.0), DVec3::new(0.6, 0.8, 0.0));
        let (above, below) = whole.split(&cut);
        assert!((above.vector_area() + below.vector_area() - area).length() < 1e-14);
        assert!(above.heights(&cut)[0] > -1e-15 && below.heights(&cut)[1] < 1e-15);
        let moment =
            above.centroid() * above.vector_area().z + below.centroid() * below.vector_area().z;
        assert!((moment / area.z - DVec3::Z * 2.0).length() < 1e-14);
        let quads: DVec3 = whole
            .quads()
            .map(|quad| Polygon::new(&quad).vector_area())
            .sum();
        assert!((quads - area).length() < 1e-14);
    }
}
