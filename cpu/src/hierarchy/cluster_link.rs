//! A link from a cluster to the spots of a block. With d from the cluster's centre, n and θ the receiver's,
//!
//! ```text
//! H = κ V cos θ/(π d²) · (d/|d|)·∫ B n dA
//! ```
//! κ from the cluster's spread, V by pairs of points, weighed with their kernels. The three products with x, y and z stand where a node's
//! link has those with mean and slope: light goes over both alike.

use crate::hierarchy::block::Block;
use crate::hierarchy::cluster::{Cluster, Clusters};
use crate::hierarchy::link::{Bound, Ended, Found, Link};
use crate::hierarchy::tree::Tree;
use crate::rows::lanes::{Lane, Points};
use crate::rows::receivers::LANES;
use common::constants::{CONTACT, PI};
use common::mesh::Mesh;
use common::rays::{Rays, Sight};
use glam::Vec3;

/// What turns away from the receiver, or lies below its horizon, is half of what may do so at most, of
/// normals and places that are spread evenly.
const TURNED: f32 = 0.5;

/// A cluster and a block that it shines on.
pub struct Group<'a> {
    /// Faces.
    pub mesh: &'a Mesh,
    /// Their nodes.
    pub tree: &'a Tree,
    /// All clusters.
    pub clusters: &'a Clusters,
    /// All faces, for rays.
    pub rays: &'a Rays,
    /// The cluster's number.
    pub number: u32,
    /// The block.
    pub block: &'a Block,
    /// Which pairs of points count: clear ones, or those between which only objects are.
    pub passes: Sight,
    /// The face that ended each lane's last ray.
    pub ended: &'a Ended,
}

impl Group<'_> {
    fn cluster(&self) -> &Cluster {
        &self.clusters.all[self.number as usize]
    }

    /// What is exchanged at most, as [`crate::hierarchy::link::Bounds`] has it of a node; what looks away
    /// or lies below a horizon counts as light that slopes.
    pub fn bound(&self) -> Bound {
        let cluster = self.cluster();
        let block = self.block;
        let sine = (1.0 - cluster.cone * cluster.cone).max(0.0).sqrt();
        let points = block.centres();
        let mut most = Bound::default();
        for l in 0..block.count {
            let normal = block.normal(l);
            let d = points.at(l) - cluster.centre;
            let r = d.length().max(1e-6);
            // How far above its own plane a face's light may leave.
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
            if height + thick <= CONTACT {
                continue;
            }
            let arrives = ((height + thick) / r).clamp(0.0, 1.0);
            let sunk = ((thick - height) / r).clamp(0.0, arrives);
            let kernel = cluster.area / (PI * r * r);
            let factor = (kernel * leaves * arrives).min(1.0);
            let lost = (kernel * TURNED * (turned * arrives).max(leaves * sunk)).min(1.0);
            let ratio = (cluster.radius / r).min(1.0);
            let size = block.radius / (r - cluster.radius).max(block.radius);
            most.factor = most.factor.max(factor);
            most.uneven = most.uneven.max(factor * ratio);
            most.sloped = most.sloped.max(factor * ratio * ratio + lost);
            most.within = most.within.max(factor * size * size * 0.5);
        }
        most
    }

    /// Asks, with what arrives at `places`² of each spot.
    pub fn asked(&self, places: u32) -> Asked<'_> {
        Asked {
            group: self,
            flow: self.flow(places),
            seen: [0.0; LANES],
            all: [0.0; LANES],
            count: 0,
        }
    }

    /// What pair `s` of points adds to what is seen, and to all.
    fn ask(&self, s: u32, seen: &mut Lane, all: &mut Lane) {
        let block = self.block;
        let through = self.passes == Sight::Hidden;
        let (face, q, own) = self.clusters.sampled(self.tree, self.number, s);
        let points = block.sampled(s, self.number);
        let source = self.mesh.faces[face as usize].normal;
        for l in 0..block.count {
            let p = points.at(l);
            let d = p - q;
            let (out, up) = (source.dot(d), -block.normal(l).dot(d));
            if out <= CONTACT || up <= CONTACT {
                continue;
            }
            let square = d.length_squared();
            let g = out * up / (square * square) * own * points.weight[l];
            all[l] += g;
            let ends = [face, block.faces[l]];
            let sight = self.rays.sight_past(q, p, ends, through, &self.ended[l]);
            if sight == self.passes {
                seen[l] += g;
            }
        }
    }

    /// A cos θ/(π d²)·(d/|d|), the mean over the cluster to the second order: its x, y and z.
    fn flow(&self, places: u32) -> [Lane; 3] {
        let cluster = self.cluster();
        let mut sum = [[0.0; LANES]; 3];
        let mut add = |points: &Points| {
            for l in 0..self.block.count {
                let d = points.at(l) - cluster.centre;
                let normal = -self.block.normal(l);
                let up = normal.dot(d).max(0.0);
                let square = d.length_squared().max(1e-12);
                let out = cluster.axis.dot(d).max(0.0);
                let bent = bent(cluster, normal, d);
                let own = cluster.area * up / (PI * square * square) * bent;
                // However near, no more than all arrives.
                let most = 1.0 / out.max(1e-12);
                let own: Vec3 = d * (own.min(most) * points.weight[l]);
                for (sum, own) in sum.iter_mut().zip(own.to_array()) {
                    sum[l] += own;
                }
            }
        };
        if places == 1 {
            add(&self.block.centres());
            return sum;
        }
        for place in 0..places * places {
            add(&self.block.placed(place, places));
        }
        sum.map(|lane| lane.map(|v| v / (places * places) as f32))
    }
}

/// A link in the making: more pairs of points go on where fewer ended.
pub struct Asked<'a> {
    group: &'a Group<'a>,
    flow: [Lane; 3],
    seen: Lane,
    all: Lane,
    count: u32,
}

impl Asked<'_> {
    /// The link from so many pairs of points a spot, no fewer than before.
    pub fn sampled(&mut self, samples: u32) -> Found {
        for s in self.count..samples {
            self.group.ask(s, &mut self.seen, &mut self.all);
        }
        self.count = samples;
        let mut link = Link {
            weight: [0.0; LANES],
            along: [[0.0; LANES]; 2],
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
        Found {
            link,
            seen: if of_all > 0.0 { of_seen / of_all } else { 0.0 },
        }
    }
}

/// The mean of the kernel f = (a·d)(n·d)/d⁴ over a cluster, over its value at the centre: 1 + ½ ⟨C, ∇∇f⟩/f, where
/// C is the cluster's spread. All that is far would lose or gain the same share.
fn bent(cluster: &Cluster, n: Vec3, d: Vec3) -> f32 {
    let [xx, yy, zz, xy, yz, zx] = cluster.spread;
    let along = |v: Vec3| {
        Vec3::new(
            xx * v.x + xy * v.y + zx * v.z,
            xy * v.x + yy * v.y + yz * v.z,
            zx * v.x + yz * v.y + zz * v.z,
        )
    };
    let a = cluster.axis;
    let (out, up) = (a.dot(d), n.dot(d));
    if out <= 0.0 || up <= 0.0 {
        return 1.0;
    }
    let square = d.length_squared();
    let (ca, cd) = (along(a), along(d));
    let second = 2.0 * ca.dot(n) / (out * up)
        - 8.0 * (n.dot(cd) / up + a.dot(cd) / out) / square
        - 4.0 * (xx + yy + zz) / square
        + 24.0 * d.dot(cd) / (square * square);
    (1.0 + 0.5 * second).clamp(0.5, 1.5)
}
