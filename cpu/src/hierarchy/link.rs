//! A link from a node to the spots of a block: what arrives of a glow that varies over the node.
//!
//! ```text
//! H = w (B̄ + g·o)      w = F·V      o = Σ K V (q − c) / Σ K V
//! ```
//! F exact (Lambert), V the part of the node that is seen, by pairs of points weighed with the kernel
//! K = cosᵢ cosⱼ/πr², o where on the node, from its centre c, the light that arrives comes from: that
//! takes the slope g of its glow to the spot (linear sources: Zatz 1993, Gortler et al. 1993). Where
//! nothing is between, o is the node's spread times the gradient of ln K.

use crate::hierarchy::block::Block;
use crate::hierarchy::light::Glow;
use crate::hierarchy::tree::Node;
use crate::rows::lanes::{Lane, Points, below, form_factors, stop, weights};
use crate::rows::receivers::LANES;
use common::constants::{CONTACT, LOW, PI};
use common::form_factor::{FormFactor, Shooter};
use common::intersect::touches;
use common::mesh::{Mesh, MeshFace};
use common::rays::{Rays, Sight};
use common::sampling::{cell_uv, outline_point};
use glam::Vec3;
use pulp::NullaryFnOnce;

/// A node's links to a block.
#[derive(Clone, Debug)]
pub struct Link {
    /// w.
    pub weight: Lane,
    /// w·o, along tangent and bitangent of the node's face.
    pub along: [Lane; 2],
}

impl Link {
    /// Adds what `glow` sends to the lanes.
    #[inline(always)]
    pub fn add(&self, glow: &Glow, received: &mut [Lane; 3]) {
        for (c, received) in received.iter_mut().enumerate() {
            let (mean, x, y) = (glow.mean[c], glow.slope[0][c], glow.slope[1][c]);
            for (l, received) in received.iter_mut().enumerate() {
                *received += self.weight[l] * mean + self.along[0][l] * x + self.along[1][l] * y;
            }
        }
    }
}

/// What may be between.
#[derive(Clone, Copy)]
pub enum Stops<'a> {
    /// These faces, perhaps none.
    Faces(&'a [u32]),
    /// Whatever a ray finds.
    Any(&'a Rays),
}

/// A node and a block that it shines on.
pub struct Pair<'a> {
    /// Faces.
    pub mesh: &'a Mesh,
    /// The node's number.
    pub number: u32,
    /// The node.
    pub node: &'a Node,
    /// The block.
    pub block: &'a Block,
}

/// What a pair exchanges at most, roughly: where the nearest and best placed spot is.
pub struct Bounds<'a> {
    /// The pair.
    pub pair: &'a Pair<'a>,
}

/// The largest of each over the spots; r, s: the radii of node and spot, d their distance.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bound {
    /// F.
    pub factor: f32,
    /// F·r/d: of light that varies over the node at random.
    pub uneven: f32,
    /// F·(r/d)²: of light that slopes.
    pub sloped: f32,
    /// F·(s/d)²/2: what a spot's centre leaves out of its mean.
    pub within: f32,
}

impl NullaryFnOnce for Bounds<'_> {
    type Output = Bound;

    #[inline(always)]
    fn call(self) -> Bound {
        let (shooter, block) = (&self.pair.node.shooter, self.pair.block);
        let normal = self.pair.receiver().normal;
        let points = block.centres();
        let [mut factors, mut ratios, mut sizes] = [[0.0; LANES]; 3];
        for l in 0..LANES {
            let d = points.at(l) - shooter.centre;
            let r = d.dot(d).sqrt().max(1e-6);
            let leaves = ((shooter.normal.dot(d) + block.radius) / r).clamp(0.0, 1.0);
            let arrives = ((shooter.radius - normal.dot(d)) / r).clamp(0.0, 1.0);
            let factor = (shooter.area * leaves * arrives / (PI * r * r)).min(1.0);
            let ratio = (shooter.radius / r).min(1.0);
            let gap = (r - shooter.radius).max(block.radius);
            let size = block.radius / gap;
            factors[l] = factor;
            ratios[l] = ratio;
            sizes[l] = size;
        }
        let most = |part: &dyn Fn(usize) -> f32| (0..LANES).map(part).fold(0.0, f32::max);
        Bound {
            factor: most(&|l| factors[l]),
            uneven: most(&|l| factors[l] * ratios[l]),
            sloped: most(&|l| factors[l] * ratios[l] * ratios[l]),
            within: most(&|l| factors[l] * sizes[l] * sizes[l] * 0.5),
        }
    }
}

/// F of a pair.
pub struct Factors<'a> {
    /// The pair.
    pub pair: &'a Pair<'a>,
    /// Places a side, of which each spot's factor is the mean; 1: its centre.
    pub places: u32,
}

impl NullaryFnOnce for Factors<'_> {
    type Output = Lane;

    #[inline(always)]
    fn call(self) -> Lane {
        let pair = self.pair;
        let above = pair.above();
        if self.places == 1 {
            return pair.factors(&pair.block.centres(), above);
        }
        let mut sum = [0.0; LANES];
        for place in 0..self.places * self.places {
            let points = pair.block.placed(place, self.places);
            let f = pair.factors(&points, above);
            for l in 0..LANES {
                sum[l] += f[l] * points.weight[l];
            }
        }
        sum.map(|sum| sum / (self.places * self.places) as f32)
    }
}

impl Pair<'_> {
    fn receiver(&self) -> &MeshFace {
        &self.mesh.faces[self.block.face as usize]
    }

    /// Whether the node lies above the horizon of every spot, well enough to sum it plainly.
    fn above(&self) -> bool {
        let plane = self.receiver().plane;
        let shooter = &self.node.shooter;
        let heights = shooter.corners.map(|c| plane.truncate().dot(c) - plane.w);
        let lowest = heights.into_iter().fold(f32::INFINITY, f32::min);
        let highest = heights.into_iter().fold(f32::NEG_INFINITY, f32::max);
        let farthest = shooter.centre.distance(self.block.middle) + self.block.reach;
        lowest > -CONTACT / 2.0
            && highest > 1.5 * CONTACT
            && highest - CONTACT > 1.01 * LOW * farthest
    }

    #[inline(always)]
    fn factors(&self, points: &Points, above: bool) -> Lane {
        let area = [0.0; LANES];
        form_factors(
            FormFactor::Polygon,
            &self.node.shooter,
            above,
            points,
            self.receiver().normal,
            &area,
        )
    }
}

/// The link where nothing is between.
pub struct Open<'a> {
    /// The pair.
    pub pair: &'a Pair<'a>,
    /// Its F.
    pub factors: Lane,
}

impl NullaryFnOnce for Open<'_> {
    type Output = Link;

    #[inline(always)]
    fn call(self) -> Link {
        let (pair, node) = (self.pair, self.pair.node);
        let source = &pair.mesh.faces[node.face as usize];
        let (tangent, bitangent) = (source.tangent, source.normal.cross(source.tangent));
        let normal = pair.receiver().normal;
        let points = pair.block.centres();
        let [xx, yy, xy] = node.spread;
        let most = 0.5 * node.shooter.radius;
        let mut link = Link {
            weight: self.factors,
            along: [[0.0; LANES]; 2],
        };
        for l in 0..LANES {
            let d = points.at(l) - node.shooter.centre;
            let height = (-normal.dot(d)).max(1e-6);
            let gradient = normal / height + d * (4.0 / d.dot(d).max(1e-12));
            let (gx, gy) = (gradient.dot(tangent), gradient.dot(bitangent));
            let (ox, oy) = (xx * gx + xy * gy, xy * gx + yy * gy);
            let scale = self.factors[l] * (most / (ox * ox + oy * oy).sqrt().max(1e-20)).min(1.0);
            link.along[0][l] = scale * ox;
            link.along[1][l] = scale * oy;
        }
        link
    }
}

/// The link through `stops`, from so many pairs of points a spot.
pub struct Sampled<'a> {
    /// The pair.
    pub pair: &'a Pair<'a>,
    /// Its F.
    pub factors: Lane,
    /// What may be between.
    pub stops: Stops<'a>,
    /// Pairs of points a spot.
    pub samples: u32,
}

/// A link from samples.
pub struct Found {
    /// The link.
    pub link: Link,
    /// The share of the pairs that see each other.
    pub seen: f32,
}

impl NullaryFnOnce for Sampled<'_> {
    type Output = Found;

    #[inline(always)]
    fn call(self) -> Found {
        let (pair, node) = (self.pair, self.pair.node);
        let source = &pair.mesh.faces[node.face as usize];
        let (tangent, bitangent) = (source.tangent, source.normal.cross(source.tangent));
        let normal = pair.receiver().normal;
        let part = node.shooter.area / self.samples as f32;
        let (mut seen, mut all) = ([0.0; LANES], [0.0; LANES]);
        let mut along = [[0.0; LANES]; 2];
        for s in 0..self.samples {
            let at = outline_point(&node.shooter.corners, cell_uv(s, pair.number));
            let (q, own) = (at.truncate(), at.w);
            let shooter = Shooter {
                centre: q,
                ..node.shooter
            };
            let points = pair.block.sampled(s, pair.number);
            let g = weights(&shooter, &points, normal, (part, own), &self.factors);
            let mut stopped = self.stopped(q, &points, &g);
            below(&points, normal, q, &mut stopped);
            let offset = q - node.shooter.centre;
            let (x, y) = (offset.dot(tangent), offset.dot(bitangent));
            for l in 0..LANES {
                all[l] += g[l];
                let g = if stopped[l] { 0.0 } else { g[l] };
                seen[l] += g;
                along[0][l] += g * x;
                along[1][l] += g * y;
            }
        }
        let mut link = Link {
            weight: [0.0; LANES],
            along: [[0.0; LANES]; 2],
        };
        let (mut of_seen, mut of_all) = (0.0, 0.0);
        for l in 0..pair.block.count {
            if all[l] <= 0.0 {
                continue;
            }
            let f = self.factors[l] / all[l];
            link.weight[l] = f * seen[l];
            link.along[0][l] = f * along[0][l];
            link.along[1][l] = f * along[1][l];
            of_seen += link.weight[l];
            of_all += self.factors[l];
        }
        Found {
            link,
            seen: if of_all > 0.0 { of_seen / of_all } else { 0.0 },
        }
    }
}

impl Sampled<'_> {
    #[inline(always)]
    fn stopped(&self, q: Vec3, points: &Points, g: &Lane) -> [bool; LANES] {
        let mut stopped = [false; LANES];
        match self.stops {
            Stops::Faces(faces) => {
                for k in faces {
                    let face = &self.pair.mesh.faces[*k as usize];
                    if !touches(face, q) {
                        stop(face, q, points, &mut stopped);
                    }
                }
            }
            Stops::Any(rays) => {
                let ends = [self.pair.node.face, self.pair.block.face];
                for l in 0..self.pair.block.count {
                    stopped[l] =
                        g[l] > 0.0 && rays.sight(q, points.at(l), ends, false) != Sight::Clear;
                }
            }
        }
        stopped
    }
}
