//! Sixteen neighbours which receive together: texels, coarser nodes, or open parts of texels. Most lie on
//! one face; where faces are small, on several that are near each other.

use crate::rows::lanes::{Lane, Points};
use crate::rows::receivers::{Frame, LANES};
use common::mesh::Mesh;
use common::sampling::{coordinate, fold, hash};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// Blocks of a task: they share what lies between their face and a node.
const TASK: usize = 32;
/// The same of blocks on several faces, which share nothing.
const MIXED: usize = 4;
/// A face with fewer spots shares its block with its neighbours: for so few no shaft pays.
const FEW: usize = LANES;

/// What one lane of a block receives on.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// Its face.
    pub face: u32,
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
    /// The face of each.
    pub faces: [u32; LANES],
    /// How many.
    pub count: usize,
    /// What each lights.
    pub target: [u32; LANES],
    /// What of it counts.
    pub share: [f32; LANES],
    corners: [[Lane; 3]; 4],
    centre: [Lane; 3],
    normal: [Lane; 3],
    triangles: [bool; LANES],
    /// No point of a spot is farther from its centre.
    pub radius: f32,
    /// The middle of all.
    pub middle: Vec3,
    /// No spot reaches farther from it.
    pub reach: f32,
    /// The rectangle around them in the frame of the first one's face.
    pub low: Vec2,
    /// Its other corner.
    pub high: Vec2,
}

impl Block {
    /// Of 1 to 16 spots.
    pub fn new(mesh: &Mesh, spots: &[Spot]) -> Self {
        let frame = Frame::new(&mesh.faces[spots[0].face as usize]);
        let count = spots.len().min(LANES);
        let mut block = Self {
            faces: [0; LANES],
            count,
            target: [0; LANES],
            share: [0.0; LANES],
            corners: [[[0.0; LANES]; 3]; 4],
            centre: [[0.0; LANES]; 3],
            normal: [[0.0; LANES]; 3],
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
            block.faces[l] = spot.face;
            block.target[l] = spot.target;
            block.share[l] = if l < count { spot.share } else { 0.0 };
            block.triangles[l] = is_triangle(spot);
            for axis in 0..3 {
                block.centre[axis][l] = spot.centre[axis];
                block.normal[axis][l] = mesh.faces[spot.face as usize].normal[axis];
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

    /// The face on which all lie.
    pub fn face(&self) -> Option<u32> {
        let alike = self.faces.iter().all(|face| *face == self.faces[0]);
        alike.then_some(self.faces[0])
    }

    /// Of lane `l`.
    #[inline(always)]
    pub fn normal(&self, l: usize) -> Vec3 {
        Vec3::new(self.normal[0][l], self.normal[1][l], self.normal[2][l])
    }

    /// Corner `k` of lane `l`.
    #[inline(always)]
    pub fn corner(&self, k: usize, l: usize) -> Vec3 {
        let [x, y, z] = &self.corners[k];
        Vec3::new(x[l], y[l], z[l])
    }

    /// The centres.
    #[inline(always)]
    pub fn centres(&self) -> Points {
        Points::new(self.centre, [1.0; LANES])
    }

    /// Place `k` of n×n on each spot.
    #[inline(always)]
    pub fn placed(&self, k: u32, n: u32) -> Points {
        self.points(|_, triangle| place_uv(k, n, triangle))
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
            let corners = [0, 1, 2, 3].map(|k| self.corner(k, l));
            let triangle = self.triangles[l];
            let (p, own) = spot_point(corners, triangle, uv(l, triangle));
            for axis in 0..3 {
                at[axis][l] = p[axis];
            }
            weight[l] = own;
        }
        Points::new(at, weight)
    }
}

/// The point (u, v) of a spot, and the area that it stands for over the mean. No branches: lanes ask
/// together.
#[inline(always)]
fn spot_point([a, b, c, d]: [Vec3; 4], triangle: bool, [u, v]: [f32; 2]) -> (Vec3, f32) {
    let (fu, fv) = fold(u, v);
    let low = a * (1.0 - u) + b * u;
    let high = d * (1.0 - u) + c * u;
    let along_u = (b - a) * (1.0 - v) + (c - d) * v;
    let along_v = (d - a) * (1.0 - u) + (c - b) * u;
    let quad = low * (1.0 - v) + high * v;
    let folded = a + (b - a) * fu + (c - a) * fv;
    let area = (c - a).cross(d - b).length() * 0.5;
    let own = along_u.cross(along_v).length() / area.max(1e-30);
    if triangle { (folded, 1.0) } else { (quad, own) }
}

fn is_triangle(spot: &Spot) -> bool {
    spot.corners[2] == spot.corners[3]
}

/// Place `k` of n×n on a spot.
#[inline(always)]
fn place_uv(k: u32, n: u32, triangle: bool) -> [f32; 2] {
    let inset = if triangle { 1.0 / 3.0 } else { 0.5 };
    [
        ((k % n) as f32 + inset) / n as f32,
        ((k / n) as f32 + inset) / n as f32,
    ]
}

/// All blocks of a scene.
pub struct Receivers {
    /// The blocks.
    pub blocks: Vec<Block>,
    /// Some that follow each other: what one thread does at a time. On one face, or each block on several.
    pub tasks: Vec<Range<usize>>,
}

impl Receivers {
    /// Blocks of the `spots` on each face; in `order` neighbours follow each other.
    pub fn new(mesh: &Mesh, order: &[u32], spots: impl Fn(usize) -> Vec<Spot> + Sync) -> Self {
        let by_face: Vec<Vec<Spot>> = (0..mesh.faces.len()).into_par_iter().map(&spots).collect();
        let (mut own, mut shared) = (Vec::new(), Vec::new());
        for spots in order.iter().map(|f| &by_face[*f as usize]) {
            if spots.len() < FEW {
                shared.extend_from_slice(spots);
            } else {
                own.push(spots.as_slice());
            }
        }
        let mut receivers = Self {
            blocks: Vec::new(),
            tasks: Vec::new(),
        };
        for spots in own {
            receivers.add(mesh, spots, TASK);
        }
        receivers.add(mesh, &shared, MIXED);
        receivers
    }

    fn add(&mut self, mesh: &Mesh, spots: &[Spot], task: usize) {
        let chunks = spots.par_chunks(LANES);
        let first = self.blocks.len();
        self.blocks
            .par_extend(chunks.map(|spots| Block::new(mesh, spots)));
        let end = self.blocks.len();
        let tasks = (first..end).step_by(task);
        self.tasks.extend(tasks.map(|k| k..(k + task).min(end)));
    }
}
