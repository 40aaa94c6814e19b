//! Convex bodies and the gap between two of them, by the separating axis theorem.

use glam::DVec3;

/// Edges count as parallel if their cross product is shorter than this share of their lengths.
const MIN_CROSS_SHARE: f64 = 1e-9;

/// The plane n·x = d; n is of unit length and points outwards.
#[derive(Clone, Copy, Debug)]
pub struct BoundingPlane {
    pub normal: DVec3,
    pub offset: f64,
}

impl BoundingPlane {
    fn through(at: DVec3, normal: DVec3) -> Self {
        Self {
            normal,
            offset: normal.dot(at),
        }
    }

    /// Returns the signed distance of a point above the plane.
    pub fn height_above(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// Corners, edges and face planes of a convex body. A flat one also has planes through its edges.
#[derive(Clone, Debug)]
pub struct ConvexBody {
    pub corners: Vec<DVec3>,
    edges: Vec<DVec3>,
    pub planes: Vec<BoundingPlane>,
}

impl ConvexBody {
    /// Builds a prism between two outlines in parallel planes, counter-clockwise as seen from the top.
    /// The planes are in the order bottom, top, walls.
    pub fn from_prism(bottom: &[DVec3], top: &[DVec3]) -> Self {
        let n = bottom.len();
        let corners = [bottom, top].concat();
        let middle = corners.iter().sum::<DVec3>() / (2 * n) as f64;
        let up = double_area(bottom);
        let (mut edges, mut sides) = (Vec::new(), vec![(-up, bottom[0]), (up, top[0])]);
        for k in 0..n {
            let along = [bottom[(k + 1) % n] - bottom[k], top[k] - bottom[k]];
            edges.extend(along);
            sides.push((along[0].cross(along[1]), bottom[k]));
        }
        let outwards = |(normal, at): (DVec3, DVec3)| {
            let normal = normal.normalize();
            let inwards = normal.dot(at - middle) < 0.0;
            BoundingPlane::through(at, if inwards { -normal } else { normal })
        };
        Self {
            corners,
            planes: sides.into_iter().map(outwards).collect(),
            edges,
        }
    }

    /// Builds a flat body.
    pub fn from_outline(outline: &[DVec3]) -> Self {
        let n = outline.len();
        let normal = double_area(outline).normalize();
        let edges: Vec<DVec3> = (0..n).map(|k| outline[(k + 1) % n] - outline[k]).collect();
        let sides = [normal, -normal].map(|normal| BoundingPlane::through(outline[0], normal));
        let rims = (0..n).map(|k| BoundingPlane::through(outline[k], edges[k].cross(normal).normalize()));
        Self {
            corners: outline.to_vec(),
            planes: sides.into_iter().chain(rims).collect(),
            edges,
        }
    }

    /// Returns a lower bound of the distance of two bodies: the widest gap between their projections on
    /// any separating axis, a face normal or the cross product of two edges; negative if they overlap.
    pub fn separation(&self, other: &Self) -> f64 {
        let crossed = self.edges.iter().flat_map(|a| {
            let cross = move |b: &DVec3| {
                let cross = a.cross(*b);
                let least = MIN_CROSS_SHARE * a.length() * b.length();
                (cross.length() > least).then(|| cross.normalize())
            };
            other.edges.iter().filter_map(cross)
        });
        let faces = self.planes.iter().chain(&other.planes).map(|p| p.normal);
        let gap = |axis: DVec3| {
            let ([a, b], [c, d]) = (self.extent_along(axis), other.extent_along(axis));
            (c - b).max(a - d)
        };
        faces.chain(crossed).map(gap).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns the least and greatest coordinate along an axis.
    pub fn extent_along(&self, axis: DVec3) -> [f64; 2] {
        let along = self.corners.iter().map(|c| c.dot(axis));
        along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
            [low.min(x), high.max(x)]
        })
    }

    /// Returns the signed distance of its highest corner above a plane.
    pub fn max_height_above(&self, plane: &BoundingPlane) -> f64 {
        let above = self.corners.iter().map(|c| plane.height_above(*c));
        above.fold(f64::NEG_INFINITY, f64::max)
    }
}

fn double_area(outline: &[DVec3]) -> DVec3 {
    let arms = outline.iter().map(|corner| corner - outline[0]).collect::<Vec<_>>();
    arms[1..].windows(2).map(|pair| pair[0].cross(pair[1])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;

    #[test]
    fn gap_of_cubes_is_measured_along_any_axis() {
        let cube_body = |at: DVec3| {
            let p = |x: f64, y: f64, z: f64| at + DVec3::new(x, y, z);
            let level = |y: f64| [p(0., y, 0.), p(0., y, 1.), p(1., y, 1.), p(1., y, 0.)];
            ConvexBody::from_prism(&level(0.0), &level(1.0))
        };
        let one = cube_body(DVec3::ZERO);
        assert!(
            one.planes
                .iter()
                .all(|plane| plane.height_above(DVec3::splat(0.5)) < 0.0)
        );
        for axis in [DVec3::X, DVec3::NEG_Y, DVec3::Z] {
            for gap in [0.5, 1e-4, 0.0, -0.25] {
                let found = one.separation(&cube_body(axis * (1.0 + gap)));
                assert!(abs_diff_eq!(found, gap, epsilon = 1e-12), "{axis} {gap}");
            }
        }
        // Corner to corner: the true distance is √3·0.1; the face normals give 0.1.
        let corner = cube_body(DVec3::splat(1.1));
        assert!(abs_diff_eq!(one.separation(&corner), 0.1, epsilon = 1e-12));
    }

    #[test]
    fn crossing_edges_are_separated_by_their_common_normal() {
        // Two squares edge on: their edges cross at a distance of 0.1, their boxes overlap.
        let flat = |a: DVec3, b: DVec3, at: DVec3| ConvexBody::from_outline(&[at, at + a, at + a + b, at + b]);
        let one = flat(DVec3::X + DVec3::Y, DVec3::Z, DVec3::ZERO);
        let other = flat(DVec3::X - DVec3::Y, DVec3::Z, DVec3::new(0.0, 1.0, 1.1));
        assert!(abs_diff_eq!(one.separation(&other), 0.1, epsilon = 1e-12));
        let inside = flat(DVec3::X - DVec3::Y, DVec3::Z, DVec3::new(0.0, 1.0, 0.5));
        assert!(one.separation(&inside) < 0.0);
    }
}
