//! The link from a node to the spots of a block (linear sources: Zatz 1993, Gortler et al. 1993):
//!
//! ```text
//! H = w (B̄ + g·o)      w = F·V      o = Σ K V (q − c) / Σ K V
//! ```
//! B̄ and g are the mean and the slope of the node's radiosity. F is exact (Lambert); V is the visible share, from
//! point pairs weighted with the kernel K = cosᵢ cosⱼ/πr². o is the kernel-weighted mean of the visible points q,
//! from the node's centre c; without occluders it is the node's second moments times the gradient of ln K.

use crate::hierarchy::block::ReceiverBlock;
use crate::hierarchy::linear_radiosity::LinearRadiosity;
use crate::hierarchy::tree::TreeNode;
use crate::rows::lane_points::{LanePoints, LaneValues};
use crate::rows::lanes::{lane_form_factors, mark_below_horizon, mark_blocked, pair_weights};
use crate::rows::receivers::LANE_COUNT;
use common::constants::{CONTACT_DISTANCE, MAX_GRAZING_HEIGHT_RATIO, MIN_COMPACT_AREA, PI, VISIBILITY_SAMPLE_COUNTS};
use common::form_factor::{FormFactor, Shooter};
use common::intersect::touches_plane;
use common::mesh::Mesh;
use common::rays::{LineOfSight, NO_FACE, Rays};
use common::sampling::{outline_point, patch_uv};
use glam::Vec3;
use pulp::NullaryFnOnce;
use std::cell::Cell;

/// The links of a node to the lanes of a block.
#[derive(Clone, Debug)]
pub struct BlockLink {
    /// w of each lane.
    pub weight: LaneValues,
    /// w·o of each lane, along tangent and bitangent of the node's face.
    pub along: [LaneValues; 2],
}

impl BlockLink {
    /// Adds the irradiance from a source of this `radiosity`.
    #[inline(always)]
    pub fn add_irradiance(&self, radiosity: &LinearRadiosity, received: &mut [LaneValues; 3]) {
        for (c, received) in received.iter_mut().enumerate() {
            let (mean, x, y) = (radiosity.mean[c], radiosity.slope[0][c], radiosity.slope[1][c]);
            for (l, received) in received.iter_mut().enumerate() {
                *received += self.weight[l] * mean + self.along[0][l] * x + self.along[1][l] * y;
            }
        }
    }
}

/// The search for occluders between a node and a block.
#[derive(Clone, Copy)]
pub enum OccluderQuery<'a> {
    /// Tests these faces.
    Faces(&'a [u32]),
    /// Traces rays.
    Rays(&'a Rays),
    /// Tests these faces; pairs count that objects hide and the room does not.
    ObjectFaces(&'a [u32]),
    /// Traces rays; pairs count that objects hide and the room does not.
    ObjectRays(&'a Rays),
}

/// A node and a receiver block.
pub struct Interaction<'a> {
    /// Faces.
    pub mesh: &'a Mesh,
    /// Number of the node.
    pub number: u32,
    /// The node.
    pub node: &'a TreeNode,
    /// The block.
    pub block: &'a ReceiverBlock,
    /// The face that blocked each lane's last ray.
    pub last_blockers: &'a LastBlockers,
}

/// The face that blocked the last ray of each lane; it is tested first for the next ray.
pub type LastBlockers = [Cell<u32>; LANE_COUNT];

/// Returns the state before any ray.
pub fn no_last_blockers() -> LastBlockers {
    std::array::from_fn(|_| Cell::new(NO_FACE))
}

/// Computes approximate bounds of the exchange of a pair.
pub struct BoundTask<'a> {
    /// Node and block.
    pub pair: &'a Interaction<'a>,
}

/// Bounds over all spots of a block; r and s are the radii of node and spot, d their distance.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExchangeBound {
    /// F.
    pub factor: f32,
    /// F·r/d, for radiosity that varies over the node at random.
    pub uneven: f32,
    /// F·(r/d)², for radiosity with a slope.
    pub sloped: f32,
    /// F·(s/d)²/2, the difference of F at a spot's centre from its mean.
    pub within: f32,
}

impl NullaryFnOnce for BoundTask<'_> {
    type Output = ExchangeBound;

    #[inline(always)]
    fn call(self) -> ExchangeBound {
        bound_links(self.pair)
    }
}

/// Returns a height above a plane, or 0 within the contact distance.
#[inline(always)]
pub fn height_above(height: f32) -> f32 {
    if height > CONTACT_DISTANCE { height } else { 0.0 }
}

/// Returns the disc form factor at a distance, from the heights `out` and `up` above the planes of source and
/// receiver.
#[inline(always)]
pub fn disc_factor_at(area: f32, out: f32, up: f32, distance: f32) -> f32 {
    let [leaves, arrives] = [out, up].map(|height| (height / distance).clamp(0.0, 1.0));
    (area * leaves * arrives / (PI * distance * distance)).min(1.0)
}

/// Returns the form factor of a disc as large as the node, which the spot faces; 0 where the spot's projection
/// lies outside the disc.
#[inline(always)]
pub fn facing_disc_factor(shooter: &Shooter, normal: Vec3, d: Vec3, r: f32) -> f32 {
    let height = shooter.normal.dot(d);
    let square = shooter.radius * shooter.radius;
    let facing = -normal.dot(shooter.normal);
    if height <= 0.0 || facing <= 0.0 || r * r - height * height >= square {
        return 0.0;
    }
    facing * square / (square + height * height)
}

/// Returns a bound of the form factor of the part of a long quad that is nearest to `place`, whatever the cosines: a disc of
/// its area says nothing of that. Of other nodes it is 0.
#[inline(always)]
pub fn long_quad_factor(shooter: &Shooter, place: Vec3) -> f32 {
    let [a, b, c, d] = shooter.corners;
    if shooter.area >= MIN_COMPACT_AREA * shooter.radius * shooter.radius || c == d {
        return 0.0;
    }
    let (u, v) = ((b - a + c - d) * 0.5, (d - a + c - b) * 0.5);
    let axis = if u.dot(u) > v.dot(v) { u } else { v };
    let square = axis.dot(axis).max(1e-12);
    let offset = place - shooter.centre;
    let to = offset - axis * (offset.dot(axis) / square).clamp(-0.5, 0.5);
    let distance = to.dot(to).sqrt().max(1e-6);
    let length = square.sqrt();
    (shooter.area / length * distance.min(length) / (PI * distance * distance)).min(1.0)
}

/// Returns the bounds of a node and the spot of lane `l` at `centre`.
#[inline(always)]
pub fn bound_link(shooter: &Shooter, block: &ReceiverBlock, centre: Vec3, l: usize) -> ExchangeBound {
    let d = centre - shooter.centre;
    let r = d.dot(d).sqrt().max(1e-6);
    let normal = block.lane_normal(l);
    // The highest corners bound the cosines of nearly coplanar neighbours better than radii.
    let corners = (0..4).map(|k| shooter.normal.dot(block.lane_corner(k, l) - shooter.centre));
    let out = corners.fold(0.0, f32::max);
    let corners = shooter.corners.map(|c| normal.dot(c - centre));
    let up = corners.into_iter().fold(0.0, f32::max);
    let nearest = (r - 0.5 * (shooter.radius + block.radius)).max(0.5 * r);
    let mut factor = disc_factor_at(shooter.area, height_above(out), height_above(up), nearest);
    // The variation is bounded by the cosines at any point of node and spot.
    let out = shooter.normal.dot(d) + block.radius;
    let up = shooter.radius - normal.dot(d);
    let mut kernel = disc_factor_at(shooter.area, out, up, r);
    let ratio = (shooter.radius / r).min(1.0);
    let gap = (r - shooter.radius).max(block.radius);
    let size = block.radius / gap;
    // A node beside the spot's centre may be above another part of the spot.
    let over = r < shooter.radius + block.radius;
    let most = if over { kernel } else { factor };
    let within = most.max(factor) * size * size * 0.5;
    // The part of a wide node that faces the spot across a narrow gap dominates, not the node's centre.
    let facing = facing_disc_factor(shooter, normal, d, r);
    let facing = facing.max(long_quad_factor(shooter, centre));
    kernel = kernel.max(facing);
    if factor > 0.0 {
        factor = factor.max(facing);
    }
    ExchangeBound {
        factor,
        uneven: kernel * ratio,
        sloped: kernel * ratio * ratio,
        within,
    }
}

/// Returns the largest bounds over the spots of a block.
#[inline(always)]
pub fn bound_links(pair: &Interaction) -> ExchangeBound {
    let (shooter, block) = (&pair.node.shooter, pair.block);
    let points = block.centre_points();
    let [mut factor, mut uneven, mut sloped, mut within] = [[0.0; LANE_COUNT]; 4];
    for l in 0..LANE_COUNT {
        let bound = bound_link(shooter, block, points.at(l), l);
        factor[l] = bound.factor;
        uneven[l] = bound.uneven;
        sloped[l] = bound.sloped;
        within[l] = bound.within;
    }
    let most = |lanes: [f32; LANE_COUNT]| lanes.into_iter().fold(0.0, f32::max);
    ExchangeBound {
        factor: most(factor),
        uneven: most(uneven),
        sloped: most(sloped),
        within: most(within),
    }
}

/// Computes F of a pair.
pub struct FactorTask<'a> {
    /// Node and block.
    pub pair: &'a Interaction<'a>,
    /// Points per side over which each spot's factor is averaged; 1 means the centre.
    pub places: u32,
}

impl NullaryFnOnce for FactorTask<'_> {
    type Output = LaneValues;

    #[inline(always)]
    fn call(self) -> LaneValues {
        match is_above_horizon(self.pair) {
            true => unclipped_factors(self.pair, self.places),
            false => clipped_factors(self.pair, self.places),
        }
    }
}

/// Returns whether the node lies above the horizon of every spot by so much that nothing is to be clipped.
pub fn is_above_horizon(pair: &Interaction) -> bool {
    let Some(face) = pair.block.single_face() else {
        return false;
    };
    let plane = pair.mesh.faces[face as usize].plane;
    let shooter = &pair.node.shooter;
    let heights = shooter.corners.map(|c| plane.truncate().dot(c) - plane.w);
    let lowest = heights.into_iter().fold(f32::INFINITY, f32::min);
    let highest = heights.into_iter().fold(f32::NEG_INFINITY, f32::max);
    let farthest = shooter.centre.distance(pair.block.mean_centre) + pair.block.reach;
    lowest > -CONTACT_DISTANCE / 2.0
        && highest > 1.5 * CONTACT_DISTANCE
        && highest - CONTACT_DISTANCE > 1.01 * MAX_GRAZING_HEIGHT_RATIO * farthest
}

/// Returns the mean form factor of each spot over `places`² points, or at its centre.
#[inline(always)]
pub fn mean_factor(pair: &Interaction, places: u32, above: bool) -> LaneValues {
    if places == 1 {
        return pair.polygon_factors(&pair.block.centre_points(), above);
    }
    let mut sum = [0.0; LANE_COUNT];
    for place in 0..places * places {
        let points = pair.block.grid_points(place, places);
        let f = pair.polygon_factors(&points, above);
        for l in 0..LANE_COUNT {
            sum[l] += f[l] * points.weight[l];
        }
    }
    sum.map(|sum| sum / (places * places) as f32)
}

/// Returns the form factors of a pair whose node lies above the horizon of every spot.
#[inline(always)]
pub fn unclipped_factors(pair: &Interaction, places: u32) -> LaneValues {
    mean_factor(pair, places, true)
}

/// Returns the form factors of a pair whose node may have to be clipped.
#[inline(always)]
pub fn clipped_factors(pair: &Interaction, places: u32) -> LaneValues {
    mean_factor(pair, places, false)
}

impl Interaction<'_> {
    /// Returns the form factor of each lane.
    #[inline(always)]
    pub(crate) fn polygon_factors(&self, points: &LanePoints, above: bool) -> LaneValues {
        let area = [0.0; LANE_COUNT];
        lane_form_factors(
            FormFactor::Polygon,
            &self.node.shooter,
            above,
            points,
            |l| self.block.lane_normal(l),
            &area,
        )
    }
}

/// Computes the link of an unoccluded pair.
pub struct UnoccludedLinkTask<'a> {
    /// Node and block.
    pub pair: &'a Interaction<'a>,
    /// F of each lane.
    pub factors: LaneValues,
}

impl NullaryFnOnce for UnoccludedLinkTask<'_> {
    type Output = BlockLink;

    #[inline(always)]
    fn call(self) -> BlockLink {
        let (pair, node) = (self.pair, self.pair.node);
        let source = &pair.mesh.faces[node.face as usize];
        let (tangent, bitangent) = (source.tangent, source.normal.cross(source.tangent));
        let points = pair.block.centre_points();
        let [xx, yy, xy] = node.second_moments;
        let most = 0.5 * node.shooter.radius;
        let mut link = BlockLink {
            weight: self.factors,
            along: [[0.0; LANE_COUNT]; 2],
        };
        for l in 0..LANE_COUNT {
            let d = points.at(l) - node.shooter.centre;
            let normal = pair.block.lane_normal(l);
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

/// Computes the link of a pair that may be occluded, from point pairs.
pub struct SampledLinkTask<'a> {
    /// Node and block.
    pub pair: &'a Interaction<'a>,
    /// F of each lane.
    pub factors: LaneValues,
    /// Search for occluders.
    pub query: OccluderQuery<'a>,
    /// Point pairs per spot.
    pub samples: u32,
    /// Results of an earlier task: the first point pairs are the same for any number of samples.
    pub known: &'a mut BlockedSamples,
}

/// Maximum number of point pairs.
const MAX_SAMPLES: usize = VISIBILITY_SAMPLE_COUNTS[3] as usize;

/// Blocked lanes of the first point pairs.
#[derive(Clone, Copy)]
pub struct BlockedSamples {
    blocked: [[bool; LANE_COUNT]; MAX_SAMPLES],
    count: u32,
}

impl Default for BlockedSamples {
    fn default() -> Self {
        Self {
            blocked: [[false; LANE_COUNT]; MAX_SAMPLES],
            count: 0,
        }
    }
}

impl BlockedSamples {
    /// Makes the results of the first `count` point pairs from bits, as the GPU keeps them: 32 pairs a word.
    pub fn from_bits(bits: [[u32; 2]; LANE_COUNT], count: u32) -> Self {
        let blocked = |s: usize| bits.map(|own| own[s / 32] >> (s % 32) & 1 != 0);
        Self {
            blocked: std::array::from_fn(blocked),
            count,
        }
    }

    /// Returns whether point pair `s` of lane `l` is blocked.
    pub fn is_blocked(&self, s: u32, l: usize) -> bool {
        self.blocked[s as usize][l]
    }
}

/// A link with its sampled visibility.
pub struct SampledLink {
    /// The link.
    pub link: BlockLink,
    /// Visible share of all spots, weighted with F.
    pub seen: f32,
}

impl NullaryFnOnce for SampledLinkTask<'_> {
    type Output = SampledLink;

    #[inline(always)]
    fn call(self) -> SampledLink {
        sample_links(self)
    }
}

impl SampledLinkTask<'_> {
    /// Returns the lanes that the light from `q` does not reach.
    #[inline(always)]
    pub fn test_occlusion(&self, q: Vec3, points: &LanePoints, g: &LaneValues) -> [bool; LANE_COUNT] {
        let mut blocked = [false; LANE_COUNT];
        match self.query {
            OccluderQuery::Faces(faces) => {
                for k in faces {
                    let face = &self.pair.mesh.faces[*k as usize];
                    if !touches_plane(face, q) {
                        mark_blocked(face, q, points, &mut blocked);
                    }
                }
            }
            OccluderQuery::Rays(rays) => self.trace_rays(rays, LineOfSight::Clear, q, points, g, &mut blocked),
            OccluderQuery::ObjectRays(rays) => {
                self.trace_rays(rays, LineOfSight::HiddenByObject, q, points, g, &mut blocked)
            }
            OccluderQuery::ObjectFaces(faces) => {
                let (mut room, mut objects) = ([false; LANE_COUNT], [false; LANE_COUNT]);
                for k in faces {
                    let face = &self.pair.mesh.faces[*k as usize];
                    let own = match self.pair.mesh.is_object(*k) {
                        true => &mut objects,
                        false => &mut room,
                    };
                    if !touches_plane(face, q) {
                        mark_blocked(face, q, points, own);
                    }
                }
                for l in 0..LANE_COUNT {
                    blocked[l] = room[l] || !objects[l];
                }
            }
        }
        blocked
    }

    /// Traces rays and marks the lanes whose sight is not `counted`.
    #[inline(always)]
    fn trace_rays(
        &self,
        rays: &Rays,
        counted: LineOfSight,
        q: Vec3,
        points: &LanePoints,
        g: &LaneValues,
        blocked: &mut [bool; LANE_COUNT],
    ) {
        let through = counted == LineOfSight::HiddenByObject;
        for l in 0..self.pair.block.count {
            let ends = [self.pair.node.face, self.pair.block.faces[l]];
            let sight = || rays.find_sight_after(q, points.at(l), ends, through, &self.pair.last_blockers[l]);
            blocked[l] = g[l] > 0.0 && sight() != counted;
        }
    }
}

/// Returns the link of each lane of a block from `task.samples` pairs of points, and its visible fraction.
#[inline(always)]
pub fn sample_links(task: SampledLinkTask) -> SampledLink {
    let (pair, node) = (task.pair, task.pair.node);
    let source = &pair.mesh.faces[node.face as usize];
    let (tangent, bitangent) = (source.tangent, source.normal.cross(source.tangent));
    let normal = |l| pair.block.lane_normal(l);
    let part = node.shooter.area / task.samples as f32;
    let (mut seen, mut all) = ([0.0; LANE_COUNT], [0.0; LANE_COUNT]);
    let mut along = [[0.0; LANE_COUNT]; 2];
    for s in 0..task.samples {
        let at = outline_point(&node.shooter.corners, patch_uv(s, pair.number));
        let (q, own) = (at.truncate(), at.w);
        let shooter = Shooter {
            centre: q,
            ..node.shooter
        };
        let points = pair.block.sample_points(s, pair.number);
        let g = pair_weights(&shooter, &points, normal, (part, own), &task.factors);
        if s >= task.known.count {
            let mut blocked = task.test_occlusion(q, &points, &g);
            mark_below_horizon(&points, normal, q, &mut blocked);
            task.known.blocked[s as usize] = blocked;
            task.known.count = s + 1;
        }
        let blocked = task.known.blocked[s as usize];
        let offset = q - node.shooter.centre;
        let (x, y) = (offset.dot(tangent), offset.dot(bitangent));
        for l in 0..LANE_COUNT {
            all[l] += g[l];
            let g = if blocked[l] { 0.0 } else { g[l] };
            seen[l] += g;
            along[0][l] += g * x;
            along[1][l] += g * y;
        }
    }
    let mut link = BlockLink {
        weight: [0.0; LANE_COUNT],
        along: [[0.0; LANE_COUNT]; 2],
    };
    let mut sampled = [0.0; LANE_COUNT];
    for l in 0..pair.block.count {
        if all[l] <= 0.0 {
            continue;
        }
        let f = task.factors[l] / all[l];
        link.weight[l] = f * seen[l];
        link.along[0][l] = f * along[0][l];
        link.along[1][l] = f * along[1][l];
        sampled[l] = task.factors[l];
    }
    let seen = visible_fraction(&link.weight, &sampled);
    SampledLink { link, seen }
}

/// Returns the visible fraction of a pair, from the sums of its lanes.
pub fn visible_fraction(seen: &LaneValues, all: &LaneValues) -> f32 {
    let (mut of_seen, mut of_all) = (0.0, 0.0);
    for (seen, all) in seen.iter().zip(all) {
        of_seen += seen;
        of_all += all;
    }
    if of_all > 0.0 { of_seen / of_all } else { 0.0 }
}
