//! BF refinement (Hanrahan, Salzman & Aupperle 1991): a source is subdivided until the errors of its mean, its
//! slope and its sampled visibility are below their thresholds at a receiver block.
//!
//! One [`Refiner`] serves the blocks of a task: it descends from faces to their nodes, and keeps for each
//! the blocks at which the source was subdivided. Blocks on one face share shafts and shadows.

use crate::hierarchy::block::ReceiverBlock;
use crate::hierarchy::level::{Refinement, prefix_sum, store_links, subdivide_nodes};
use crate::hierarchy::linear_radiosity::LinearRadiosity;
use crate::hierarchy::link::{
    BlockLink, BlockedSamples, BoundTask, ExchangeBound, FactorTask, Interaction, LastBlockers, OccluderQuery,
    SampledLink, SampledLinkTask, UnoccludedLinkTask, no_last_blockers,
};
use crate::hierarchy::linker::{LinkRequest, LinkThresholds, LinkerScene, RequestedLight};
use crate::hierarchy::refinement_steps::{
    ReflectedLight, SourceRefinement, is_dark, is_leaf, refine_by_source, refine_by_visibility, request_samples,
    start_sampling,
};
use crate::hierarchy::tree::TreeNode;
use crate::occlusion::polygon::ConvexPolygon;
use crate::occlusion::shaft::Shaft;
use crate::rows::candidates::MAX_CANDIDATES;
use crate::rows::receivers::{FaceFrame, ReceiverFace};
use crate::rows::shadow::{ShadowRegion, penumbra_region};
use common::constants::{CONTACT_DISTANCE, ROOTS_PER_BATCH, VISIBILITY_SAMPLE_COUNTS};
use common::intersect::{intersect_face, touches_plane};
use common::mesh::Mesh;
use common::polygon::distinct_corners;
use common::rays::NO_FACE;
use glam::{Vec2, Vec3};
use std::borrow::Cow;
use std::cell::Cell;

/// Radius above which a node lies outside the scene, which is two units wide: it is the sky's.
const MAX_SCENE_RADIUS: f32 = 2.0;

/// Refines sources at some receiver blocks.
pub struct Refiner<'a> {
    scene: &'a LinkerScene<'a>,
    light: RequestedLight<'a>,
    radiosity: &'a [LinearRadiosity],
    thresholds: LinkThresholds,
    blocks: &'a [ReceiverBlock],
    /// Scale of each block.
    scale: Vec<Vec3>,
    /// The face of all blocks, if they lie on one.
    shared_face: Option<SharedFace>,
    last_blockers: LastBlockers,
}

/// The face of all blocks, as far as they cover it.
struct SharedFace {
    face: u32,
    receiver: ReceiverFace,
}

/// Faces that may occlude between a node and the blocks; none where rays have to find them.
type NodeOccluders = Option<Vec<u32>>;

/// A link that was created.
pub struct CreatedLink<'a> {
    /// Number of the block.
    pub block: usize,
    /// Number of the node.
    pub node: u32,
    /// The link.
    pub link: &'a BlockLink,
    /// A shadow edge crosses the block: its spots differ by more than the `source` threshold.
    pub crosses_shadow_edge: bool,
}

impl<'a> Refiner<'a> {
    /// Prepares `request` for `blocks`.
    pub fn new(scene: &'a LinkerScene<'a>, request: &LinkRequest<'a>, blocks: &'a [ReceiverBlock]) -> Self {
        Self {
            scene,
            light: request.light,
            radiosity: request.radiosity,
            thresholds: request.thresholds,
            blocks,
            scale: blocks.iter().map(|b| request.block_scale(b)).collect(),
            shared_face: SharedFace::around_blocks(scene.mesh, blocks),
            last_blockers: no_last_blockers(),
        }
    }

    /// Passes every link to the blocks to `take`, face after face.
    pub fn link_by_shafts(&self, mut take: impl FnMut(CreatedLink)) {
        let active: Vec<u32> = (0..self.blocks.len() as u32).collect();
        for f in 0..self.scene.mesh.faces.len() as u32 {
            self.refine_face(f, &active, &mut take);
        }
    }

    /// Passes every link to `take`, by rays: block after block, level after level of the trees.
    pub fn link_by_rays(&self, mut take: impl FnMut(CreatedLink)) {
        let tree = self.scene.tree;
        for (block, roots) in
            (0..self.blocks.len()).flat_map(|block| tree.roots.chunks(ROOTS_PER_BATCH).map(move |roots| (block, roots)))
        {
            let mut level = roots.to_vec();
            while !level.is_empty() {
                let refined: Vec<Refinement> = level.iter().map(|k| self.refine_by_rays(*k, block as u32)).collect();
                store_links(&level, &refined, |node, link, crosses_shadow_edge| {
                    take(CreatedLink {
                        block,
                        node,
                        link,
                        crosses_shadow_edge,
                    });
                });
                let offsets = prefix_sum(&level, &refined, &tree.nodes);
                level = subdivide_nodes(&level, &refined, &offsets, &tree.nodes);
            }
        }
    }

    /// Decides about node `k` at block `number`, by rays.
    fn refine_by_rays(&self, k: u32, number: u32) -> Refinement {
        let node = &self.scene.tree.nodes[k as usize];
        if node.shooter.area <= 0.0 || is_dark(&self.radiosity[k as usize]) {
            return Refinement::Skip;
        }
        self.refine_interaction(k, node, number, &None, &[])
    }

    /// Returns those of the `active` blocks at which objects may occlude a source within `ball`.
    fn select_affected<'b>(&self, active: &'b [u32], ball: (Vec3, f32)) -> Cow<'b, [u32]> {
        let RequestedLight::OccludedBy(objects) = self.light else {
            return Cow::Borrowed(active);
        };
        let affected = |b: &&u32| {
            let block = &self.blocks[**b as usize];
            objects.any_between(ball, (block.mean_centre, block.reach))
        };
        active.iter().filter(affected).copied().collect()
    }

    /// Passes the links of source `node` to `take`, and returns the blocks at which it is to be subdivided.
    fn refine_at_blocks(
        &self,
        node: u32,
        active: &[u32],
        take: &mut impl FnMut(CreatedLink),
        decide: impl Fn(u32) -> Refinement,
    ) -> Vec<u32> {
        let mut subdivided = Vec::new();
        for b in active {
            match decide(*b) {
                Refinement::Skip => {}
                Refinement::Subdivide => subdivided.push(*b),
                Refinement::Link {
                    link,
                    crosses_shadow_edge,
                } => take(CreatedLink {
                    block: *b as usize,
                    node,
                    link: &link,
                    crosses_shadow_edge,
                }),
            }
        }
        subdivided
    }

    fn refine_face(&self, f: u32, active: &[u32], take: &mut impl FnMut(CreatedLink)) {
        let faces = &self.scene.mesh.faces;
        if let Some(own) = &self.shared_face
            && (f == own.face || !faces[own.face as usize].can_face(&faces[f as usize]))
        {
            return;
        }
        let root = self.scene.tree.roots[f as usize];
        self.refine_node(root, active, None, take);
    }

    fn refine_node(&self, k: u32, active: &[u32], known: NodeOccluders, take: &mut impl FnMut(CreatedLink)) {
        let node = &self.scene.tree.nodes[k as usize];
        let ball = (node.shooter.centre, node.shooter.radius);
        if node.shooter.area <= 0.0 || is_dark(&self.radiosity[k as usize]) || self.is_below_receivers(node) {
            return;
        }
        let active = self.select_affected(active, ball);
        let occluders = self.find_occluders(node, known);
        if self.occludes_nothing(&occluders) {
            return;
        }
        let shadows = self.find_shadows(node, &occluders);
        let subdivided = self.refine_at_blocks(k, &active, take, |b| {
            self.refine_interaction(k, node, b, &occluders, &shadows)
        });
        if subdivided.is_empty() {
            return;
        }
        let shadowing: Vec<u32> = shadows.iter().map(|(k, _)| *k).collect();
        for child in node.children.clone() {
            let known = occluders.is_some().then(|| shadowing.clone());
            self.refine_node(child, &subdivided, known, take);
        }
    }

    /// Returns true if no corner of `node` lies above the plane of the blocks' face.
    fn is_below_receivers(&self, node: &TreeNode) -> bool {
        let Some(own) = &self.shared_face else {
            return false;
        };
        let plane = self.scene.mesh.faces[own.face as usize].plane;
        let corners = node.shooter.corners.iter();
        corners
            .map(|c| plane.truncate().dot(*c) - plane.w)
            .all(|height| height <= CONTACT_DISTANCE)
    }

    /// Returns true if only light that objects occlude is gathered and no object lies between.
    fn occludes_nothing(&self, occluders: &NodeOccluders) -> bool {
        let is_object = |k: &u32| self.scene.mesh.is_object(*k);
        let occluded = matches!(self.light, RequestedLight::OccludedBy(_));
        occluded && occluders.as_ref().is_some_and(|faces| !faces.iter().any(is_object))
    }

    /// Returns the `known` occluders, or those that enter the shaft between the node and the blocks' face.
    fn find_occluders(&self, node: &TreeNode, known: NodeOccluders) -> NodeOccluders {
        let Some(receiver) = self.shared_face.as_ref().filter(|_| known.is_none()) else {
            return known;
        };
        let [own, other] = [receiver.face, node.face].map(|k| &self.scene.occluders.faces[k as usize]);
        let corners = node.shooter.corners.map(|c| c.as_dvec3());
        let polygon = ConvexPolygon::new(distinct_corners(&corners));
        let shaft = Shaft::for_rays(&polygon, &other.plane, &own.polygon, &own.plane);
        let ends = [own.sheet, other.sheet];
        self.scene.occluders.faces_blocking_rays(&shaft, ends, MAX_CANDIDATES)
    }

    /// Returns the occluders whose shadows may fall on the blocks' face.
    fn find_shadows(&self, node: &TreeNode, occluders: &NodeOccluders) -> Vec<(u32, ShadowRegion)> {
        let (Some(faces), Some(own)) = (occluders, &self.shared_face) else {
            return Vec::new();
        };
        let plane = &self.scene.occluders.faces[own.face as usize].plane;
        let mut shadows = Vec::new();
        for k in faces {
            let polygon = &self.scene.occluders.faces[*k as usize].polygon;
            let shadow = penumbra_region(&node.shooter.corners, polygon, plane, &own.receiver);
            if shadow != ShadowRegion::Nowhere {
                shadows.push((*k, shadow));
            }
        }
        shadows
    }

    /// Decides about node `k` at block `number`.
    fn refine_interaction(
        &self,
        k: u32,
        node: &TreeNode,
        number: u32,
        occluders: &NodeOccluders,
        shadows: &[(u32, ShadowRegion)],
    ) -> Refinement {
        let block = &self.blocks[number as usize];
        let pair = Interaction {
            mesh: self.scene.mesh,
            number: k,
            node,
            block,
            last_blockers: &self.last_blockers,
        };
        if node.shooter.radius > MAX_SCENE_RADIUS && self.is_hidden_by_one_face(node, block) {
            return Refinement::Skip;
        }
        let arch = self.scene.arch;
        let mut bound = arch.dispatch(BoundTask { pair: &pair });
        let radiosity = &self.radiosity[k as usize];
        let scale = self.scale[number as usize];
        let decision = refine_by_source(node, radiosity, &bound, scale, self.thresholds);
        let (light, places) = match decision {
            SourceRefinement::Skip => return Refinement::Skip,
            SourceRefinement::Subdivide => return Refinement::Subdivide,
            SourceRefinement::Pending { light, points_per_side } => (light, points_per_side),
        };
        let overlaps = |(_, shadow): &&(u32, ShadowRegion)| shadow.may_overlap(block.low, block.high);
        let shadowing: Vec<u32> = shadows.iter().filter(overlaps).map(|(k, _)| *k).collect();
        let factors = arch.dispatch(FactorTask { pair: &pair, places });
        if start_sampling(&mut bound, &factors[..block.count]).is_none() {
            return Refinement::Skip;
        }
        let shadowing = &shadowing[..];
        let query = match (occluders, self.light) {
            (Some(_), RequestedLight::Arriving) => OccluderQuery::Faces(shadowing),
            (None, RequestedLight::Arriving) => OccluderQuery::Rays(self.scene.rays),
            (Some(_), RequestedLight::OccludedBy(_)) => OccluderQuery::ObjectFaces(shadowing),
            (None, RequestedLight::OccludedBy(_)) => OccluderQuery::ObjectRays(self.scene.rays),
        };
        if let OccluderQuery::ObjectFaces(faces) = query
            && !faces.iter().any(|k| self.scene.mesh.is_object(*k))
        {
            return Refinement::Skip;
        }
        if let OccluderQuery::Faces([]) = query {
            let link = arch.dispatch(UnoccludedLinkTask { pair: &pair, factors });
            return Refinement::Link {
                link: Box::new(link),
                crosses_shadow_edge: false,
            };
        }
        let mut known = BlockedSamples::default();
        let sample_link = |samples| {
            arch.dispatch(SampledLinkTask {
                pair: &pair,
                factors,
                query,
                samples,
                known: &mut known,
            })
        };
        choose_visibility_samples(&bound, light, is_leaf(node), self.thresholds, sample_link)
    }

    /// Returns whether one face hides all of a node from all of a block: then it crosses the lines between all corners, since
    /// all three are convex. In a room walls hide nearly all of the sky, which rays could only find piece by piece.
    fn is_hidden_by_one_face(&self, node: &TreeNode, block: &ReceiverBlock) -> bool {
        let LinkerScene { mesh, rays, .. } = self.scene;
        let blocker = Cell::new(NO_FACE);
        let ends = [block.faces[0], node.face];
        rays.find_sight_after(block.mean_centre, node.shooter.centre, ends, false, &blocker);
        let Some(face) = mesh.faces.get(blocker.get() as usize) else {
            return false;
        };
        let points = (0..block.count).flat_map(|l| (0..4).map(move |k| block.lane_corner(k, l)));
        let mut lines = points.flat_map(|from| node.shooter.corners.map(|to| (from, to)));
        lines.all(|(from, to)| {
            let hit = intersect_face(face, from, to - from);
            hit.stops_ray(1.0) && hit.inside >= 0.0 && !touches_plane(face, from)
        })
    }
}

impl SharedFace {
    fn around_blocks(mesh: &Mesh, blocks: &[ReceiverBlock]) -> Option<Self> {
        let face = blocks[0].single_face()?;
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for block in blocks {
            if block.single_face() != Some(face) {
                return None;
            }
            low = low.min(block.low);
            high = high.max(block.high);
        }
        let receiver = ReceiverFace {
            texels: 0..0,
            blocks: Vec::new(),
            low,
            high,
            frame: FaceFrame::new(&mesh.faces[face as usize]),
        };
        Some(Self { face, receiver })
    }
}

/// Links a source that may be occluded, with as many visibility samples as its error needs, or subdivides it
/// where too many were needed. `is_leaf`: the source has no parts.
pub fn choose_visibility_samples(
    bound: &ExchangeBound,
    light: ReflectedLight,
    is_leaf: bool,
    thresholds: LinkThresholds,
    mut sample_link: impl FnMut(u32) -> SampledLink,
) -> Refinement {
    let mut sampled = sample_link(VISIBILITY_SAMPLE_COUNTS[0]);
    if let Some(samples) = request_samples(bound, light, sampled.seen, thresholds) {
        sampled = sample_link(samples);
    }
    let Some(decision) = refine_by_visibility(bound, light, sampled.seen, is_leaf, thresholds) else {
        return Refinement::Subdivide;
    };
    if let Some(samples) = decision.samples {
        sampled = sample_link(samples);
    }
    Refinement::Link {
        link: Box::new(sampled.link),
        crosses_shadow_edge: decision.crosses_shadow_edge,
    }
}
