//! From which nodes a face's blocks gather: a node is cut until what its mean and slope, and a few
//! rays, leave out is below a threshold at the block.

use crate::hierarchy::block::Block;
use crate::hierarchy::light::Glow;
use crate::hierarchy::link::{Bounds, Factors, Found, Link, Open, Pair, Sampled, Stops};
use crate::hierarchy::tree::{Node, Tree};
use crate::occlusion::occluders::Occluders;
use crate::occlusion::polygon::Polygon;
use crate::occlusion::shaft::Shaft;
use crate::rows::candidates::MOST;
use crate::rows::receivers::{Frame, Receiver};
use crate::rows::shadow::{Shadow, shadow};
use common::constants::CONTACT;
use common::mesh::Mesh;
use common::rays::Rays;
use glam::{Vec2, Vec3};
use pulp::Arch;

/// The scene, and what is asked of it.
pub struct World<'a> {
    /// Faces.
    pub mesh: &'a Mesh,
    /// What shoots.
    pub tree: &'a Tree,
    /// All faces, for rays.
    pub rays: &'a Rays,
    /// All faces, for shadows.
    pub occluders: &'a Occluders,
    /// The widest registers.
    pub arch: Arch,
}

/// What a link may leave out, of the RMS of the reflected light.
#[derive(Clone, Copy, Debug)]
pub struct Thresholds {
    /// By how a node's light varies.
    pub source: f32,
    /// By what stands between.
    pub visibility: f32,
    /// By a spot's size.
    pub near: f32,
}

/// Samples of what is partly hidden: first, and at most where a node can be cut and where not.
const SAMPLES: [u32; 3] = [4, 16, 64];
/// So few questions do not pay for a shaft.
const WORTH: usize = 64;

/// What shines on a face's blocks.
pub struct Gather<'a> {
    world: &'a World<'a>,
    glow: &'a [Glow],
    scale: Vec3,
    thresholds: Thresholds,
    blocks: &'a [Block],
    receiver: Receiver,
}

/// What may be between a node and the face.
enum Between {
    Faces(Vec<u32>),
    Anything,
}

/// What is done about a node at a block.
enum Choice {
    Nothing,
    Cut,
    /// And whether a shadow's edge crosses the block.
    Link(Box<Link>, bool),
}

/// A link that is made.
pub struct Made<'a> {
    /// The block's number.
    pub block: usize,
    /// The node's.
    pub node: u32,
    /// The link.
    pub link: &'a Link,
    /// Whether a shadow's edge crosses the block, so that its spots differ by more than the threshold
    /// for `source`.
    pub edge: bool,
}

impl<'a> Gather<'a> {
    /// The `glow` of every node onto `blocks`, which lie on one face; `scale` is the face's reflectance
    /// over the RMS of the reflected light, by channel.
    pub fn new(
        world: &'a World<'a>,
        glow: &'a [Glow],
        scale: Vec3,
        thresholds: Thresholds,
        blocks: &'a [Block],
    ) -> Self {
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for block in blocks {
            low = low.min(block.low);
            high = high.max(block.high);
        }
        let face = &world.mesh.faces[blocks[0].face as usize];
        Self {
            world,
            glow,
            scale,
            thresholds,
            blocks,
            receiver: Receiver {
                texels: 0..0,
                blocks: Vec::new(),
                low,
                high,
                frame: Frame::new(face),
            },
        }
    }

    fn face(&self) -> usize {
        self.blocks[0].face as usize
    }

    /// Every link to the blocks, by source face in the scene's order.
    pub fn links(&self, mut take: impl FnMut(Made)) {
        let active: Vec<u32> = (0..self.blocks.len() as u32).collect();
        let own = &self.world.mesh.faces[self.face()];
        for (s, root) in self.world.tree.roots.iter().enumerate() {
            let source = &self.world.mesh.faces[s];
            if s == self.face() || !own.faces(source) || self.is_dark(*root) {
                continue;
            }
            self.visit(*root, &active, Between::Anything, &mut take);
        }
    }

    fn is_dark(&self, k: u32) -> bool {
        let glow = &self.glow[k as usize];
        glow.mean == Vec3::ZERO && glow.rest == Vec3::ZERO
    }

    fn visit(&self, k: u32, active: &[u32], between: Between, take: &mut impl FnMut(Made)) {
        let node = &self.world.tree.nodes[k as usize];
        if node.shooter.area <= 0.0 || self.is_dark(k) || self.is_beneath(node) {
            return;
        }
        let between = self.between(node, between, active);
        let shadows = self.shadows(node, &between);
        let mut cut = Vec::new();
        for b in active {
            match self.choose(k, node, &self.blocks[*b as usize], &between, &shadows) {
                Choice::Nothing => {}
                Choice::Cut => cut.push(*b),
                Choice::Link(link, edge) => take(Made {
                    block: *b as usize,
                    node: k,
                    link: &link,
                    edge,
                }),
            }
        }
        if cut.is_empty() {
            return;
        }
        let left: Vec<u32> = shadows.iter().map(|(k, _)| *k).collect();
        for child in node.children.clone() {
            let between = match between {
                Between::Faces(_) => Between::Faces(left.clone()),
                Between::Anything => Between::Anything,
            };
            self.visit(child, &cut, between, take);
        }
    }

    /// Whether no corner is above the face's plane.
    fn is_beneath(&self, node: &Node) -> bool {
        let plane = self.world.mesh.faces[self.face()].plane;
        let corners = node.shooter.corners.iter();
        corners
            .map(|c| plane.truncate().dot(*c) - plane.w)
            .all(|height| height <= CONTACT)
    }

    /// What is known to be between, or a shaft finds where it pays.
    fn between(&self, node: &Node, known: Between, active: &[u32]) -> Between {
        let lanes: usize = active.iter().map(|b| self.blocks[*b as usize].count).sum();
        if matches!(known, Between::Faces(_)) || lanes * (SAMPLES[0] as usize) < WORTH {
            return known;
        }
        let [own, other] =
            [self.face(), node.face as usize].map(|k| &self.world.occluders.faces[k]);
        let corners = node.shooter.corners.map(|c| c.as_dvec3());
        let count = if node.shooter.corners[2] == node.shooter.corners[3] {
            3
        } else {
            4
        };
        let polygon = Polygon::new(&corners[..count]);
        let shaft = Shaft::rays(&polygon, &other.plane, &own.polygon, &own.plane);
        let mut faces = Vec::new();
        self.world
            .occluders
            .stopping(&shaft, [own.sheet, other.sheet], &mut faces);
        if faces.len() > MOST {
            return Between::Anything;
        }
        Between::Faces(faces)
    }

    fn shadows(&self, node: &Node, between: &Between) -> Vec<(u32, Shadow)> {
        let Between::Faces(faces) = between else {
            return Vec::new();
        };
        let plane = &self.world.occluders.faces[self.face()].plane;
        let mut found = Vec::new();
        for k in faces {
            let polygon = &self.world.occluders.faces[*k as usize].polygon;
            let shadow = shadow(&node.shooter.corners, polygon, plane, &self.receiver);
            if shadow != Shadow::Nowhere {
                found.push((*k, shadow));
            }
        }
        found
    }

    fn choose(
        &self,
        k: u32,
        node: &Node,
        block: &Block,
        between: &Between,
        shadows: &[(u32, Shadow)],
    ) -> Choice {
        let pair = Pair {
            mesh: self.world.mesh,
            number: k,
            node,
            block,
        };
        let arch = self.world.arch;
        let bound = arch.dispatch(Bounds { pair: &pair });
        if bound.factor <= 0.0 {
            return Choice::Nothing;
        }
        let glow = &self.glow[k as usize];
        let share = |light: Vec3| (light.abs() * self.scale).max_element();
        let (mean, rest) = (share(glow.mean), share(glow.rest));
        let slope = share(glow.slope[0]).max(share(glow.slope[1])) * node.shooter.radius;
        let whole = node.children.is_empty();
        let varies = rest * bound.uneven + slope * bound.sloped;
        if varies > self.thresholds.source && !whole {
            return Choice::Cut;
        }
        let mut over = [0u32; MOST];
        let mut count = 0;
        for (k, shadow) in shadows {
            if shadow.falls(block.low, block.high) {
                over[count] = *k;
                count += 1;
            }
        }
        let off = bound.within * (mean + rest) / self.thresholds.near;
        let places = match off {
            ..1.0 => 1,
            1.0..10.0 => 2,
            10.0..100.0 => 4,
            _ => 8,
        };
        let factors = arch.dispatch(Factors {
            pair: &pair,
            places,
        });
        let stops = match between {
            Between::Faces(_) => Stops::Faces(&over[..count]),
            Between::Anything => Stops::Any(self.world.rays),
        };
        if let Stops::Faces([]) = stops {
            let link = arch.dispatch(Open {
                pair: &pair,
                factors,
            });
            return Choice::Link(Box::new(link), false);
        }
        let sampled = |samples| {
            arch.dispatch(Sampled {
                pair: &pair,
                factors,
                stops,
                samples,
            })
        };
        let first: Found = sampled(SAMPLES[0]);
        let spread = (first.seen * (1.0 - first.seen)).max(0.0).sqrt().max(0.125);
        let doubt = bound.factor * (mean + rest) * spread * 0.5 / self.thresholds.visibility;
        let hides = bound.factor * rest * spread / self.thresholds.source;
        let mixed = (first.seen * (1.0 - first.seen)).max(0.0).sqrt();
        let edge = bound.factor * (mean + rest) * mixed > self.thresholds.source;
        // What S stratified samples leave falls as S^(−3/4).
        let needed = doubt.max(0.0).powf(4.0 / 3.0);
        if needed <= SAMPLES[0] as f32 && (hides <= 1.0 || whole) {
            return Choice::Link(Box::new(first.link), edge);
        }
        if !whole && (hides > 1.0 || needed > SAMPLES[1] as f32) {
            return Choice::Cut;
        }
        let samples = (needed.ceil() as u32).clamp(SAMPLES[0], SAMPLES[2]);
        Choice::Link(Box::new(sampled(samples).link), edge)
    }
}
