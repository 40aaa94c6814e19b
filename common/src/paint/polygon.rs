//! Small convex polygons in the plane, and their clipping by lines.

use glam::DVec2;

/// Largest number of corners: a texel's four, one for a quad's diagonal, four for a pixel's sides, and some
/// to spare.
const MAX_CORNERS: usize = 12;

/// A convex polygon; an empty one has no corners.
#[derive(Clone, Copy, Debug)]
pub struct PlanePolygon {
    corners: [DVec2; MAX_CORNERS],
    count: usize,
}

impl PlanePolygon {
    /// Makes a polygon from its corners; corners after the twelfth are dropped.
    pub fn new(corners: impl IntoIterator<Item = DVec2>) -> Self {
        let mut polygon = Self {
            corners: [DVec2::ZERO; MAX_CORNERS],
            count: 0,
        };
        corners.into_iter().for_each(|corner| polygon.push(corner));
        polygon
    }

    fn push(&mut self, corner: DVec2) {
        if let Some(next) = self.corners.get_mut(self.count) {
            *next = corner;
            self.count += 1;
        }
    }

    /// The corners in order.
    pub fn corners(&self) -> &[DVec2] {
        &self.corners[..self.count]
    }

    /// Returns the polygon with every corner mapped by `to`.
    pub fn map_corners(&self, to: impl Fn(DVec2) -> DVec2) -> Self {
        Self::new(self.corners().iter().copied().map(to))
    }

    /// Returns the part on which the linear function `above` is at least 0.
    pub fn clip_by(&self, above: impl Fn(DVec2) -> f64) -> Self {
        let mut part = Self::new([]);
        for (k, p) in self.corners().iter().enumerate() {
            let q = self.corners[(k + 1) % self.count];
            let [from, to] = [above(*p), above(q)];
            if from >= 0.0 {
                part.push(*p);
            }
            if (from < 0.0) != (to < 0.0) {
                part.push(p.lerp(q, from / (from - to)));
            }
        }
        part
    }

    /// Returns the part with coordinate `axis` from `low` to `low` + 1.
    pub fn unit_strip(&self, axis: usize, low: f64) -> Self {
        self.clip_by(|p| p[axis] - low).clip_by(|p| low + 1.0 - p[axis])
    }

    /// Returns the least and the greatest coordinates.
    pub fn bounding_box(&self) -> [DVec2; 2] {
        let corners = self.corners().iter();
        corners.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| {
            [low.min(*p), high.max(*p)]
        })
    }

    /// Returns the range of x on the line at height `y`; `None` if the polygon does not meet it.
    pub fn range_at_height(&self, y: f64) -> Option<[f64; 2]> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (k, p) in self.corners().iter().enumerate() {
            let q = self.corners[(k + 1) % self.count];
            let x = if p.y == y {
                p.x
            } else if (p.y < y) != (q.y < y) && q.y != y {
                p.x + (q.x - p.x) * ((y - p.y) / (q.y - p.y))
            } else {
                continue;
            };
            (low, high) = (low.min(x), high.max(x));
        }
        (low <= high).then_some([low, high])
    }

    /// Returns the triangles of a fan around the first corner.
    pub fn triangle_fan(&self) -> impl Iterator<Item = [DVec2; 3]> {
        let pairs = self.corners().windows(2).skip(1);
        pairs.map(|pair| [self.corners[0], pair[0], pair[1]])
    }

    /// Returns the area and the centroid.
    pub fn area_and_centroid(&self) -> (f64, DVec2) {
        let (mut moment, mut twice) = (DVec2::ZERO, 0.0);
        for [a, b, c] in self.triangle_fan() {
            let own = (b - a).perp_dot(c - a);
            moment += own * ((b - a) + (c - a)) / 3.0;
            twice += own;
        }
        let first = self.corners[0];
        if twice == 0.0 {
            return (0.0, first);
        }
        (0.5 * twice.abs(), first + moment / twice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> PlanePolygon {
        PlanePolygon::new([[0., 0.], [2., 0.], [2., 2.], [0., 2.]].map(DVec2::from))
    }

    #[test]
    fn cut_keeps_the_part_above_the_line() {
        assert_eq!(square().area_and_centroid(), (4.0, DVec2::ONE));
        let corner = square().clip_by(|p| 1.0 - p.x - p.y);
        let (area, centroid) = corner.area_and_centroid();
        assert!((area - 0.5).abs() < 1e-15);
        assert!((centroid - DVec2::splat(1.0 / 3.0)).length() < 1e-15);
        assert_eq!(
            square().unit_strip(0, 1.0).area_and_centroid(),
            (2.0, DVec2::new(1.5, 1.0))
        );
        assert!(square().clip_by(|p| p.x - 3.0).corners().is_empty());
        assert_eq!(square().clip_by(|p| p.x - 3.0).area_and_centroid().0, 0.0);
    }

    #[test]
    fn horizontal_lines_intersect_in_a_range() {
        assert_eq!(square().range_at_height(1.0), Some([0.0, 2.0]));
        assert_eq!(square().range_at_height(2.0), Some([0.0, 2.0]));
        assert_eq!(square().range_at_height(2.5), None);
        let triangle = PlanePolygon::new([[0., 0.], [4., 0.], [0., 4.]].map(DVec2::from));
        assert_eq!(triangle.range_at_height(1.0), Some([0.0, 3.0]));
        assert_eq!(triangle.range_at_height(4.0), Some([0.0, 0.0]));
    }
}
