//! Faces that are near each other and look the same way shoot as one (face clusters: Willmott, Heckbert
//! & Garland 1999): seen from afar, where all look towards the receiver, only ∫ B n dA of them counts.

use crate::hierarchy::light::Glow;
use crate::hierarchy::tree::{Node, Tree};
use common::mesh::Mesh;
use common::sampling::{coordinate, hash, outline_point};
use glam::Vec3;
use std::ops::Range;

/// What one unit of the normals' spread counts beside one of the places', in the mesh's unit: a cluster
/// as large as the room is cut as soon as one that looks everywhere.
const NORMAL: f32 = 0.5;
/// Of a cluster's faces one half has this share at least.
const SMALLEST: usize = 16;

/// Faces that shoot as one.
#[derive(Clone, Debug)]
pub struct Cluster {
    /// Their middle, weighed with areas.
    pub centre: Vec3,
    /// No corner is farther from it, along the axes and at all.
    pub half: Vec3,
    /// See `half`.
    pub radius: f32,
    /// All.
    pub area: f32,
    /// Mean of x², y², z², xy, yz and zx over the area, about the centre.
    pub spread: [f32; 6],
    /// Where they look on the whole.
    pub axis: Vec3,
    /// Cosine of the largest angle between their normals and the axis.
    pub cone: f32,
    /// Two parts.
    pub parts: [Part; 2],
    /// Its faces in [`Clusters::order`].
    pub faces: Range<u32>,
}

/// A part of a cluster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// One face.
    Face(u32),
    /// A smaller cluster, of a higher number.
    Cluster(u32),
}

/// All clusters of a scene.
pub struct Clusters {
    /// The first holds all faces.
    pub all: Vec<Cluster>,
    /// All faces: neighbours follow each other.
    pub order: Vec<u32>,
    /// Area up to each place in the order, and of all.
    areas: Vec<f64>,
}

impl Clusters {
    /// Of the roots of `tree`.
    pub fn new(mesh: &Mesh, tree: &Tree) -> Self {
        let mut order: Vec<u32> = (0..mesh.faces.len() as u32).collect();
        let mut all = Vec::new();
        let making = Making { tree };
        if order.len() > 1 {
            making.cluster(&mut order, 0, &mut all);
        }
        let mut areas = vec![0.0; order.len() + 1];
        for (k, f) in order.iter().enumerate() {
            areas[k + 1] = areas[k] + f64::from(making.root(*f).shooter.area);
        }
        Self { all, order, areas }
    }

    /// Point `s` of cluster `k`, evenly over its faces: face, place, and the area for which it stands over
    /// the mean.
    pub fn sampled(&self, tree: &Tree, k: u32, s: u32) -> (u32, Vec3, f32) {
        let range = &self.all[k as usize].faces;
        let [first, end] = [range.start as usize, range.end as usize];
        let seeds = [0, 1, 2].map(|n| hash(hash(k) ^ n));
        let share = f64::from(coordinate(s, 2, seeds[0]));
        let area = self.areas[first] + share * (self.areas[end] - self.areas[first]);
        let upto = &self.areas[first + 1..end];
        let f = self.order[first + upto.partition_point(|a| *a <= area)];
        let uv = [coordinate(s, 3, seeds[1]), coordinate(s, 0, seeds[2])];
        let root = &tree.nodes[tree.roots[f as usize] as usize];
        let at = outline_point(&root.shooter.corners, uv);
        (f, at.truncate(), at.w)
    }

    /// The glow of each cluster from those of the nodes, behind which it is put. Mean and slopes are
    /// the x, y and z of ∫ B n dA over the area; `rest` is how the faces differ.
    pub fn pull(&self, tree: &Tree, glows: &mut Vec<Glow>) {
        let first = tree.nodes.len();
        glows.resize(first + self.all.len(), Glow::default());
        let mut sums = vec![Sums::default(); self.all.len()];
        for (k, cluster) in self.all.iter().enumerate().rev() {
            let mut own = Sums::default();
            for part in cluster.parts {
                match part {
                    Part::Cluster(c) => own.add(&sums[c as usize]),
                    Part::Face(f) => {
                        let root = tree.roots[f as usize] as usize;
                        own.add(&Sums::of(&tree.nodes[root], &glows[root]));
                    }
                }
            }
            glows[first + k] = own.glow();
            sums[k] = own;
        }
    }
}

/// Over a cluster's faces.
#[derive(Clone, Copy, Default)]
struct Sums {
    area: f32,
    /// ∫ B n dA: its x, y and z.
    flow: [Vec3; 3],
    /// ∫ B dA, ∫ B² dA.
    light: Vec3,
    square: Vec3,
}

impl Sums {
    fn of(root: &Node, glow: &Glow) -> Self {
        let area = root.shooter.area;
        let [xx, yy, xy] = root.spread;
        let [x, y] = glow.slope;
        let varies = glow.rest * glow.rest + x * x * xx + y * y * yy + x * y * (2.0 * xy);
        Self {
            area,
            flow: root
                .shooter
                .normal
                .to_array()
                .map(|n| glow.mean * (area * n)),
            light: glow.mean * area,
            square: (glow.mean * glow.mean + varies) * area,
        }
    }

    fn add(&mut self, part: &Self) {
        self.area += part.area;
        for (own, part) in self.flow.iter_mut().zip(part.flow) {
            *own += part;
        }
        self.light += part.light;
        self.square += part.square;
    }

    fn glow(&self) -> Glow {
        if self.area <= 0.0 {
            return Glow::default();
        }
        let [x, y, z] = self.flow.map(|flow| flow / self.area);
        let mean = self.light / self.area;
        let rest = (self.square / self.area - mean * mean).max(Vec3::ZERO);
        Glow {
            mean: x,
            slope: [y, z],
            rest: rest.map(f32::sqrt),
        }
    }
}

struct Making<'a> {
    tree: &'a Tree,
}

impl Making<'_> {
    fn root(&self, f: u32) -> &Node {
        &self.tree.nodes[self.tree.roots[f as usize] as usize]
    }

    /// The cluster of `faces`, which stand at `first` in the order; they are put in order.
    fn cluster(&self, faces: &mut [u32], first: u32, all: &mut Vec<Cluster>) -> Part {
        if let [face] = faces {
            return Part::Face(*face);
        }
        let k = all.len();
        all.push(self.around(faces, first));
        let middle = self.parted(faces);
        let (low, high) = faces.split_at_mut(middle);
        let low = self.cluster(low, first, all);
        let high = self.cluster(high, first + middle as u32, all);
        all[k].parts = [low, high];
        Part::Cluster(k as u32)
    }

    fn around(&self, faces: &[u32], first: u32) -> Cluster {
        let shooters = || faces.iter().map(|f| &self.root(*f).shooter);
        let (mut area, mut centre, mut axis) = (0.0, Vec3::ZERO, Vec3::ZERO);
        for shooter in shooters() {
            // What is without area has a place all the same.
            let own = shooter.area.max(1e-12);
            area += own;
            centre += shooter.centre * own;
            axis += shooter.normal * own;
        }
        let (centre, axis) = (centre / area, axis.normalize_or_zero());
        let mut spread = [0.0; 6];
        for shooter in shooters() {
            // A triangle's own spread in its plane is about a sixth of its radius' square.
            let (d, own) = (shooter.centre - centre, shooter.area / area);
            let within = shooter.radius * shooter.radius / 6.0;
            let parts = [
                d.x * d.x + within * (1.0 - shooter.normal.x.powi(2)),
                d.y * d.y + within * (1.0 - shooter.normal.y.powi(2)),
                d.z * d.z + within * (1.0 - shooter.normal.z.powi(2)),
                d.x * d.y,
                d.y * d.z,
                d.z * d.x,
            ];
            for (sum, part) in spread.iter_mut().zip(parts) {
                *sum += own * part;
            }
        }
        let corners = || shooters().flat_map(|s| s.corners).map(|c| c - centre);
        let cone = shooters().map(|s| s.normal.dot(axis));
        Cluster {
            centre,
            half: corners().fold(Vec3::ZERO, |half, d| half.max(d.abs())),
            radius: corners().map(Vec3::length).fold(0.0, f32::max),
            area,
            spread,
            axis,
            cone: cone.fold(1.0, f32::min),
            parts: [Part::Face(0); 2],
            faces: first..first + faces.len() as u32,
        }
    }

    /// Puts those first that lie before the middle of what is longest, of places or normals.
    fn parted(&self, faces: &mut [u32]) -> usize {
        let place = |f: u32, axis: usize| {
            let shooter = &self.root(f).shooter;
            if axis < 3 {
                shooter.centre[axis]
            } else {
                NORMAL * shooter.normal[axis - 3]
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
        let least = (faces.len() / SMALLEST).max(1);
        count.clamp(least, faces.len() - least)
    }
}
