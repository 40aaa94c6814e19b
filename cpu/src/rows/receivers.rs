//! The texels as a shot's inner loops read them: an array for each coordinate, in blocks of a few
//! neighbours on one face, each with the rectangle that it covers there.

use common::mesh::{Mesh, MeshFace, TexelKind};
use glam::{Vec2, Vec3};
use std::ops::Range;

/// Texels of a block: a register of 16 f32, or two or four narrower ones.
pub const LANES: usize = 16;

/// All texels, in the mesh's order, and then as many without area as a block may read beyond.
pub struct Receivers {
    /// Centres.
    pub centre: [Vec<f32>; 3],
    /// Areas.
    pub area: Vec<f32>,
    /// Lower corners on the faces' lattices.
    pub place: [Vec<u32>; 2],
    /// Outlines.
    pub kind: Vec<TexelKind>,
    /// By face.
    pub faces: Vec<Receiver>,
}

/// The texels of a face.
pub struct Receiver {
    /// In the mesh.
    pub texels: Range<usize>,
    /// All of them.
    pub blocks: Vec<Block>,
    /// The rectangle around them.
    pub low: Vec2,
    /// Its other corner.
    pub high: Vec2,
    /// Where its plane's coordinates are measured from, and along what.
    pub frame: Frame,
}

/// At most [`LANES`] texels that follow each other.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// The first.
    pub first: usize,
    /// How many.
    pub count: usize,
    /// The rectangle around them, in the face's frame.
    pub low: Vec2,
    /// Its other corner.
    pub high: Vec2,
}

/// Coordinates on a face's plane.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    origin: Vec3,
    axes: [Vec3; 2],
}

impl Frame {
    /// Of a face's plane.
    pub fn new(face: &MeshFace) -> Self {
        Self {
            origin: face.corners[0],
            axes: [face.tangent, face.normal.cross(face.tangent)],
        }
    }

    /// Of a point.
    pub fn of(&self, point: Vec3) -> Vec2 {
        let d = point - self.origin;
        Vec2::new(self.axes[0].dot(d), self.axes[1].dot(d))
    }
}

impl Receivers {
    /// The texels of `mesh`.
    pub fn new(mesh: &Mesh) -> Self {
        let padding = || std::iter::repeat_n(0.0, LANES);
        let coordinate = |axis: usize| {
            let own = mesh.texels.iter().map(|t| t.position[axis]);
            own.chain(padding()).collect()
        };
        let place = |axis: usize| {
            let own = mesh.texels.iter().map(|t| t.place[axis]);
            own.chain(std::iter::repeat_n(0, LANES)).collect()
        };
        let kinds = mesh.texels.iter().map(|t| t.kind);
        let mut faces = Vec::with_capacity(mesh.faces.len());
        let mut first = 0;
        for (f, face) in (0..).zip(&mesh.faces) {
            let rest = &mesh.texels[first..];
            let count = rest.iter().take_while(|t| t.face == f).count();
            faces.push(Receiver::new(mesh, face, first..first + count));
            first += count;
        }
        Self {
            centre: [0, 1, 2].map(coordinate),
            area: mesh
                .texels
                .iter()
                .map(|t| t.area)
                .chain(padding())
                .collect(),
            place: [0, 1].map(place),
            kind: kinds
                .chain(std::iter::repeat_n(TexelKind::Quad, LANES))
                .collect(),
            faces,
        }
    }
}

impl Receiver {
    fn new(mesh: &Mesh, face: &MeshFace, texels: Range<usize>) -> Self {
        let frame = Frame::new(face);
        let blocks: Vec<Block> = texels
            .clone()
            .step_by(LANES)
            .map(|first| {
                let count = LANES.min(texels.end - first);
                let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
                for texel in &mesh.texels[first..first + count] {
                    for point in corners(face, texel.kind, texel.place) {
                        low = low.min(frame.of(point));
                        high = high.max(frame.of(point));
                    }
                }
                Block {
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

/// The corners of the lattice's place, which hold a texel of either kind.
fn corners(face: &MeshFace, kind: TexelKind, [i, j]: [u32; 2]) -> [Vec3; 4] {
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
