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
use common::constants::{CONTACT, LOW, PI, SAMPLES};
use common::form_factor::{FormFactor, Shooter};
use common::intersect::touches;
use common::mesh::Mesh;
use common::rays::{NOBODY, Rays, Sight};
use common::sampling::{cell_uv, outline_point};
use glam::Vec3;
use pulp::NullaryFnOnce;
use std::cell::Cell;

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
    /// All but what objects take, of these faces: the link is of what the room alone would see, and they hide.
    Kept(&'a [u32]),
    /// The same, of whatever a ray finds.
    Left(&'a Rays),
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
    /// The face that ended each lane's last ray.
    pub ended: &'a Ended,
}

/// By lane, the face that ended its last ray: the next one's light comes from beside there.
pub type Ended = [Cell<u32>; LANES];

/// No ray has been asked yet.
pub fn nobody() -> Ended {
    std::array::from_fn(|_| Cell::new(NOBODY))
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
        let points = block.centres();
        let [mut factors, mut kernels, mut ratios, mut within] = [[0.0; LANES]; 4];
        for l in 0..LANES {
            let d = points.at(l) - shooter.centre;
            let r = d.dot(d).sqrt().max(1e-6);
            let normal = block.normal(l);
            // Of neighbours that are nearly coplanar radii would tell nothing: the highest corners do.
            let corners = (0..4).map(|k| shooter.normal.dot(block.corner(k, l) - shooter.centre));
            let out = corners.fold(0.0, f32::max);
            let corners = shooter.corners.map(|c| normal.dot(c - points.at(l)));
            let up = corners.into_iter().fold(0.0, f32::max);
            let nearest = (r - 0.5 * (shooter.radius + block.radius)).max(0.5 * r);
            factors[l] = disc_at(shooter.area, above(out), above(up), nearest);
            // But how light varies is told by where the cosines may be.
            let out = shooter.normal.dot(d) + block.radius;
            let up = shooter.radius - normal.dot(d);
            kernels[l] = disc_at(shooter.area, out, up, r);
            let ratio = (shooter.radius / r).min(1.0);
            let gap = (r - shooter.radius).max(block.radius);
            let size = block.radius / gap;
            ratios[l] = ratio;
            // Where the node is beside the spot's centre, but above a part of it, the centre tells nothing.
            let over = r < shooter.radius + block.radius;
            let most = if over { kernels[l] } else { factors[l] };
            within[l] = most.max(factors[l]) * size * size * 0.5;
            // Of a node that is much wider than a gap the part before the spot sends all, not its centre.
            let before = disc_before(shooter, normal, d, r);
            kernels[l] = kernels[l].max(before);
            if factors[l] > 0.0 {
                factors[l] = factors[l].max(before);
            }
        }
        let most = |part: &dyn Fn(usize) -> f32| (0..LANES).map(part).fold(0.0, f32::max);
        Bound {
            factor: most(&|l| factors[l]),
            uneven: most(&|l| kernels[l] * ratios[l]),
            sloped: most(&|l| kernels[l] * ratios[l] * ratios[l]),
            within: most(&|l| within[l]),
        }
    }
}

/// F at a distance, of what leaves and arrives so high above the planes.
#[inline(always)]
fn disc_at(area: f32, out: f32, up: f32, distance: f32) -> f32 {
    let [leaves, arrives] = [out, up].map(|height| (height / distance).clamp(0.0, 1.0));
    (area * leaves * arrives / (PI * distance * distance)).min(1.0)
}

/// F of a disc as large as the node, before a spot whose foot on the node's plane lies within it.
#[inline(always)]
fn disc_before(shooter: &Shooter, normal: Vec3, d: Vec3, r: f32) -> f32 {
    let height = shooter.normal.dot(d);
    let square = shooter.radius * shooter.radius;
    let facing = -normal.dot(shooter.normal);
    if height <= 0.0 || facing <= 0.0 || r * r - height * height >= square {
        return 0.0;
    }
    facing * square / (square + height * height)
}

/// A height above a plane, if what only touches it has none.
#[inline(always)]
fn above(height: f32) -> f32 {
    if height > CONTACT { height } else { 0.0 }
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
        let above = pair.is_above();
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
    /// Whether the node lies above the horizon of every spot, well enough to sum it plainly.
    fn is_above(&self) -> bool {
        let Some(face) = self.block.face() else {
            return false;
        };
        let plane = self.mesh.faces[face as usize].plane;
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
            |l| self.block.normal(l),
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
        let points = pair.block.centres();
        let [xx, yy, xy] = node.spread;
        let most = 0.5 * node.shooter.radius;
        let mut link = Link {
            weight: self.factors,
            along: [[0.0; LANES]; 2],
        };
        for l in 0..LANES {
            let d = points.at(l) - node.shooter.centre;
            let normal = pair.block.normal(l);
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
    /// Which of them are known to be stopped: the first ones are the same however many there are.
    pub known: &'a mut Known,
}

/// Pairs of points at most.
const MOST_SAMPLES: usize = SAMPLES[3] as usize;

/// Which lanes are stopped, for each of the first pairs of points.
#[derive(Clone, Copy)]
pub struct Known {
    stopped: [[bool; LANES]; MOST_SAMPLES],
    count: u32,
}

impl Default for Known {
    fn default() -> Self {
        Self {
            stopped: [[false; LANES]; MOST_SAMPLES],
            count: 0,
        }
    }
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
        let normal = |l| pair.block.normal(l);
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
            if s >= self.known.count {
                let mut stopped = self.stopped(q, &points, &g);
                below(&points, normal, q, &mut stopped);
                self.known.stopped[s as usize] = stopped;
                self.known.count = s + 1;
            }
            let stopped = self.known.stopped[s as usize];
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
    /// Stopped is what rays find to be another sight than `passes`.
    #[inline(always)]
    fn asked(
        &self,
        rays: &Rays,
        passes: Sight,
        q: Vec3,
        points: &Points,
        g: &Lane,
        stopped: &mut [bool; LANES],
    ) {
        let through = passes == Sight::Hidden;
        for l in 0..self.pair.block.count {
            let ends = [self.pair.node.face, self.pair.block.faces[l]];
            let sight = || rays.sight_past(q, points.at(l), ends, through, &self.pair.ended[l]);
            stopped[l] = g[l] > 0.0 && sight() != passes;
        }
    }

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
            Stops::Any(rays) => self.asked(rays, Sight::Clear, q, points, g, &mut stopped),
            Stops::Left(rays) => self.asked(rays, Sight::Hidden, q, points, g, &mut stopped),
            Stops::Kept(faces) => {
                let (mut room, mut objects) = ([false; LANES], [false; LANES]);
                for k in faces {
                    let face = &self.pair.mesh.faces[*k as usize];
                    let own = match self.pair.mesh.is_object(*k) {
                        true => &mut objects,
                        false => &mut room,
                    };
                    if !touches(face, q) {
                        stop(face, q, points, own);
                    }
                }
                for l in 0..LANES {
                    stopped[l] = room[l] || !objects[l];
                }
            }
        }
        stopped
    }
}
