//! Face clusters (Willmott, Heckbert & Garland 1999): faces that are near each other and have similar normals are one
//! source. From afar, where all face the receiver, their irradiance depends on ∫ B n dA only.

use crate::hierarchy::linear_radiosity::LinearRadiosity;
use crate::hierarchy::tree::{TexelTree, TreeNode};
use common::form_factor::Shooter;
use common::mesh::Mesh;
use common::sampling::{outline_point, pcg_hash, sample_coordinate};
use glam::{Mat3, Vec3};
use std::ops::Range;

/// Weight of the normals' extent against the centres' extent (mesh units): a cluster as large as the room is split as
/// soon as one with normals in all directions.
const NORMAL_WEIGHT: f32 = 0.5;
/// Least length of the mean normal by which [`Cluster::turn`] is divided; only links of clusters whose faces turn all
/// ways would be below.
const MIN_MEAN_NORMAL: f32 = 1e-3;
/// A cluster's smaller half holds at least one in this many of its faces.
const MAX_SPLIT_RATIO: usize = 16;

/// Faces that are one source.
#[derive(Clone, Debug)]
pub struct Cluster {
    /// Centroid.
    pub centre: Vec3,
    /// Largest distance of a corner from the centre along each axis.
    pub half: Vec3,
    /// Largest distance of a corner from the centre.
    pub radius: f32,
    /// Area of all faces.
    pub area: f32,
    /// Mean of x², y², z², xy, yz and zx over the area, about the centre.
    pub second_moments: [f32; 6],
    /// Mean of n δᵀ over the area, δ from the centre, divided by the length of the mean normal: how the normal turns
    /// from place to place.
    pub turn: Mat3,
    /// Direction of the mean normal, a unit vector.
    pub axis: Vec3,
    /// Length of the mean normal.
    pub mean_normal: f32,
    /// Cosine of the largest angle between a normal and the axis.
    pub cone: f32,
    /// The two halves.
    pub parts: [ClusterPart; 2],
    /// The faces in [`Clusters::order`].
    pub faces: Range<u32>,
}

/// A part of a cluster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClusterPart {
    /// One face.
    Face(u32),
    /// A smaller cluster, of a higher number.
    Cluster(u32),
}

/// All clusters of a scene.
pub struct Clusters {
    /// All clusters; the first holds all faces.
    pub all: Vec<Cluster>,
    /// All faces; the faces of a cluster are contiguous.
    pub order: Vec<u32>,
    /// Cumulative area in that order, from 0 to all.
    areas: Vec<f64>,
}

impl Clusters {
    /// Builds the clusters of the roots of `tree`.
    pub fn new(mesh: &Mesh, tree: &TexelTree) -> Self {
        let mut order: Vec<u32> = (0..mesh.faces.len() as u32).collect();
        let mut all = Vec::new();
        if order.len() > 1 {
            build_cluster(tree, &mut order, 0, &mut all);
        }
        let mut areas = vec![0.0; order.len() + 1];
        for (k, f) in order.iter().enumerate() {
            areas[k + 1] = areas[k] + f64::from(root_node(tree, *f).shooter.area);
        }
        Self { all, order, areas }
    }

    /// Returns sample point `s` of cluster `k`, uniform over its faces: the face, the position, and the area that the
    /// point represents over the mean.
    pub fn sample_point(&self, tree: &TexelTree, k: u32, s: u32) -> (u32, Vec3, f32) {
        let range = &self.all[k as usize].faces;
        let [first, end] = [range.start as usize, range.end as usize];
        let seeds = [0, 1, 2].map(|n| pcg_hash(pcg_hash(k) ^ n));
        let share = f64::from(sample_coordinate(s, 2, seeds[0]));
        let area = self.areas[first] + share * (self.areas[end] - self.areas[first]);
        let upto = &self.areas[first + 1..end];
        let f = self.order[first + upto.partition_point(|a| *a <= area)];
        let uv = [sample_coordinate(s, 3, seeds[1]), sample_coordinate(s, 0, seeds[2])];
        let at = outline_point(&root_node(tree, f).shooter.corners, uv);
        (f, at.truncate(), at.w)
    }

    /// Appends the radiosity of each cluster to that of the nodes. Mean and slopes hold the x, y and z of ∫ B n dA
    /// over the area; `deviation` is the deviation between faces.
    pub fn pull_radiosity(&self, tree: &TexelTree, radiosity: &mut Vec<LinearRadiosity>) {
        self.pull_sums(tree, radiosity, FlowSums::fit_radiosity);
    }

    /// The same as if each cluster had the mean radiosity of its faces everywhere.
    pub fn pull_constant_radiosity(&self, tree: &TexelTree, radiosity: &mut Vec<LinearRadiosity>) {
        self.pull_sums(tree, radiosity, FlowSums::fit_constant);
    }

    fn pull_sums(
        &self,
        tree: &TexelTree,
        radiosity: &mut Vec<LinearRadiosity>,
        fit: impl Fn(&FlowSums) -> LinearRadiosity,
    ) {
        let first = tree.nodes.len();
        radiosity.resize(first + self.all.len(), LinearRadiosity::default());
        let mut sums = vec![FlowSums::default(); self.all.len()];
        for (k, cluster) in self.all.iter().enumerate().rev() {
            let mut own = FlowSums::default();
            for part in cluster.parts {
                match part {
                    ClusterPart::Cluster(c) => own.add_part(&sums[c as usize]),
                    ClusterPart::Face(f) => {
                        let root = tree.roots[f as usize] as usize;
                        own.add_part(&FlowSums::of_root(&tree.nodes[root], &radiosity[root]));
                    }
                }
            }
            radiosity[first + k] = fit(&own);
            sums[k] = own;
        }
    }
}

/// Sums over a cluster's faces.
#[derive(Clone, Copy, Default)]
struct FlowSums {
    area: f32,
    /// ∫ n dA.
    normal: Vec3,
    /// ∫ B n dA by axis.
    flow: [Vec3; 3],
    /// ∫ B dA.
    light: Vec3,
    /// ∫ B² dA.
    square: Vec3,
}

impl FlowSums {
    fn of_root(root: &TreeNode, source: &LinearRadiosity) -> Self {
        let area = root.shooter.area;
        let [xx, yy, xy] = root.second_moments;
        let [x, y] = source.slope;
        let varies = source.deviation * source.deviation + x * x * xx + y * y * yy + x * y * (2.0 * xy);
        Self {
            area,
            normal: root.shooter.normal * area,
            flow: root.shooter.normal.to_array().map(|n| source.mean * (area * n)),
            light: source.mean * area,
            square: (source.mean * source.mean + varies) * area,
        }
    }

    fn add_part(&mut self, part: &Self) {
        self.area += part.area;
        self.normal += part.normal;
        for (own, part) in self.flow.iter_mut().zip(part.flow) {
            *own += part;
        }
        self.light += part.light;
        self.square += part.square;
    }

    fn fit_radiosity(&self) -> LinearRadiosity {
        if self.area <= 0.0 {
            return LinearRadiosity::default();
        }
        let [x, y, z] = self.flow.map(|flow| flow / self.area);
        let mean = self.light / self.area;
        let rest = (self.square / self.area - mean * mean).max(Vec3::ZERO);
        LinearRadiosity {
            mean: x,
            slope: [y, z],
            deviation: rest.map(f32::sqrt),
        }
    }

    fn fit_constant(&self) -> LinearRadiosity {
        if self.area <= 0.0 {
            return LinearRadiosity::default();
        }
        let mean = self.light / self.area;
        let [x, y, z] = (self.normal / self.area).to_array().map(|n| mean * n);
        LinearRadiosity {
            mean: x,
            slope: [y, z],
            deviation: Vec3::ZERO,
        }
    }
}

/// Returns the means of x², y², z², xy, yz and zx over a triangle or parallelogram, about its centre.
pub fn plane_moments(shooter: &Shooter) -> [f32; 6] {
    let count = if shooter.corners[2] == shooter.corners[3] { 3 } else { 4 };
    let mut sum = [0.0; 6];
    for corner in &shooter.corners[..count] {
        for (sum, product) in sum.iter_mut().zip(axis_products(*corner - shooter.centre)) {
            *sum += product / 12.0;
        }
    }
    sum
}

fn axis_products(d: Vec3) -> [f32; 6] {
    [d.x * d.x, d.y * d.y, d.z * d.z, d.x * d.y, d.y * d.z, d.z * d.x]
}

/// Returns the node of the whole face `f`.
pub fn root_node(tree: &TexelTree, f: u32) -> &TreeNode {
    &tree.nodes[tree.roots[f as usize] as usize]
}

/// Builds the cluster of `faces`, which start at `first` in the order, and sorts them.
fn build_cluster(tree: &TexelTree, faces: &mut [u32], first: u32, all: &mut Vec<Cluster>) -> ClusterPart {
    if let [face] = faces {
        return ClusterPart::Face(*face);
    }
    let k = all.len();
    all.push(enclose_faces(tree, faces, first));
    let middle = partition_faces(tree, faces);
    let (low, high) = faces.split_at_mut(middle);
    let low = build_cluster(tree, low, first, all);
    let high = build_cluster(tree, high, first + middle as u32, all);
    all[k].parts = [low, high];
    ClusterPart::Cluster(k as u32)
}

/// Returns the cluster around `faces`, without its parts.
fn enclose_faces(tree: &TexelTree, faces: &[u32], first: u32) -> Cluster {
    let shooters = || faces.iter().map(|f| &root_node(tree, *f).shooter);
    let (mut area, mut centre, mut axis) = (0.0, Vec3::ZERO, Vec3::ZERO);
    for shooter in shooters() {
        // A face without area still has a position.
        let own = shooter.area.max(1e-12);
        area += own;
        centre += shooter.centre * own;
        axis += shooter.normal * own;
    }
    let mean_normal = (axis.length() / area).max(MIN_MEAN_NORMAL);
    let (centre, axis) = (centre / area, axis.normalize_or_zero());
    let mut second_moments = [0.0; 6];
    let mut turn = Mat3::ZERO;
    for shooter in shooters() {
        let (d, own) = (shooter.centre - centre, shooter.area / area);
        let n = shooter.normal;
        turn += Mat3::from_cols(n * d.x, n * d.y, n * d.z) * (own / mean_normal);
        let within = plane_moments(shooter);
        for (sum, (between, within)) in second_moments.iter_mut().zip(axis_products(d).into_iter().zip(within)) {
            *sum += own * (between + within);
        }
    }
    let corners = || shooters().flat_map(|s| s.corners).map(|c| c - centre);
    let cone = shooters().map(|s| s.normal.dot(axis));
    Cluster {
        centre,
        half: corners().fold(Vec3::ZERO, |half, d| half.max(d.abs())),
        radius: corners().map(Vec3::length).fold(0.0, f32::max),
        area,
        second_moments,
        turn,
        axis,
        mean_normal,
        cone: cone.fold(1.0, f32::min),
        parts: [ClusterPart::Face(0); 2],
        faces: first..first + faces.len() as u32,
    }
}

/// Sorts `faces` along the longest extent, of centres or normals, and returns the number before its middle.
fn partition_faces(tree: &TexelTree, faces: &mut [u32]) -> usize {
    let place = |f: u32, axis: usize| {
        let shooter = &root_node(tree, f).shooter;
        if axis < 3 {
            shooter.centre[axis]
        } else {
            NORMAL_WEIGHT * shooter.normal[axis - 3]
        }
    };
    let (mut axis, mut longest, mut middle) = (0, -1.0, 0.0);
    for a in 0..6 {
        let places = faces.iter().map(|f| place(*f, a));
        let (low, high) = places.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        });
        if high - low > longest {
            (axis, longest, middle) = (a, high - low, 0.5 * (low + high));
        }
    }
    faces.sort_by(|a, b| place(*a, axis).total_cmp(&place(*b, axis)));
    let count = faces.partition_point(|f| place(*f, axis) < middle);
    let least = (faces.len() / MAX_SPLIT_RATIO).max(1);
    count.clamp(least, faces.len() - least)
}
