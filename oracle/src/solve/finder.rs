//! The GPU as a finder of links for the CPU's hierarchical solve: plain records go in and come out.

use common::Result;
use cpu::hierarchy::block::Block;
use cpu::hierarchy::coarse::Kept;
use cpu::hierarchy::descent::Lit;
use cpu::hierarchy::find::Finder;
use cpu::hierarchy::link::Link;
use cpu::hierarchy::question::Question;
use cpu::hierarchy::tree;
use cpu::hierarchy::world::{Watch, World};
use glam::Vec4;
use gpu::hierarchy::finder;
use gpu::linked::{
    BlockRecord, GlowRecord, Node, Received, Receiver, SPOTS, SpotRecord, Thresholds,
};
use gpu::{Fault, Gpu};
use std::cell::RefCell;
use std::ops::ControlFlow;

/// The GPU.
pub struct OnGpu {
    finder: RefCell<finder::Finder>,
    nodes: usize,
    /// Each face's.
    planes: Vec<Vec4>,
}

impl OnGpu {
    /// For a scene whose tree is there; shaders are wrong where `faults` say so.
    ///
    /// Errors: [`common::Error::Device`].
    pub fn new(gpu: &Gpu, world: &World, faults: &[Fault]) -> Result<Self> {
        let nodes: Vec<Node> = world.tree.nodes.iter().map(node).collect();
        let finder = finder::Finder::new(gpu, world.mesh, &nodes, &world.tree.roots, faults)?;
        Ok(Self {
            finder: RefCell::new(finder),
            nodes: nodes.len(),
            planes: world.mesh.faces.iter().map(|face| face.plane).collect(),
        })
    }

    /// Makes it.
    pub fn maker<'m>(
        gpu: &'m Gpu,
        faults: &'m [Fault],
    ) -> impl for<'w> Fn(&World<'w>) -> Result<Box<dyn Finder + 'w>> + 'm {
        move |world| Ok(Box::new(Self::new(gpu, world, faults)?))
    }

    /// Tells the device what shines, and gives back who receives.
    fn tell(&self, question: &Question) -> Vec<Receiver> {
        let glows = question.glow[..self.nodes].iter();
        let glows: Vec<GlowRecord> = glows
            .map(|glow| GlowRecord::new(glow.mean, glow.slope, glow.rest))
            .collect();
        let thresholds = Thresholds {
            source: question.thresholds.source,
            visibility: question.thresholds.visibility,
            near: question.thresholds.near,
        };
        self.finder.borrow_mut().tell(&glows, thresholds);
        let blocks = question.receivers.blocks.iter();
        blocks
            .map(|block| receiver(question, block, &self.planes))
            .collect()
    }
}

impl Finder for OnGpu {
    fn gathered(&self, question: &Question, watch: Watch) -> Result<Vec<Lit>> {
        let blocks = self.tell(question);
        let mut told = told(question, blocks.len(), watch);
        let found = self.finder.borrow_mut().gathered(&blocks, &mut told)?;
        Ok(found.iter().map(lit).collect())
    }

    fn kept(&self, question: &Question, watch: Watch) -> Result<Vec<Vec<Kept>>> {
        let blocks = self.tell(question);
        let mut told = told(question, blocks.len(), watch);
        let found = self.finder.borrow_mut().kept(&blocks, &mut told)?;
        let of_block = |links: &Vec<gpu::linked::Link>| links.iter().map(kept).collect();
        Ok(found.iter().map(of_block).collect())
    }
}

fn node(node: &tree::Node) -> Node {
    Node {
        shooter: node.shooter,
        face: node.face,
        children: node.children.clone(),
    }
}

fn receiver(question: &Question, block: &Block, planes: &[Vec4]) -> Receiver {
    let centres = block.centres();
    let spot = |l: usize| {
        let corners = [0, 1, 2, 3].map(|k| block.corner(k, l));
        let ends = [block.faces[l], block.target[l]];
        SpotRecord::new(corners, centres.at(l), ends, block.normal(l))
    };
    let scale = question.scale_of(block);
    let plane = block.face().map(|face| planes[face as usize]);
    let (count, plane) = (block.count as u32, plane.unwrap_or_default());
    let ball = (block.middle, block.reach);
    Receiver {
        spots: std::array::from_fn(spot),
        block: BlockRecord::new(scale, block.radius, count, plane, ball),
    }
}

/// How far the solve has come after so many blocks of `all`.
fn told<'w>(
    question: &Question,
    all: usize,
    watch: Watch<'w>,
) -> impl FnMut(usize) -> ControlFlow<()> + 'w {
    let part = question.part.clone();
    move |done| {
        let share = done as f64 / all.max(1) as f64;
        watch(part.start + share * (part.end - part.start))
    }
}

fn lit(received: &Received) -> Lit {
    let lane = |c: usize| received.sums.map(|sum| sum[c]);
    Lit {
        sums: [0, 1, 2].map(lane),
        edge: received.edge,
    }
}

fn kept(link: &gpu::linked::Link) -> Kept {
    let lane = |part: usize| -> [f32; SPOTS as usize] { link.spots.map(|spot| spot[part]) };
    Kept {
        node: link.node,
        link: Link {
            weight: lane(0),
            along: [lane(1), lane(2)],
        },
    }
}
