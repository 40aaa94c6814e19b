//! Places the interpolation nodes of a face on the corners of its texels.
//!
//! ```text
//! node (i, j), 0 ≤ i ≤ W, 0 ≤ j ≤ H, lies at (u, v) = (i/W, j/H); on a triangle i + j ≤ N
//! ```

use common::mesh::Mesh;
use common::scene::{Face, Shape};
use common::texel::{triangle_index, triangle_position};
use glam::DVec3;

/// Node (i, j) of a face: a corner of its texels.
pub type GridNode = [u32; 2];

/// Nodes around a quad's texel, counter-clockwise from its lower corner.
const QUAD_RING: [GridNode; 4] = [[0, 0], [1, 0], [1, 1], [0, 1]];
/// Nodes around a triangle's upright texel; the last one fills the array.
const UPRIGHT_RING: [GridNode; 4] = [[0, 0], [1, 0], [0, 1], [0, 1]];
/// Nodes around a triangle's inverted texel; the last one fills the array.
const INVERTED_RING: [GridNode; 4] = [[1, 0], [1, 1], [0, 1], [0, 1]];

/// Face geometry in f64, with the offsets of its nodes and texels in buffers over all faces.
#[derive(Clone, Debug)]
pub struct FaceGrid {
    /// Quad or triangle.
    pub shape: Shape,
    /// Corners in mesh units; a triangle repeats its third.
    pub corners: [DVec3; 4],
    /// Unit front normal; zero on a face without area.
    pub normal: DVec3,
    /// Texels W×H.
    pub size: [u32; 2],
    /// Index of the first node.
    pub first_node: usize,
    /// Index of the first texel, in face order.
    pub first_texel: usize,
}

impl FaceGrid {
    /// Returns the grids of all faces and the total number of nodes.
    pub fn for_all_faces(shapes: &[Face], mesh: &Mesh) -> (Vec<Self>, usize) {
        let (mut first_node, mut first_texel) = (0, 0);
        let mut grids = Vec::with_capacity(mesh.faces.len());
        for (k, face) in mesh.faces.iter().enumerate() {
            grids.push(Self {
                shape: shapes.get(k).map_or(Shape::Quad, |face| face.shape),
                corners: face.corners.map(|p| p.as_dvec3()),
                normal: face.normal.as_dvec3(),
                size: face.resolution,
                first_node,
                first_texel,
            });
            let [w, h] = face.resolution.map(|n| n as usize);
            first_node += (w + 1) * (h + 1);
            first_texel += w * h;
        }
        (grids, first_node)
    }

    /// Returns the number of edges of the outline.
    pub fn edge_count(&self) -> usize {
        match self.shape {
            Shape::Quad => 4,
            Shape::Triangle => 3,
        }
    }

    /// Returns the ends of edge `k` of the outline.
    pub fn edge_ends(&self, k: usize) -> [DVec3; 2] {
        [self.corners[k], self.corners[(k + 1) % self.edge_count()]]
    }

    /// Returns the buffer index of a node.
    pub fn node_index(&self, [i, j]: GridNode) -> usize {
        self.first_node + j as usize * (self.size[0] as usize + 1) + i as usize
    }

    /// Returns the position of a node.
    pub fn node_position(&self, [i, j]: GridNode) -> DVec3 {
        let [w, h] = self.size.map(f64::from);
        self.shape.point_at(self.corners, f64::from(i) / w, f64::from(j) / h)
    }

    /// Returns the nodes of edge `k` from start to end, each with its share s of the edge's length.
    pub fn edge_nodes(&self, k: usize) -> impl Iterator<Item = (f64, GridNode)> + use<> {
        let [w, h] = self.size;
        let (shape, count) = (self.shape, if k.is_multiple_of(2) { w } else { h });
        (0..=count).map(move |i| {
            let node = match (shape, k) {
                (_, 0) => [i, 0],
                (Shape::Quad, 1) => [w, i],
                (Shape::Quad, 2) => [w - i, h],
                (Shape::Triangle, 1) => [w - i, i],
                _ => [0, h - i],
            };
            (f64::from(i) / f64::from(count), node)
        })
    }

    /// Returns the edge of the outline that contains two successive nodes of a ring, and their shares of it.
    pub fn edge_between(&self, from: GridNode, to: GridNode) -> Option<(usize, [f64; 2])> {
        let [w, h] = self.size;
        let share = |i: [u32; 2], n: u32| i.map(|i| f64::from(i) / f64::from(n));
        let ([a, b], [c, d]) = (from, to);
        match self.shape {
            _ if b == 0 && d == 0 => Some((0, share([a, c], w))),
            Shape::Quad if a == w && c == w => Some((1, share([b, d], h))),
            Shape::Quad if b == h && d == h => Some((2, share([w - a, w - c], w))),
            Shape::Quad if a == 0 && c == 0 => Some((3, share([h - b, h - d], h))),
            Shape::Triangle if a + b == w && c + d == w => Some((1, share([b, d], h))),
            Shape::Triangle if a == 0 && c == 0 => Some((2, share([h - b, h - d], h))),
            _ => None,
        }
    }

    /// Returns the nodes around texel `index`, counter-clockwise, and their number.
    pub fn texel_ring(&self, index: u32) -> ([GridNode; 4], usize) {
        let w = self.size[0];
        let ((i, j), ring, count) = match self.shape {
            Shape::Quad => ((index % w, index / w), QUAD_RING, 4),
            Shape::Triangle => match triangle_position(w, index) {
                (i, j, true) => ((i, j), UPRIGHT_RING, 3),
                (i, j, false) => ((i, j), INVERTED_RING, 3),
            },
        };
        (ring.map(|[a, b]| [i + a, j + b]), count)
    }

    /// Returns the texel index within the face that contains a point of the face's plane, or is nearest to it.
    pub fn texel_at(&self, point: DVec3) -> u32 {
        let ([u, v], [w, h]) = (self.locate_point(point), self.size);
        let along = |u: f64, n: u32| ((u * f64::from(n)) as u32).min(n.saturating_sub(1));
        let (i, j) = (along(u, w), along(v, h));
        match self.shape {
            Shape::Quad => j * w + i,
            Shape::Triangle => {
                let i = i.min(w - 1 - j);
                let whole = u * f64::from(w) - f64::from(i) + v * f64::from(h) - f64::from(j) <= 1.0;
                triangle_index(w, i, j, whole || i + j + 1 >= w)
            }
        }
    }

    /// Returns (u, v) of a point of the face's plane, clamped to 0…1; the inverse of [`Shape::point_at`].
    pub fn locate_point(&self, point: DVec3) -> [f64; 2] {
        let [a, b, c, d] = self.corners;
        let cross = |x: DVec3, y: DVec3| self.normal.dot(x.cross(y));
        let (e, h) = (b - a, point - a);
        let [u, v] = match self.shape {
            Shape::Triangle => {
                let f = c - a;
                let area = cross(e, f);
                [cross(h, f) / area, cross(e, h) / area]
            }
            Shape::Quad => {
                let (f, g) = (d - a, a - b + c - d);
                // (h − f v) ∥ (e + g v); the root with a positive Jacobian.
                let (k2, k1, k0) = (cross(g, f), cross(e, f) + cross(h, g), cross(h, e));
                let root = (k1 * k1 - 4.0 * k2 * k0).max(0.0).sqrt();
                let v = if k1 >= 0.0 {
                    -2.0 * k0 / (k1 + root)
                } else {
                    (root - k1) / (2.0 * k2)
                };
                let along = e + g * v;
                [(h - f * v).dot(along) / along.length_squared(), v]
            }
        };
        // A face without area has no (u, v).
        [u, v].map(|x| if x.is_nan() { 0.5 } else { x.clamp(0.0, 1.0) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::Scene;
    use common::texel::{texel_count, texel_outline};
    use glam::Vec3;

    #[test]
    fn texels_and_rings_match_the_mesh() {
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.2 * x - 0.3 * y);
        let scene = Scene {
            faces: vec![
                Face::quad(
                    "q",
                    [p(0., 0.), p(4., 0.), p(3., 2.), p(0.5, 1.)],
                    Vec3::ONE,
                    Vec3::ZERO,
                ),
                // A degenerate edge: (u, v) is ambiguous only there.
                Face::quad("d", [p(5., 0.), p(9., 0.), p(8., 2.), p(8., 2.)], Vec3::ONE, Vec3::ZERO),
                Face::triangle("t", [p(10., 0.), p(14., 0.), p(11., 3.)], Vec3::ONE, Vec3::ZERO),
            ],
            ..Scene::default()
        };
        for n in [1, 2, 3, 7] {
            let mesh = Mesh::uniform(&scene, n, 1).unwrap();
            let (grids, _) = FaceGrid::for_all_faces(&scene.faces, &mesh);
            for texel in &mesh.texels {
                let (grid, face) = (&grids[texel.face as usize], &scene.faces[texel.face as usize]);
                assert_eq!(grid.texel_at(texel.position.as_dvec3()), texel.index);
                let corners = texel_outline(face, [n, n], texel.index);
                let centroid = corners.centroid() - texel.position.as_dvec3() * mesh.unit;
                let (ring, _) = grid.texel_ring(texel.index);
                for (k, corner) in corners.corners().iter().enumerate() {
                    let node = grid.node_position(ring[k]) * mesh.unit;
                    // Mesh corners and centroids are f32 of order 1.
                    assert!((node + centroid - *corner).length() < 1e-5, "{k} {node} {corner}");
                }
            }
            let borders = grids
                .iter()
                .map(|q| (0..q.edge_count()).map(|k| q.edge_nodes(k).count()).sum::<usize>());
            let expected = [4, 4, 3].map(|edges| edges * (n as usize + 1));
            assert!(borders.eq(expected));
            assert_eq!(texel_count([n, n]) as usize, grids[1].first_texel);
        }
    }
}
