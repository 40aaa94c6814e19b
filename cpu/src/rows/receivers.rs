//! The texels as arrays, one per coordinate, for the inner loops of a shot. Neighbours on a face form blocks, each
//! with its rectangle on that face.

use common::mesh::{Mesh, MeshFace, TexelKind};
use glam::{Vec2, Vec3};
use std::ops::Range;

/// Texels per block: a register of 16 f32, or two or four narrower ones.
pub const LANE_COUNT: usize = 16;

/// All texels in the mesh's order, padded by one block of texels without area.
pub struct TexelArrays {
    /// Centres.
    pub centre: [Vec<f32>; 3],
    /// Areas.
    pub area: Vec<f32>,
    /// Grid positions on the faces.
    pub place: [Vec<u32>; 2],
    /// Kinds of outline.
    pub kind: Vec<TexelKind>,
    /// The texels of each face.
    pub faces: Vec<ReceiverFace>,
}

/// The texels of a face.
pub struct ReceiverFace {
    /// Numbers of the texels in the mesh.
    pub texels: Range<usize>,
    /// Their blocks.
    pub blocks: Vec<TexelBlock>,
    /// Lower corner of the rectangle around them.
    pub low: Vec2,
    /// Upper corner of that rectangle.
    pub high: Vec2,
    /// Coordinates on the face.
    pub frame: FaceFrame,
}

/// At most [`LANE_COUNT`] contiguous texels.
#[derive(Clone, Copy, Debug)]
pub struct TexelBlock {
    /// Number of the first texel.
    pub first: usize,
    /// Number of texels.
    pub count: usize,
    /// Lower corner of the rectangle around them, in the face's frame.
    pub low: Vec2,
    /// Upper corner of that rectangle.
    pub high: Vec2,
}

/// Coordinates on a face's plane.
#[derive(Clone, Copy, Debug)]
pub struct FaceFrame {
    origin: Vec3,
    axes: [Vec3; 2],
}

impl FaceFrame {
    /// Makes the frame of a face's plane.
    pub fn new(face: &MeshFace) -> Self {
        Self {
            origin: face.corners[0],
            axes: [face.tangent, face.normal.cross(face.tangent)],
        }
    }

    /// Returns the plane coordinates of a point.
    pub fn project_point(&self, point: Vec3) -> Vec2 {
        let d = point - self.origin;
        Vec2::new(self.axes[0].dot(d), self.axes[1].dot(d))
    }
}

impl TexelArrays {
    /// Copies the texels of `mesh`.
    pub fn new(mesh: &Mesh) -> Self {
        let padding = || std::iter::repeat_n(0.0, LANE_COUNT);
        let coordinate = |axis: usize| {
            let own = mesh.texels.iter().map(|t| t.position[axis]);
            own.chain(padding()).collect()
        };
        let place = |axis: usize| {
            let own = mesh.texels.iter().map(|t| t.lattice_corner[axis]);
            own.chain(std::iter::repeat_n(0, LANE_COUNT)).collect()
        };
        let kinds = mesh.texels.iter().map(|t| t.kind);
        let mut faces = Vec::with_capacity(mesh.faces.len());
        let mut first = 0;
        for (f, face) in (0..).zip(&mesh.faces) {
            let rest = &mesh.texels[first..];
            let count = rest.iter().take_while(|t| t.face == f).count();
            faces.push(ReceiverFace::new(mesh, face, first..first + count));
            first += count;
        }
        Self {
            centre: [0, 1, 2].map(coordinate),
            area: mesh.texels.iter().map(|t| t.area).chain(padding()).collect(),
            place: [0, 1].map(place),
            kind: kinds.chain(std::iter::repeat_n(TexelKind::Quad, LANE_COUNT)).collect(),
            faces,
        }
    }
}

impl ReceiverFace {
    fn new(mesh: &Mesh, face: &MeshFace, texels: Range<usize>) -> Self {
        let frame = FaceFrame::new(face);
        let blocks: Vec<TexelBlock> = texels
            .clone()
            .step_by(LANE_COUNT)
            .map(|first| {
                let count = LANE_COUNT.min(texels.end - first);
                let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
                for texel in &mesh.texels[first..first + count] {
                    for point in grid_square_corners(face, texel.kind, texel.lattice_corner) {
                        low = low.min(frame.project_point(point));
                        high = high.max(frame.project_point(point));
                    }
                }
                TexelBlock {
                    first,
                    count,
                    low,
                    high,
                }
            })
            .collect();
        let low = blocks.iter().map(|b| b.low);
        let high = blocks.iter().map(|b| b.high);
        Self {
            texels,
            low: low.fold(Vec2::INFINITY, Vec2::min),
            high: high.fold(Vec2::NEG_INFINITY, Vec2::max),
            blocks,
            frame,
        }
    }
}

/// Returns the corners of a grid square, which contains a texel of either kind.
fn grid_square_corners(face: &MeshFace, kind: TexelKind, [i, j]: [u32; 2]) -> [Vec3; 4] {
    let [a, b, c, d] = face.corners;
    [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(di, dj)| {
        let u = (i + di) as f32 / face.resolution[0] as f32;
        let v = (j + dj) as f32 / face.resolution[1] as f32;
        if kind == TexelKind::Quad {
            a.lerp(b, u).lerp(d.lerp(c, u), v)
        } else {
            a + (b - a) * u + (c - a) * v
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::{Face, Scene};
    use glam::DVec3;

    /// A tilted quad: corner 0 is the origin of its plane, lengths stay, and corners follow each other counter-clockwise.
    #[test]
    fn plane_coordinates_are_an_isometry() {
        let corner = |u: f64, v: f64| DVec3::new(0.3 + 0.8 * u, 0.1 + 0.2 * u + 0.7 * v, -0.4 * v);
        let corners = [[0.0, 0.0], [2.0, 0.0], [1.5, 1.0], [0.0, 1.0]].map(|[u, v]| corner(u, v));
        let scene = Scene {
            faces: vec![Face::quad("tilted", corners, Vec3::ONE, Vec3::ONE)],
            ..Scene::default()
        };
        let mesh = Mesh::uniform(&scene, 1, 1).unwrap();
        let face = &mesh.faces[0];
        let frame = FaceFrame::new(face);
        let flat = face.corners.map(|corner| frame.project_point(corner));
        assert_eq!(flat[0], Vec2::ZERO);
        // Six roundings of numbers below 2.
        let rounding = 12.0 * f32::EPSILON;
        for (i, j) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            let expected = face.corners[i].distance(face.corners[j]);
            assert!((flat[i].distance(flat[j]) - expected).abs() < rounding, "{flat:?}");
        }
        assert!((flat[1] - flat[0]).perp_dot(flat[3] - flat[0]) > 0.0);
    }
}
