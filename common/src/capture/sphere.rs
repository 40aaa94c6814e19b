//! Convex polygons on the sphere of directions: cutting by planes through the eye, and solid angles.

use glam::DVec3;

/// Largest number of corners: four, one more for each of nine cuts, and some to spare.
const MAX_CORNERS: usize = 16;

/// A convex spherical polygon. Its corners are directions of any length, in either sense of rotation.
#[derive(Clone, Copy, Debug)]
pub(super) struct SphericalPolygon {
    corners: [DVec3; MAX_CORNERS],
    count: usize,
}

impl SphericalPolygon {
    /// Makes a polygon of four corners, some of which may coincide.
    pub(super) fn from_quad(corners: [DVec3; 4]) -> Self {
        let mut polygon = Self {
            corners: [DVec3::ZERO; MAX_CORNERS],
            count: 4,
        };
        polygon.corners[..4].copy_from_slice(&corners);
        polygon
    }

    /// The corners.
    pub(super) fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    /// Tests if the polygon has no area.
    pub(super) fn is_empty(&self) -> bool {
        self.count < 3
    }

    /// Returns the part on the side of a plane through the eye to which `normal` points.
    pub(super) fn cut_by_plane(&self, normal: DVec3) -> Self {
        let mut part = Self {
            corners: [DVec3::ZERO; MAX_CORNERS],
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
        // A convex polygon gains one corner per cut; rounding adds none beyond the array's end.
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
            // Differences, not a × b: the corners of a small triangle are nearly parallel.
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
    fn cube_side_has_a_sixth_of_the_sphere_and_cut_parts_sum_to_the_whole() {
        let p = |x: f64, y: f64| DVec3::new(x, y, 1.0);
        let side = SphericalPolygon::from_quad([p(-1.0, -1.0), p(1.0, -1.0), p(1.0, 1.0), p(-1.0, 1.0)]);
        assert!(abs_diff_eq!(side.solid_angle(), 4.0 * PI / 6.0, epsilon = 1e-14));
        for normal in [p(0.3, 0.2), DVec3::new(1.0, 0.1, -0.2), DVec3::X] {
            let parts = side.cut_by_plane(normal).solid_angle() + side.cut_by_plane(-normal).solid_angle();
            assert!(abs_diff_eq!(parts, side.solid_angle(), epsilon = 1e-14), "{normal}");
        }
        assert!(side.cut_by_plane(DVec3::NEG_Z).is_empty());
    }
}
