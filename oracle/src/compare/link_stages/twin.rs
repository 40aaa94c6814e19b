//! The twins of the stages of links at one level of the trees, on the records that the GPU has: what each makes of its
//! input, and the sizes to which the roundings of its values are relative.

use super::LANE_WORDS;
use common::constants::{CONTACT_DISTANCE, PI, VISIBILITY_SAMPLE_COUNTS};
use common::form_factor::{Shooter, point_weight};
use common::sampling::patch_uv;
use cpu::hierarchy::block::ReceiverBlock;
use cpu::hierarchy::level::Refinement;
use cpu::hierarchy::link::{
    BlockLink, BlockedSamples, ExchangeBound, Interaction, LastBlockers, OccluderQuery, SampledLinkTask,
    no_last_blockers,
};
use cpu::hierarchy::linker::{LinkRequest, LinkerScene};
use cpu::hierarchy::refinement_steps::{ReflectedLight, SourceRefinement};
use cpu::hierarchy::tree::TreeNode;
use cpu::shader_twins::link_bounds::{bound_link, long_quad_factor};
use cpu::shader_twins::link_factors::{clipped_factors, unclipped_factors};
use cpu::shader_twins::refine::{
    is_above_horizon, is_dark, is_leaf, refine_by_source, refine_by_visibility, request_samples, start_sampling,
    visible_fraction,
};
use cpu::shader_twins::surface_points::outline_point;
use glam::{Vec3, Vec4Swizzles};
use gpu::hierarchy::link_probe::{UNWRITTEN, from_words};
use gpu::link_records::{BLOCK_SPOTS, LaneRecord, PairRecord, PairState};

/// Spots of a block.
pub const SPOTS: usize = BLOCK_SPOTS as usize;

/// Roundings by which an adapter's arithmetic may move a value that is compared with a threshold: products, a sum and,
/// in WGSL's weaker form, a division and ten roots.
const THRESHOLD_ROUNDINGS: f32 = 32.0;
/// Roundings of a visible fraction, a height or a radius: a sum or a dot product, and a division.
const INPUT_ROUNDINGS: f32 = 8.0;

/// Directions in which rounding may move what decides: thresholds, visible fraction, and heights above the horizon.
pub type Nudge = [f32; 3];

/// The lanes of a pair.
pub type Lanes = [LaneRecord; SPOTS];

/// A sample of a spot: its ends, its weight, and the height of the node's point above the spot's horizon.
pub struct SpotSample {
    pub q: Vec3,
    pub p: Vec3,
    pub weight: f32,
    pub height: f32,
}

/// Twin of the stages for the blocks of a request.
pub struct LevelTwin<'a> {
    pub scene: &'a LinkerScene<'a>,
    pub request: &'a LinkRequest<'a>,
    pub blocks: Vec<&'a ReceiverBlock>,
}

impl LevelTwin<'_> {
    pub fn node(&self, pair: &PairRecord) -> &TreeNode {
        &self.scene.tree.nodes[pair.node as usize]
    }

    pub fn block(&self, pair: &PairRecord) -> &ReceiverBlock {
        self.blocks[pair.block as usize]
    }

    fn interaction<'b>(&'b self, pair: &PairRecord, node: &'b TreeNode, blockers: &'b LastBlockers) -> Interaction<'b> {
        Interaction {
            mesh: self.scene.mesh,
            number: pair.node,
            node,
            block: self.block(pair),
            last_blockers: blockers,
        }
    }

    /// Returns the bounds of a pair at its spots.
    pub fn bounds(&self, pair: &PairRecord) -> [[f32; 4]; SPOTS] {
        std::array::from_fn(|l| self.bound_of_spot(&self.node(pair).shooter, pair, l))
    }

    /// Iterates over the bounds of a pair at one spot, had rounding decided otherwise: with the node moved along its
    /// normal, which heights above it are compared with, or of another radius, which distances are compared with.
    pub fn nudged_bounds(&self, pair: &PairRecord, spot: usize) -> impl Iterator<Item = [f32; 4]> {
        let shooter = self.node(pair).shooter;
        let rounding = INPUT_ROUNDINGS * f32::EPSILON;
        let distance = self.block(pair).centre_points().at(spot).distance(shooter.centre);
        let nudges = [[0.0, 1.0], [0.0, -1.0], [1.0, 0.0], [-1.0, 0.0]];
        nudges.into_iter().map(move |[height, radius]| {
            let mut nudged = shooter;
            nudged.radius *= 1.0 + radius * rounding;
            nudged.centre += nudged.normal * (height * rounding * distance);
            self.bound_of_spot(&nudged, pair, spot)
        })
    }

    fn bound_of_spot(&self, shooter: &Shooter, pair: &PairRecord, spot: usize) -> [f32; 4] {
        let block = self.block(pair);
        let bound = bound_link(shooter, block, block.centre_points().at(spot), spot);
        [bound.factor, bound.uneven, bound.sloped, bound.within]
    }

    /// Returns the sizes of the bounds: F without its cosines at half the distance, of a disc, and of a strip; within a spot
    /// the distance between node and spot may be a small difference.
    pub fn bound_sizes(&self, pair: &PairRecord) -> [[f32; 4]; SPOTS] {
        let (shooter, block) = (&self.node(pair).shooter, self.block(pair));
        let points = block.centre_points();
        std::array::from_fn(|l| {
            let r = points.at(l).distance(shooter.centre).max(1e-6);
            let disc = 4.0 * (shooter.area / PI + shooter.radius * shooter.radius) / (r * r);
            let strip = long_quad_factor(shooter, points.at(l));
            let size = disc + strip * strip * r * 2.0 * PI * shooter.radius / shooter.area;
            [size, size, size, size * (r / block.radius).max(1.0)]
        })
    }

    /// Returns the form factors of a pair's spots; `clipped` if its node may have to be clipped.
    pub fn factors(&self, pair: &PairRecord, clipped: bool) -> [f32; SPOTS] {
        let blockers = no_last_blockers();
        let interaction = self.interaction(pair, self.node(pair), &blockers);
        let factors = if clipped { clipped_factors } else { unclipped_factors };
        let mut found = factors(&interaction, pair.places);
        found[self.block(pair).count..].fill(0.0);
        found
    }

    /// Returns the sizes of the form factors of a pair.
    pub fn factor_sizes(&self, pair: &PairRecord) -> [f32; SPOTS] {
        factor_sizes(&self.node(pair).shooter, self.block(pair))
    }

    /// Returns what step 1 to 4 of refinement makes of a pair, and whether it lists it, at the list's end or not.
    pub fn refine(
        &self,
        step: usize,
        given: &PairRecord,
        lanes: &Lanes,
        [threshold, fraction, height]: Nudge,
    ) -> (PairRecord, Option<bool>) {
        let (mut pair, node) = (*given, self.node(given));
        let factor = 1.0 + threshold * THRESHOLD_ROUNDINGS * f32::EPSILON;
        let thresholds = self.request.thresholds.scaled_by(factor);
        if step == 1 {
            [pair.samples, pair.known, pair.state] = [0, 0, PairState::Skip as u32];
            let radiosity = &self.request.radiosity[pair.node as usize];
            if node.shooter.area <= 0.0 || is_dark(radiosity) {
                return (pair, None);
            }
            let most = |k: usize| lanes.iter().fold(0.0f32, |most, lane| most.max(lane.bound[k]));
            let bound = ExchangeBound {
                factor: most(0),
                uneven: most(1),
                sloped: most(2),
                within: most(3),
            };
            let scale = self.request.block_scale(self.block(&pair));
            match refine_by_source(node, radiosity, &bound, scale, thresholds) {
                SourceRefinement::Skip => return (pair, None),
                SourceRefinement::Subdivide => pair.state = PairState::Subdivide as u32,
                SourceRefinement::Pending { light, points_per_side } => {
                    [pair.state, pair.places] = [PairState::Pending as u32, points_per_side];
                    [pair.factor, pair.mean, pair.rest] = [bound.factor, light.mean, light.rest];
                    return (pair, Some(!self.is_above_horizon(&pair, height)));
                }
            }
            return (pair, None);
        }
        if pair.state != PairState::Pending as u32 {
            return (pair, None);
        }
        let mut bound = ExchangeBound {
            factor: pair.factor,
            ..ExchangeBound::default()
        };
        if step == 2 {
            let Some(samples) = start_sampling(&mut bound, &lanes.map(|lane| lane.factor)) else {
                pair.state = PairState::Skip as u32;
                return (pair, None);
            };
            (pair.samples, pair.factor) = (samples, bound.factor);
            return (pair, Some(false));
        }
        let seen = visible_fraction(&lanes.map(|lane| lane.weight), &lanes.map(|lane| lane.known));
        let seen = (seen * (1.0 + fraction * INPUT_ROUNDINGS * f32::EPSILON)).min(1.0);
        let light = ReflectedLight {
            mean: pair.mean,
            rest: pair.rest,
        };
        if step == 3 {
            let samples = request_samples(&bound, light, seen, thresholds);
            [pair.known, pair.samples] = [VISIBILITY_SAMPLE_COUNTS[0], samples.unwrap_or(0)];
            return (pair, samples.map(|_| false));
        }
        [pair.known, pair.samples] = [pair.known.max(pair.samples), 0];
        let Some(decision) = refine_by_visibility(&bound, light, seen, is_leaf(node), thresholds) else {
            pair.state = PairState::Subdivide as u32;
            return (pair, None);
        };
        pair.state = match decision.crosses_shadow_edge {
            true => PairState::Edge as u32,
            false => PairState::Link as u32,
        };
        pair.samples = decision.samples.unwrap_or(0);
        (pair, decision.samples.map(|_| false))
    }

    /// Tests whether a pair's node lies above the horizon, after moving it by a rounding.
    fn is_above_horizon(&self, pair: &PairRecord, height: f32) -> bool {
        let mut node = self.node(pair).clone();
        let by = self.block(pair).lane_normal(0) * (height * INPUT_ROUNDINGS * f32::EPSILON);
        node.shooter.corners = node.shooter.corners.map(|corner| corner + by);
        is_above_horizon(&self.interaction(pair, &node, &no_last_blockers()))
    }

    /// Returns sample `s` of each spot of a pair.
    pub fn spot_samples(&self, pair: &PairRecord, lanes: &Lanes, s: u32) -> [SpotSample; SPOTS] {
        let (node, block) = (self.node(pair), self.block(pair));
        let at = outline_point(&node.shooter.corners, patch_uv(s, pair.node));
        let (q, part) = (at.xyz(), node.shooter.area / pair.samples as f32);
        let points = block.sample_points(s, pair.node);
        let shooter = Shooter {
            centre: q,
            ..node.shooter
        };
        std::array::from_fn(|l| {
            let (p, normal, factor) = (points.at(l), block.lane_normal(l), lanes[l].factor);
            let weight = point_weight(&shooter, p, normal, part, factor) * (points.weight[l] * at.w);
            let is_dark = factor <= 0.0 || shooter.normal.dot(p - q) <= CONTACT_DISTANCE;
            SpotSample {
                q,
                p,
                weight: if is_dark { 0.0 } else { weight },
                height: -normal.dot(p - q),
            }
        })
    }

    /// Returns the lanes of a pair after sampling it. Samples before `known` are blocked as the bits of `lanes` say,
    /// others as rays find.
    pub fn sample_links(&self, pair: &PairRecord, lanes: &Lanes, known: u32) -> Lanes {
        let (scene, blockers) = (self.scene, no_last_blockers());
        let interaction = self.interaction(pair, self.node(pair), &blockers);
        let mut blocked = BlockedSamples::from_bits(lanes.map(|lane| lane.blocked), known);
        let sampled = scene.arch.dispatch(SampledLinkTask {
            pair: &interaction,
            factors: lanes.map(|lane| lane.factor),
            query: OccluderQuery::Rays(scene.rays),
            samples: pair.samples,
            known: &mut blocked,
        });
        let mut found = *lanes;
        for (l, lane) in found.iter_mut().enumerate() {
            for s in (known..pair.samples).filter(|_| lane.factor > 0.0) {
                let (word, bit) = (&mut lane.blocked[s as usize / 32], 1 << (s % 32));
                *word = if blocked.is_blocked(s, l) {
                    *word | bit
                } else {
                    *word & !bit
                };
            }
            lane.weight = sampled.link.weight[l];
            lane.along = [sampled.link.along[0][l], sampled.link.along[1][l]];
            lane.known = 0.0;
        }
        for s in 0..pair.samples {
            for (lane, sample) in found.iter_mut().zip(self.spot_samples(pair, lanes, s)) {
                lane.known = if sample.weight > 0.0 { lane.factor } else { lane.known };
            }
        }
        found
    }

    /// Returns the sizes of the weights of a sampled pair: those of its samples without cosines, over their sum.
    pub fn weight_sizes(&self, pair: &PairRecord, lanes: &Lanes) -> [f32; SPOTS] {
        let part = self.node(pair).shooter.area / pair.samples as f32;
        let mut sums = [[0.0f32; 2]; SPOTS];
        for s in 0..pair.samples {
            for (sum, sample) in sums.iter_mut().zip(self.spot_samples(pair, lanes, s)) {
                let free = part / (PI * sample.q.distance_squared(sample.p) + part);
                *sum = [sum[0] + free + sample.weight, sum[1] + sample.weight];
            }
        }
        std::array::from_fn(|l| match sums[l] {
            [size, all] if all > 0.0 => lanes[l].factor * (size / all),
            _ => lanes[l].factor,
        })
    }
}

/// Returns the decision that a pair's state stands for.
pub fn refinement(pair: &PairRecord, lanes: &Lanes) -> Refinement {
    let is = |state: PairState| pair.state == state as u32;
    if is(PairState::Subdivide) {
        return Refinement::Subdivide;
    }
    if !(is(PairState::Link) || is(PairState::Edge)) {
        return Refinement::Skip;
    }
    Refinement::Link {
        link: Box::new(BlockLink {
            weight: lanes.map(|lane| lane.weight),
            along: [0, 1].map(|k| lanes.map(|lane| lane.along[k])),
        }),
        crosses_shadow_edge: is(PairState::Edge),
    }
}

/// Returns lanes that no stage has written.
pub fn unwritten_lanes() -> Lanes {
    [from_words::<LaneRecord>(&[UNWRITTEN; LANE_WORDS])[0]; SPOTS]
}

/// Returns the sizes of form factors from the spots of a block to a shooter, without their cosines: the angle that a circle of
/// its radius spans, over 2π.
pub fn factor_sizes(shooter: &Shooter, block: &ReceiverBlock) -> [f32; SPOTS] {
    let points = block.centre_points();
    std::array::from_fn(|l| {
        let nearest = points.at(l).distance(shooter.centre) - shooter.radius - block.radius;
        (4.0 * shooter.radius / nearest.max(1e-30)).min(1.0)
    })
}
