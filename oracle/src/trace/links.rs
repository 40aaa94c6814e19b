//! The record of a solve to an error by links: the nodes of each step, and the links over which they received light.
//!
//! A recorder stands before the linker of each step ([`LinkRecord::recording_factory`]). The solver's requests come in one order
//! ([`cpu::hierarchy::solver`]): an estimate at the coarse nodes; direct light, level by level; the links of the coarse nodes;
//! the final gather, level by level, and one more for each correction.

use crate::solve::step::SolveStep;
use common::Result;
use common::mesh::Mesh;
use common::passes::ProgressCallback;
use cpu::hierarchy::coarse::StoredLink;
use cpu::hierarchy::cpu_linker::CpuLinker;
use cpu::hierarchy::linear_radiosity::LinearRadiosity;
use cpu::hierarchy::linker::{BlockIrradiance, LinkRequest, Linker, LinkerFactory, LinkerScene};
use glam::Vec3;
use std::cell::RefCell;
use std::collections::HashSet;
use std::rc::Rc;

/// Links expected of each block at least: a request of more blocks than the record could hold so is not recorded, before its links
/// take memory.
const LEAST_LINKS_PER_BLOCK: usize = 32;
/// Number of the gather that holds direct light: the first is the estimate.
const DIRECT_GATHER: usize = 2;
/// Number of the first final gather.
const FINAL_GATHER: usize = 3;

/// A node of a tree over the texels of a face.
#[derive(Clone, Copy, Debug)]
pub struct RecordedNode {
    /// Number of the parent; a root is its own parent.
    pub parent: u32,
    /// Number of the face.
    pub face: u32,
    /// The mesh's number of the texel; none if the node has children.
    pub texel: Option<u32>,
    /// Outline; a triangle repeats its third corner.
    pub corners: [Vec3; 4],
}

/// A node, or the open part of a texel, that received light.
#[derive(Clone, Copy, Debug)]
pub struct RecordedSpot {
    /// Number of the node.
    pub node: u32,
    /// Share of the node's area.
    pub share: f32,
    /// H over all links, W/m²; 0 where links are stored for later.
    pub irradiance: Vec3,
}

/// Up to sixteen spots and their links.
pub struct RecordedBlock {
    /// Receivers.
    pub spots: Vec<RecordedSpot>,
    /// Links from nodes to these.
    pub links: Vec<StoredLink>,
}

/// Light that was gathered, or links that were stored, at all receivers of a part of the solve.
#[derive(Default)]
pub struct RecordedGather {
    /// Receivers: where a node was divided, its children alone.
    pub blocks: Vec<RecordedBlock>,
    /// Radiosity of each node, W/m².
    pub radiosity: Vec<LinearRadiosity>,
}

/// The links of one step.
#[derive(Default)]
pub struct StepLinks {
    /// Nodes of the trees of all faces.
    pub nodes: Vec<RecordedNode>,
    /// Links from lamps.
    pub direct: RecordedGather,
    /// Links between coarse nodes.
    pub coarse: RecordedGather,
    /// Links of the final gather, without its corrections.
    pub fine: RecordedGather,
    /// Number of gathers that corrected the final gather.
    pub corrections: usize,
}

/// A step of the solve.
pub struct TracedStep {
    /// Requested error of this step.
    pub goal: f64,
    /// Texels.
    pub mesh: Mesh,
    /// H of each texel, the mean over its area, W/m².
    pub irradiance: Vec<Vec3>,
    /// Links.
    pub links: StepLinks,
}

/// The record of a solve.
#[derive(Default)]
pub struct LinkTrace {
    /// The first steps; all of them if there are [`Self::step_count`].
    pub steps: Vec<TracedStep>,
    /// Number of steps of the solve.
    pub step_count: usize,
}

impl RecordedGather {
    /// Returns the number of links from nodes to blocks.
    pub fn link_count(&self) -> usize {
        self.blocks.iter().map(|block| block.links.len()).sum()
    }

    /// Keeps the blocks that have a spot whose node was not divided.
    fn drop_divided_nodes(&mut self, nodes: &[RecordedNode]) {
        let spots = self.blocks.iter().flat_map(|block| &block.spots);
        let parents = spots.map(|spot| (spot.node, nodes[spot.node as usize].parent));
        let divided: HashSet<u32> = parents.filter(|(k, parent)| k != parent).map(|own| own.1).collect();
        let is_last = |spot: &RecordedSpot| !divided.contains(&spot.node);
        self.blocks.retain(|block| block.spots.iter().any(is_last));
    }
}

impl StepLinks {
    /// Returns the number of links from nodes to blocks.
    pub fn link_count(&self) -> usize {
        let gathers = [&self.direct, &self.coarse, &self.fine];
        gathers.map(RecordedGather::link_count).iter().sum()
    }
}

/// The step that is being solved.
#[derive(Default)]
struct OpenStep {
    links: StepLinks,
    /// Number of gathers that have begun.
    gathers: usize,
    /// Nodes of the last request.
    receivers: HashSet<u32>,
    /// True if the step has more links than are recorded.
    is_too_large: bool,
}

/// Receives the record of a solve.
pub struct LinkRecord {
    /// Maximum number of links from nodes to blocks, of all steps together.
    max_links: usize,
    trace: RefCell<LinkTrace>,
    open: RefCell<OpenStep>,
}

impl LinkRecord {
    /// Makes an empty record, which ends with the step before the one that would exceed `max_links`.
    pub fn new(max_links: usize) -> Rc<Self> {
        Rc::new(Self {
            max_links,
            trace: RefCell::default(),
            open: RefCell::default(),
        })
    }

    /// Returns a factory of linkers that pass every request to those of `linkers`, or to the CPU's, and record the answers.
    pub fn recording_factory<'m>(
        self: &Rc<Self>,
        linkers: Option<LinkerFactory<'m>>,
    ) -> impl for<'w> Fn(&LinkerScene<'w>) -> Result<Box<dyn Linker + 'w>> + 'm {
        let record = Rc::clone(self);
        move |scene| {
            let linker: Box<dyn Linker> = match linkers {
                Some(factory) => factory(scene)?,
                None => Box::new(CpuLinker {
                    scene: *scene,
                    rays_only: false,
                }),
            };
            record.open.replace(OpenStep::new(scene));
            Ok(Box::new(LinkRecorder {
                linker,
                record: Rc::clone(&record),
            }))
        }
    }

    /// Ends the step that was solved to `goal`.
    pub fn end_step(&self, step: &SolveStep, goal: f64) {
        let OpenStep {
            mut links,
            gathers,
            is_too_large,
            ..
        } = self.open.take();
        let mut trace = self.trace.borrow_mut();
        trace.step_count += 1;
        let before: usize = trace.steps.iter().map(|step| step.links.link_count()).sum();
        let goes_on = trace.steps.len() + 1 == trace.step_count;
        if !goes_on || is_too_large || before + links.link_count() > self.max_links {
            return;
        }
        for gather in [&mut links.direct, &mut links.fine] {
            gather.drop_divided_nodes(&links.nodes);
        }
        links.corrections = gathers.saturating_sub(FINAL_GATHER);
        trace.steps.push(TracedStep {
            goal,
            mesh: step.mesh.clone(),
            irradiance: step.outcome.irradiance.clone(),
            links,
        });
    }

    /// Returns whether the links of `request` may be recorded with those of the step so far; if not, none of the step are.
    fn has_room_for(&self, open: &mut OpenStep, request: &LinkRequest) -> bool {
        let least = LEAST_LINKS_PER_BLOCK.saturating_mul(request.receivers.blocks.len());
        open.is_too_large |= open.links.link_count().saturating_add(least) > self.max_links;
        !open.is_too_large
    }

    /// Takes the record of the solve.
    pub fn take_trace(&self) -> LinkTrace {
        self.trace.take()
    }
}

impl OpenStep {
    fn new(scene: &LinkerScene) -> Self {
        let tree = scene.tree;
        let nodes = tree.nodes.iter().enumerate().map(|(k, node)| RecordedNode {
            parent: node.parent,
            face: node.face,
            texel: node.children.is_empty().then(|| tree.leaves_of(k as u32)[0].texel),
            corners: node.shooter.corners,
        });
        let nodes = nodes.collect();
        Self {
            links: StepLinks {
                nodes,
                ..StepLinks::default()
            },
            ..Self::default()
        }
    }

    /// Takes notice of a request to gather, and returns where its links are recorded; none of an estimate or a correction.
    fn begin_request(&mut self, request: &LinkRequest) -> Option<&mut RecordedGather> {
        let targets = request
            .receivers
            .blocks
            .iter()
            .flat_map(|block| &block.target[..block.count]);
        let first = targets
            .clone()
            .next()
            .map(|k| (*k, self.links.nodes[*k as usize].parent));
        // A gather goes on with the children of nodes that have received.
        let goes_on = first.is_some_and(|(k, parent)| k != parent && self.receivers.contains(&parent));
        self.gathers += usize::from(!goes_on);
        self.receivers = targets.copied().collect();
        match (self.gathers, self.links.coarse.blocks.is_empty()) {
            (DIRECT_GATHER, true) => Some(&mut self.links.direct),
            (FINAL_GATHER, false) => Some(&mut self.links.fine),
            _ => None,
        }
    }
}

/// A linker that passes every request to another and records the answers.
struct LinkRecorder<'w> {
    linker: Box<dyn Linker + 'w>,
    record: Rc<LinkRecord>,
}

impl Linker for LinkRecorder<'_> {
    fn gather_irradiance(&self, request: &LinkRequest, watch: ProgressCallback) -> Result<Vec<BlockIrradiance>> {
        let lit = self.linker.gather_irradiance(request, watch)?;
        let mut open = self.record.open.borrow_mut();
        let has_room = self.record.has_room_for(&mut open, request);
        if let Some(gather) = open.begin_request(request).filter(|_| has_room) {
            let links = self.linker.create_links(request, watch)?;
            gather.add_blocks(request, links, |block, l| {
                Vec3::from_array([0, 1, 2].map(|c| lit[block].sums[c][l]))
            });
        }
        Ok(lit)
    }

    fn create_links(&self, request: &LinkRequest, watch: ProgressCallback) -> Result<Vec<Vec<StoredLink>>> {
        let links = self.linker.create_links(request, watch)?;
        let mut open = self.record.open.borrow_mut();
        if self.record.has_room_for(&mut open, request) {
            open.links.coarse.add_blocks(request, links.clone(), |_, _| Vec3::ZERO);
        }
        Ok(links)
    }
}

impl RecordedGather {
    /// Adds the blocks of `request` with their `links`; `irradiance` is that of a block's spot.
    fn add_blocks(
        &mut self,
        request: &LinkRequest,
        links: Vec<Vec<StoredLink>>,
        irradiance: impl Fn(usize, usize) -> Vec3,
    ) {
        self.radiosity = request.radiosity.to_vec();
        for (number, (block, links)) in request.receivers.blocks.iter().zip(links).enumerate() {
            let spot = |l: usize| RecordedSpot {
                node: block.target[l],
                share: block.share[l],
                irradiance: irradiance(number, l),
            };
            self.blocks.push(RecordedBlock {
                spots: (0..block.count).map(spot).collect(),
                links,
            });
        }
    }
}
