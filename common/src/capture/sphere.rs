//! Convex polygons on the sphere of directions: cut by planes through the eye, and measured.

use glam::DVec3;

/// Corners that a polygon can have: four, and one more for each of nine cuts.
const MOST: usize = 16;

/// A convex spherical polygon; corners are directions of any length, in either sense of rotation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polygon {
    corners: [DVec3; MOST],
    count: usize,
}

impl Polygon {
    /// A polygon of four corners; some may coincide.
    pub(super) fn quad(corners: [DVec3; 4]) -> Self {
        let mut polygon = Self {
            corners: [DVec3::ZERO; MOST],
            count: 4,
        };
        polygon.corners[..4].copy_from_slice(&corners);
        polygon
    }

    /// The corners.
    pub(super) fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    /// Whether nothing is left.
    pub(super) fn is_empty(&self) -> bool {
        self.count < 3
    }

    /// The part on the side of a plane through the eye to which `normal` points.
    pub(super) fn cut(&self, normal: DVec3) -> Self {
        let mut part = Self {
            corners: [DVec3::ZERO; MOST],
            count: 0,
        };
        let corners = self.corners();
        let Some(mut last) = corners.last().copied() else {
            return part;
        };
        let mut from = last.dot(normal);
        for &corner in corners {
            let to = corner.dot(normal);
            if (from < 0.0) != (to < 0.0) {
                part.push(last.lerp(corner, from / (from - to)));
            }
            if to >= 0.0 {
                part.push(corner);
            }
            (last, from) = (corner, to);
        }
        part
    }

    fn push(&mut self, corner: DVec3) {
        // A convex polygon gains one corner a cut; rounding may add none beyond the array's end.
        if let Some(place) = self.corners.get_mut(self.count) {
            *place = corner;
            self.count += 1;
        }
    }

    /// Solid angle in sr: a fan of triangles (Van Oosterom and Strackee 1983).
    pub(super) fn solid_angle(&self) -> f64 {
        let Some((first, rest)) = self.corners().split_first() else {
            return 0.0;
        };
        let a = first.normalize();
        let fan = rest.windows(2).map(|pair| {
            let (b, c) = (pair[0].normalize(), pair[1].normalize());
            // a × (b − a), not a × b: the corners of a small triangle are nearly parallel.
            let volume = a.dot((b - a).cross(c - a));
            2.0 * volume.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
        });
        fan.sum::<f64>().abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;
    use std::f64::consts::PI;

    #[test]
    fn a_cubes_side_is_a_sixth_and_its_parts_add_up() {
        let p = |x: f64, y: f64| DVec3::new(x, y, 1.0);
        let side = Polygon::quad([p(-1.0, -1.0), p(1.0, -1.0), p(1.0, 1.0), p(-1.0, 1.0)]);
        assert!(abs_diff_eq!(
            side.solid_angle(),
            4.0 * PI / 6.0,
            epsilon = 1e-14
        ));
        for normal in [p(0.3, 0.2), DVec3::new(1.0, 0.1, -0.2), DVec3::X] {
            let parts = side.cut(normal).solid_angle() + side.cut(-normal).solid_angle();
            assert!(
                abs_diff_eq!(parts, side.solid_angle(), epsilon = 1e-14),
                "{normal}"
            );
        }
        assert!(side.cut(DVec3::NEG_Z).is_empty());
    }
}
