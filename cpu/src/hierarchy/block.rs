//! Sixteen neighbours on a face, which receive together: texels, coarser nodes, or open parts of texels.

use crate::rows::lanes::{Lane, Points};
use crate::rows::receivers::{Frame, LANES};
use common::mesh::Mesh;
use common::sampling::{coordinate, fold, hash};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// Blocks of a task: they share what lies between their face and a node.
const TASK: usize = 32;

/// What one lane of a block receives on.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// Where the light goes.
    pub target: u32,
    /// What of it counts there: the share of a texel's area.
    pub share: f32,
    /// Outline; a triangle repeats its third corner.
    pub corners: [Vec3; 4],
    /// Its centre.
    pub centre: Vec3,
}

/// At most `LANES` spots.
#[derive(Clone, Debug)]
pub struct Block {
    /// Their face.
    pub face: u32,
    /// How many.
    pub count: usize,
    /// What each lights.
    pub target: [u32; LANES],
    /// What of it counts.
    pub share: [f32; LANES],
    corners: [[Lane; 3]; 4],
    centre: [Lane; 3],
    triangles: [bool; LANES],
    /// No point of a spot is farther from its centre.
    pub radius: f32,
    /// The middle of all.
    pub middle: Vec3,
    /// No spot reaches farther from it.
    pub reach: f32,
    /// The rectangle around them in the face's frame.
    pub low: Vec2,
    /// Its other corner.
    pub high: Vec2,
}

impl Block {
    /// Of 1 to 16 spots on `face`.
    pub fn new(mesh: &Mesh, face: u32, spots: &[Spot]) -> Self {
        let frame = Frame::new(&mesh.faces[face as usize]);
        let count = spots.len().min(LANES);
        let mut block = Self {
            face,
            count,
            target: [0; LANES],
            share: [0.0; LANES],
            corners: [[[0.0; LANES]; 3]; 4],
            centre: [[0.0; LANES]; 3],
            triangles: [false; LANES],
            radius: 0.0,
            middle: Vec3::ZERO,
            reach: 0.0,
            low: Vec2::INFINITY,
            high: Vec2::NEG_INFINITY,
        };
        for l in 0..LANES {
            // The last one again where there are fewer.
            let spot = &spots[l.min(count - 1)];
            block.target[l] = spot.target;
            block.share[l] = if l < count { spot.share } else { 0.0 };
            block.triangles[l] = spot.corners[2] == spot.corners[3];
            for axis in 0..3 {
                block.centre[axis][l] = spot.centre[axis];
                for (own, corner) in block.corners.iter_mut().zip(spot.corners) {
                    own[axis][l] = corner[axis];
                }
            }
            for corner in spot.corners {
                block.radius = block.radius.max(corner.distance(spot.centre));
                block.low = block.low.min(frame.of(corner));
                block.high = block.high.max(frame.of(corner));
            }
        }
        block.middle = spots[..count].iter().map(|s| s.centre).sum::<Vec3>() / count as f32;
        let from = |p: &Vec3| p.distance(block.middle);
        let corners = spots[..count].iter().flat_map(|s| s.corners);
        block.reach = corners.map(|c| from(&c)).fold(0.0, f32::max);
        block
    }

    /// The centres.
    #[inline(always)]
    pub fn centres(&self) -> Points {
        Points::new(self.centre, [1.0; LANES])
    }

    /// Place `k` of n×n on each spot.
    #[inline(always)]
    pub fn placed(&self, k: u32, n: u32) -> Points {
        self.points(|_, triangle| {
            let inset = if triangle { 1.0 / 3.0 } else { 0.5 };
            [
                ((k % n) as f32 + inset) / n as f32,
                ((k / n) as f32 + inset) / n as f32,
            ]
        })
    }

    /// Point `s` of each spot as node `node` sees it.
    #[inline(always)]
    pub fn sampled(&self, s: u32, node: u32) -> Points {
        let seed = hash(node);
        self.points(|l, _| {
            let first = hash(self.target[l] ^ seed);
            let second = hash(first);
            [coordinate(s, 0, first), coordinate(s, 1, second)]
        })
    }

    #[inline(always)]
    fn points(&self, uv: impl Fn(usize, bool) -> [f32; 2]) -> Points {
        let (mut at, mut weight) = ([[0.0; LANES]; 3], [1.0; LANES]);
        for l in 0..LANES {
            let corner = |k: usize| {
                Vec3::new(
                    self.corners[k][0][l],
                    self.corners[k][1][l],
                    self.corners[k][2][l],
                )
            };
            let [a, b, c, d] = [corner(0), corner(1), corner(2), corner(3)];
            let [u, v] = uv(l, self.triangles[l]);
            let (fu, fv) = fold(u, v);
            let low = a * (1.0 - u) + b * u;
            let high = d * (1.0 - u) + c * u;
            let along_u = (b - a) * (1.0 - v) + (c - d) * v;
            let along_v = (d - a) * (1.0 - u) + (c - b) * u;
            let quad = low * (1.0 - v) + high * v;
            let triangle = a + (b - a) * fu + (c - a) * fv;
            let p = if self.triangles[l] { triangle } else { quad };
            for axis in 0..3 {
                at[axis][l] = p[axis];
            }
            let area = (c - a).cross(d - b).length() * 0.5;
            let own = along_u.cross(along_v).length() / area.max(1e-30);
            weight[l] = if self.triangles[l] { 1.0 } else { own };
        }
        Points::new(at, weight)
    }
}

/// All blocks of a scene, face after face.
pub struct Receivers {
    /// The blocks.
    pub blocks: Vec<Block>,
    /// Some that follow each other on one face: what one thread does at a time.
    pub tasks: Vec<Range<usize>>,
}

impl Receivers {
    /// Blocks of the `spots` on each face.
    pub fn new(mesh: &Mesh, spots: impl Fn(usize) -> Vec<Spot> + Sync) -> Self {
        let by_face: Vec<Vec<Block>> = (0..mesh.faces.len())
            .into_par_iter()
            .map(|f| {
                let spots = spots(f);
                let chunks = spots.chunks(LANES);
                chunks
                    .map(|spots| Block::new(mesh, f as u32, spots))
                    .collect()
            })
            .collect();
        let (mut blocks, mut tasks) = (Vec::new(), Vec::new());
        for own in by_face {
            let (first, end) = (blocks.len(), blocks.len() + own.len());
            blocks.extend(own);
            tasks.extend((first..end).step_by(TASK).map(|k| k..(k + TASK).min(end)));
        }
        Self { blocks, tasks }
    }
}
