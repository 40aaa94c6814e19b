//! Small convex polygons in the plane, cut along lines.

use glam::DVec2;

/// Corners at most: a texel's four, one for a quad's diagonal, four for a pixel's sides, and room.
const MOST: usize = 12;

/// A convex polygon; without corners where nothing is left of it.
#[derive(Clone, Copy, Debug)]
pub struct Polygon {
    corners: [DVec2; MOST],
    count: usize,
}

impl Polygon {
    /// Of its corners, the first dozen of them.
    pub fn new(corners: impl IntoIterator<Item = DVec2>) -> Self {
        let mut polygon = Self {
            corners: [DVec2::ZERO; MOST],
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

    /// Its corners.
    pub fn corners(&self) -> &[DVec2] {
        &self.corners[..self.count]
    }

    /// With its corners elsewhere.
    pub fn map(&self, to: impl Fn(DVec2) -> DVec2) -> Self {
        Self::new(self.corners().iter().copied().map(to))
    }

    /// The part where `above`, which is linear, is at least 0.
    pub fn cut(&self, above: impl Fn(DVec2) -> f64) -> Self {
        let mut left = Self::new([]);
        for (k, p) in self.corners().iter().enumerate() {
            let q = self.corners[(k + 1) % self.count];
            let [from, to] = [above(*p), above(q)];
            if from >= 0.0 {
                left.push(*p);
            }
            if (from < 0.0) != (to < 0.0) {
                left.push(p.lerp(q, from / (from - to)));
            }
        }
        left
    }

    /// The part within one unit along an axis.
    pub fn strip(&self, axis: usize, low: f64) -> Self {
        self.cut(|p| p[axis] - low).cut(|p| low + 1.0 - p[axis])
    }

    /// Its lowest and highest corners, axis by axis.
    pub fn bounds(&self) -> [DVec2; 2] {
        let corners = self.corners().iter();
        corners.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| {
            [low.min(*p), high.max(*p)]
        })
    }

    /// From where to where it reaches on the line at height `y`; none where it does not.
    pub fn across(&self, y: f64) -> Option<[f64; 2]> {
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

    /// The triangles about its first corner.
    pub fn fan(&self) -> impl Iterator<Item = [DVec2; 3]> {
        let pairs = self.corners().windows(2).skip(1);
        pairs.map(|pair| [self.corners[0], pair[0], pair[1]])
    }

    /// Its area, and the centroid.
    pub fn middle(&self) -> (f64, DVec2) {
        let (mut moment, mut twice) = (DVec2::ZERO, 0.0);
        for [a, b, c] in self.fan() {
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

    fn square() -> Polygon {
        Polygon::new([[0., 0.], [2., 0.], [2., 2.], [0., 2.]].map(DVec2::from))
    }

    #[test]
    fn a_cut_leaves_what_is_above() {
        assert_eq!(square().middle(), (4.0, DVec2::ONE));
        let corner = square().cut(|p| 1.0 - p.x - p.y);
        let (area, centroid) = corner.middle();
        assert!((area - 0.5).abs() < 1e-15);
        assert!((centroid - DVec2::splat(1.0 / 3.0)).length() < 1e-15);
        assert_eq!(square().strip(0, 1.0).middle(), (2.0, DVec2::new(1.5, 1.0)));
        assert!(square().cut(|p| p.x - 3.0).corners().is_empty());
        assert_eq!(square().cut(|p| p.x - 3.0).middle().0, 0.0);
    }

    #[test]
    fn lines_cross_it() {
        assert_eq!(square().across(1.0), Some([0.0, 2.0]));
        assert_eq!(square().across(2.0), Some([0.0, 2.0]));
        assert_eq!(square().across(2.5), None);
        let triangle = Polygon::new([[0., 0.], [4., 0.], [0., 4.]].map(DVec2::from));
        assert_eq!(triangle.across(1.0), Some([0.0, 3.0]));
        assert_eq!(triangle.across(4.0), Some([0.0, 0.0]));
    }
}
