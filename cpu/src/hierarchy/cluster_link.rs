//! The link from a cluster to the spots of a block. With d from the cluster's centre and θ at the receiver,
//!
//! ```text
//! H = κ V cos θ/(π d²) · (d/|d|)·∫ B n dA
//! ```
//! κ corrects for the cluster's extent; V is the mean visibility of point pairs, weighted with their kernels. The axis
//! takes the place of d/|d| where the two are nearly perpendicular. The factors of x, y and z take the places of a node
//! link's factors of mean and slope, so that both links are applied alike.

use crate::hierarchy::block::ReceiverBlock;
use crate::hierarchy::cluster::{Cluster, ClusterPart, Clusters, plane_moments, root_node};
use crate::hierarchy::link::{BlockLink, ExchangeBound, LastBlockers, SampledLink};
use crate::hierarchy::tree::TexelTree;
use crate::rows::lanes::{LanePoints, LaneValues};
use crate::rows::receivers::LANE_COUNT;
use common::constants::{CONTACT_DISTANCE, PI};
use common::mesh::Mesh;
use common::rays::{LineOfSight, Rays};
use glam::{Mat3, Vec3};

/// Share of the faces that may turn away from the receiver or lie below its horizon that does so, for normals and
/// positions that are uniform.
const TURNED_SHARE: f32 = 0.5;

/// Times a cluster is halved for the mean of its kernel: the fourth order of the whole, of one sign in a round room, is
/// left by a sixteenth.
const KERNEL_LEVELS: u32 = 2;

/// Cosine between a cluster's axis and the direction to the receiver below which the flow along the axis counts.
const MIN_OUT_COSINE: f32 = 0.1;

/// A cluster and a receiver block.
pub struct ClusterInteraction<'a> {
    /// Faces.
    pub mesh: &'a Mesh,
    /// Their nodes.
    pub tree: &'a TexelTree,
    /// All clusters.
    pub clusters: &'a Clusters,
    /// All faces, for rays.
    pub rays: &'a Rays,
    /// The cluster's number.
    pub number: u32,
    /// The block.
    pub block: &'a ReceiverBlock,
    /// Sight of the point pairs that count as visible: clear, or hidden by objects alone.
    pub counted: LineOfSight,
    /// The face that blocked each lane's last ray.
    pub last_blockers: &'a LastBlockers,
}

impl ClusterInteraction<'_> {
    fn source_cluster(&self) -> &Cluster {
        &self.clusters.all[self.number as usize]
    }

    /// Returns bounds of the exchange as [`crate::hierarchy::link::BoundTask`] does for a node. Faces that turn away or
    /// lie below a horizon count as a slope.
    pub fn exchange_bound(&self) -> ExchangeBound {
        let cluster = self.source_cluster();
        let block = self.block;
        let sine = (1.0 - cluster.cone * cluster.cone).max(0.0).sqrt();
        let points = block.centre_points();
        let mut most = ExchangeBound::default();
        for l in 0..block.count {
            let normal = block.lane_normal(l);
            let d = points.at(l) - cluster.centre;
            let r = d.length().max(1e-6);
            // Bound of the cosine at a face whose normal is the axis.
            let flat = cluster.half.dot(cluster.axis.abs());
            let along = cluster.axis.dot(d);
            let wide = (cluster.radius + block.radius) / r;
            let own = if cluster.cone >= 0.999_999 {
                (flat + block.radius) / r
            } else {
                wide
            };
            let cosine = (along / r).clamp(-1.0, 1.0);
            let aside = sine * (1.0 - cosine * cosine).max(0.0).sqrt();
            let leaves = if cosine > cluster.cone {
                1.0
            } else {
                (cluster.cone * cosine + aside + own).clamp(0.0, 1.0)
            };
            let turned = (aside + own - cluster.cone * cosine).clamp(0.0, leaves);
            let height = -normal.dot(d);
            let thick = cluster.half.dot(normal.abs());
            if height + thick <= CONTACT_DISTANCE {
                continue;
            }
            let arrives = ((height + thick) / r).clamp(0.0, 1.0);
            let sunk = ((thick - height) / r).clamp(0.0, arrives);
            let kernel = cluster.area / (PI * r * r);
            let factor = (kernel * leaves * arrives).min(1.0);
            let lost = (kernel * TURNED_SHARE * (turned * arrives).max(leaves * sunk)).min(1.0);
            let ratio = (cluster.radius / r).min(1.0);
            let size = block.radius / (r - cluster.radius).max(block.radius);
            most.factor = most.factor.max(factor);
            most.uneven = most.uneven.max(factor * ratio);
            most.sloped = most.sloped.max(factor * ratio * ratio + lost);
            most.within = most.within.max(factor * size * size * 0.5);
        }
        most
    }

    /// Starts a link whose kernel is the mean over `places`² points of each spot.
    pub fn start_sampling(&self, places: u32) -> ClusterSampler<'_> {
        ClusterSampler {
            group: self,
            flow: self.mean_kernel(places),
            seen: [0.0; LANE_COUNT],
            all: [0.0; LANE_COUNT],
            count: 0,
        }
    }

    /// Adds the kernel of point pair `s` to `all`, and to `seen` where the points see each other.
    fn sample_pair(&self, s: u32, seen: &mut LaneValues, all: &mut LaneValues) {
        let block = self.block;
        let through = self.counted == LineOfSight::HiddenByObject;
        let (face, q, own) = self.clusters.sample_point(self.tree, self.number, s);
        let points = block.sample_points(s, self.number);
        let source = self.mesh.faces[face as usize].normal;
        for l in 0..block.count {
            let p = points.at(l);
            let d = p - q;
            let (out, up) = (source.dot(d), -block.lane_normal(l).dot(d));
            if out <= CONTACT_DISTANCE || up <= CONTACT_DISTANCE {
                continue;
            }
            let square = d.length_squared();
            let g = out * up / (square * square) * own * points.weight[l];
            all[l] += g;
            let ends = [face, block.faces[l]];
            let sight = self.rays.find_sight_after(q, p, ends, through, &self.last_blockers[l]);
            if sight == self.counted {
                seen[l] += g;
            }
        }
    }

    /// Returns ∫ cosθ cosθ'/(π d²) dA at `p` over `part`, of unit radiosity. Each of its halves' halves, to the depth
    /// `levels`, is taken by itself, to second order.
    fn sum_kernels(&self, part: ClusterPart, levels: u32, p: Vec3, n: Vec3) -> f32 {
        match part {
            ClusterPart::Cluster(k) => {
                let cluster = &self.clusters.all[k as usize];
                if levels > 0 {
                    let halves = cluster.parts.map(|half| self.sum_kernels(half, levels - 1, p, n));
                    return halves[0] + halves[1];
                }
                let moments = (&cluster.second_moments, &cluster.turn);
                let kernel = mean_source_kernel(moments, cluster.axis, n, p - cluster.centre);
                cluster.mean_normal * cluster.area * kernel / PI
            }
            ClusterPart::Face(f) => {
                let shooter = &root_node(self.tree, f).shooter;
                let moments = plane_moments(shooter);
                let kernel = mean_source_kernel((&moments, &Mat3::ZERO), shooter.normal, n, p - shooter.centre);
                shooter.area * kernel / PI
            }
        }
    }

    /// Returns A cos θ/(π d²)·(d/|d|) by axis, the mean over the cluster.
    fn mean_kernel(&self, places: u32) -> [LaneValues; 3] {
        let cluster = self.source_cluster();
        let mut sum = [[0.0; LANE_COUNT]; 3];
        let mut add = |points: &LanePoints| {
            for l in 0..self.block.count {
                let d = points.at(l) - cluster.centre;
                let normal = -self.block.lane_normal(l);
                let kernel = self.sum_kernels(ClusterPart::Cluster(self.number), KERNEL_LEVELS, points.at(l), normal);
                // A receiver may face all of a round wall and yet lie behind the plane through its centroid.
                let d = d.normalize_or_zero();
                let toward = if cluster.axis.dot(d) >= MIN_OUT_COSINE {
                    d
                } else {
                    cluster.axis
                };
                let own = kernel / (cluster.mean_normal * cluster.axis.dot(toward)).max(1e-6);
                // At any distance, and wherever the bright faces of the cluster look, H is at most their radiosity.
                let own: Vec3 = toward * (own.min(1.0) * points.weight[l]);
                for (sum, own) in sum.iter_mut().zip(own.to_array()) {
                    sum[l] += own;
                }
            }
        };
        if places == 1 {
            add(&self.block.centre_points());
            return sum;
        }
        for place in 0..places * places {
            add(&self.block.grid_points(place, places));
        }
        sum.map(|lane| lane.map(|v| v / (places * places) as f32))
    }
}

/// A link whose visibility is being sampled: more point pairs continue the sequence.
pub struct ClusterSampler<'a> {
    group: &'a ClusterInteraction<'a>,
    flow: [LaneValues; 3],
    seen: LaneValues,
    all: LaneValues,
    count: u32,
}

impl ClusterSampler<'_> {
    /// Returns the link from `samples` point pairs per spot, no fewer than before.
    pub fn sample_link(&mut self, samples: u32) -> SampledLink {
        for s in self.count..samples {
            self.group.sample_pair(s, &mut self.seen, &mut self.all);
        }
        self.count = samples;
        let mut link = BlockLink {
            weight: [0.0; LANE_COUNT],
            along: [[0.0; LANE_COUNT]; 2],
        };
        let (mut of_seen, mut of_all) = (0.0, 0.0);
        for l in 0..self.group.block.count {
            if self.all[l] <= 0.0 {
                continue;
            }
            let part = self.seen[l] / self.all[l];
            link.weight[l] = part * self.flow[0][l];
            link.along[0][l] = part * self.flow[1][l];
            link.along[1][l] = part * self.flow[2][l];
            of_seen += self.seen[l];
            of_all += self.all[l];
        }
        SampledLink {
            link,
            seen: if of_all > 0.0 { of_seen / of_all } else { 0.0 },
        }
    }
}

/// Returns the mean of the kernel f = (a·d)(n·d)/d⁴ over a source of mean normal a, to second order:
/// f + ½ ⟨C, ∇∇f⟩ − [(n·d) tr M + d·(M n) − 4 (n·d) d·(M d)/d²]/d⁴, C its second moments, M = ⟨a δᵀ⟩ its [`Cluster::turn`].
/// Without C all far receivers would have the same bias; without M, all receivers of a closed round wall, of which every
/// part bends towards them.
fn mean_source_kernel((second, m): (&[f32; 6], &Mat3), a: Vec3, n: Vec3, d: Vec3) -> f32 {
    let [xx, yy, zz, xy, yz, zx] = *second;
    let along = |v: Vec3| {
        Vec3::new(
            xx * v.x + xy * v.y + zx * v.z,
            xy * v.x + yy * v.y + yz * v.z,
            zx * v.x + yz * v.y + zz * v.z,
        )
    };
    let (out, up) = (a.dot(d), n.dot(d));
    let square = d.length_squared().max(1e-12);
    let (ca, cd) = (along(a), along(d));
    let even = out * up * (1.0 - 2.0 * (xx + yy + zz) / square + 12.0 * d.dot(cd) / (square * square));
    let tilted = ca.dot(n) - 4.0 * (n.dot(cd) * out + a.dot(cd) * up) / square;
    let trace = m.x_axis.x + m.y_axis.y + m.z_axis.z;
    let turned = up * trace + d.dot(*m * n) - 4.0 * up * d.dot(*m * d) / square;
    (even + tilted - turned).max(0.0) / (square * square)
}
