//! Blocks of sixteen receiver spots, one per lane: texels, coarser nodes, or open parts of texels. Most blocks lie on
//! one face; small faces that are near each other share blocks.

use crate::hierarchy::tree::TexelTree;
use crate::rows::lane_points::{LanePoints, LaneValues};
use crate::rows::receivers::{FaceFrame, LANE_COUNT};
use crate::space_curve::sort_along_curve;
use common::mesh::{Mesh, MeshFace};
use common::sampling::{fold_triangle, pcg_hash, sample_coordinate};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// Blocks of a task on one face: they share the occluders between their face and a node.
const BLOCKS_PER_TASK: usize = 32;
/// Blocks of a task on several faces, which share nothing.
const MIXED_BLOCKS_PER_TASK: usize = 4;
/// A face with fewer spots shares its block with other faces: a shaft costs more than it saves.
const MIN_FACE_SPOTS: usize = LANE_COUNT;

/// A receiver of one lane.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// Number of the face.
    pub face: u32,
    /// Number of the node whose irradiance this is.
    pub target: u32,
    /// Share of the node's area.
    pub share: f32,
    /// Outline; a triangle repeats its third corner.
    pub corners: [Vec3; 4],
    /// Centre.
    pub centre: Vec3,
}

impl Spot {
    /// Takes the whole of node `k`.
    pub fn of_node(tree: &TexelTree, k: u32) -> Self {
        let node = &tree.nodes[k as usize];
        Self {
            face: node.face,
            target: k,
            share: 1.0,
            corners: node.shooter.corners,
            centre: node.shooter.centre,
        }
    }
}

/// Up to `LANE_COUNT` spots as arrays over lanes.
#[derive(Clone, Debug)]
pub struct ReceiverBlock {
    /// Face of each spot.
    pub faces: [u32; LANE_COUNT],
    /// Number of spots.
    pub count: usize,
    /// Node of each spot.
    pub target: [u32; LANE_COUNT],
    /// Share of that node's area.
    pub share: [f32; LANE_COUNT],
    corners: [[LaneValues; 3]; 4],
    centre: [LaneValues; 3],
    normal: [LaneValues; 3],
    triangles: [bool; LANE_COUNT],
    /// Largest distance of a spot's corner from the spot's centre.
    pub radius: f32,
    /// Mean of the centres.
    pub mean_centre: Vec3,
    /// Largest distance of a corner from `mean_centre`.
    pub reach: f32,
    /// Lower corner of the rectangle around all spots, in the frame of the first spot's face.
    pub low: Vec2,
    /// Upper corner of that rectangle.
    pub high: Vec2,
}

impl ReceiverBlock {
    /// Makes a block of 1 to 16 spots.
    pub fn new(mesh: &Mesh, spots: &[Spot]) -> Self {
        let frame = FaceFrame::new(&mesh.faces[spots[0].face as usize]);
        let count = spots.len().min(LANE_COUNT);
        let mut block = Self {
            faces: [0; LANE_COUNT],
            count,
            target: [0; LANE_COUNT],
            share: [0.0; LANE_COUNT],
            corners: [[[0.0; LANE_COUNT]; 3]; 4],
            centre: [[0.0; LANE_COUNT]; 3],
            normal: [[0.0; LANE_COUNT]; 3],
            triangles: [false; LANE_COUNT],
            radius: 0.0,
            mean_centre: Vec3::ZERO,
            reach: 0.0,
            low: Vec2::INFINITY,
            high: Vec2::NEG_INFINITY,
        };
        for l in 0..LANE_COUNT {
            // The last spot fills the remaining lanes.
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
                block.low = block.low.min(frame.project_point(corner));
                block.high = block.high.max(frame.project_point(corner));
            }
        }
        block.mean_centre = spots[..count].iter().map(|s| s.centre).sum::<Vec3>() / count as f32;
        let from = |p: &Vec3| p.distance(block.mean_centre);
        let corners = spots[..count].iter().flat_map(|s| s.corners);
        block.reach = corners.map(|c| from(&c)).fold(0.0, f32::max);
        block
    }

    /// Returns the face of all spots, if they lie on one.
    pub fn single_face(&self) -> Option<u32> {
        let alike = self.faces.iter().all(|face| *face == self.faces[0]);
        alike.then_some(self.faces[0])
    }

    /// Returns the normal of lane `l`.
    #[inline(always)]
    pub fn lane_normal(&self, l: usize) -> Vec3 {
        Vec3::new(self.normal[0][l], self.normal[1][l], self.normal[2][l])
    }

    /// Returns corner `k` of lane `l`.
    #[inline(always)]
    pub fn lane_corner(&self, k: usize, l: usize) -> Vec3 {
        let [x, y, z] = &self.corners[k];
        Vec3::new(x[l], y[l], z[l])
    }

    /// Returns the centres.
    #[inline(always)]
    pub fn centre_points(&self) -> LanePoints {
        LanePoints::new(self.centre, [1.0; LANE_COUNT])
    }

    /// Returns point `k` of an n×n grid on each spot.
    #[inline(always)]
    pub fn grid_points(&self, k: u32, n: u32) -> LanePoints {
        self.map_points(|_, triangle| grid_uv(k, n, triangle))
    }

    /// Returns sample point `s` of each spot against node `node`.
    #[inline(always)]
    pub fn sample_points(&self, s: u32, node: u32) -> LanePoints {
        let seed = pcg_hash(node);
        self.map_points(|l, _| {
            let first = pcg_hash(self.target[l] ^ seed);
            let second = pcg_hash(first);
            [sample_coordinate(s, 0, first), sample_coordinate(s, 1, second)]
        })
    }

    #[inline(always)]
    fn map_points(&self, uv: impl Fn(usize, bool) -> [f32; 2]) -> LanePoints {
        let (mut at, mut weight) = ([[0.0; LANE_COUNT]; 3], [1.0; LANE_COUNT]);
        for l in 0..LANE_COUNT {
            let corners = [0, 1, 2, 3].map(|k| self.lane_corner(k, l));
            let triangle = self.triangles[l];
            let (p, own) = spot_point(corners, triangle, uv(l, triangle));
            for axis in 0..3 {
                at[axis][l] = p[axis];
            }
            weight[l] = own;
        }
        LanePoints::new(at, weight)
    }
}

/// Returns the point (u, v) of a spot and the area that it represents, over the mean. Without branches, because
/// lanes are computed together.
#[inline(always)]
pub fn spot_point([a, b, c, d]: [Vec3; 4], triangle: bool, [u, v]: [f32; 2]) -> (Vec3, f32) {
    let (fu, fv) = fold_triangle(u, v);
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

/// Returns whether a spot repeats its third corner.
pub fn is_triangle(spot: &Spot) -> bool {
    spot.corners[2] == spot.corners[3]
}

/// Returns the (u, v) of point `k` of an n×n grid on a spot.
#[inline(always)]
pub fn grid_uv(k: u32, n: u32, triangle: bool) -> [f32; 2] {
    let inset = if triangle { 1.0 / 3.0 } else { 0.5 };
    [((k % n) as f32 + inset) / n as f32, ((k / n) as f32 + inset) / n as f32]
}

/// All blocks of a scene.
pub struct ReceiverBlocks {
    /// All blocks.
    pub blocks: Vec<ReceiverBlock>,
    /// Contiguous blocks that a thread processes at a time: on one face, or each block on several.
    pub tasks: Vec<Range<usize>>,
}

impl ReceiverBlocks {
    /// Makes the blocks of the `spots` on each face. Faces of few spots share blocks with their neighbours.
    pub fn new(mesh: &Mesh, spots: impl Fn(usize) -> Vec<Spot> + Sync) -> Self {
        let by_face: Vec<Vec<Spot>> = (0..mesh.faces.len()).into_par_iter().map(&spots).collect();
        let (mut own, mut shared) = (Vec::new(), Vec::new());
        for spots in order_faces(mesh).into_iter().map(|f| &by_face[f as usize]) {
            if spots.len() < MIN_FACE_SPOTS {
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
            receivers.add_spots(mesh, spots, BLOCKS_PER_TASK);
        }
        receivers.add_spots(mesh, &shared, MIXED_BLOCKS_PER_TASK);
        receivers
    }

    fn add_spots(&mut self, mesh: &Mesh, spots: &[Spot], task: usize) {
        let chunks = spots.par_chunks(LANE_COUNT);
        let first = self.blocks.len();
        self.blocks
            .par_extend(chunks.map(|spots| ReceiverBlock::new(mesh, spots)));
        let end = self.blocks.len();
        let tasks = (first..end).step_by(task);
        self.tasks.extend(tasks.map(|k| k..(k + task).min(end)));
    }
}

/// Returns the faces in an order in which those of similar normals and places are neighbours.
fn order_faces(mesh: &Mesh) -> Vec<u32> {
    let middle = |face: &MeshFace| face.corners.iter().sum::<Vec3>() / 4.0;
    let middles: Vec<Vec3> = mesh.faces.iter().map(middle).collect();
    let mut order = sort_along_curve(&middles);
    order.sort_by_key(|f| {
        let normal = mesh.faces[*f as usize].normal;
        let axis = normal.abs().max_position();
        (axis, normal[axis] < 0.0)
    });
    order
}
