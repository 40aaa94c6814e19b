//! From which nodes a face's blocks gather: a node is cut until what its mean and slope, and a few
//! rays, leave out is below a threshold at the block.

use crate::hierarchy::block::Block;
use crate::hierarchy::choice::{Choice, places, through};
use crate::hierarchy::cluster::{Cluster, Part};
use crate::hierarchy::cluster_link::Group;
use crate::hierarchy::light::Glow;
use crate::hierarchy::link::{
    Bounds, Ended, Factors, Known, Link, Open, Pair, Sampled, Stops, nobody,
};
use crate::hierarchy::question::Question;
use crate::hierarchy::tree::Node;
use crate::hierarchy::world::{Thresholds, What, World};
use crate::occlusion::polygon::Polygon;
use crate::occlusion::shaft::Shaft;
use crate::rows::candidates::MOST;
use crate::rows::receivers::{Frame, Receiver};
use crate::rows::shadow::{Shadow, shadow};
use common::constants::{CONTACT, EDGE, ROOTS};
use common::mesh::Mesh;
use common::rays::Sight;
use glam::{Vec2, Vec3};
use std::borrow::Cow;

/// The faces of a cluster look no farther aside than by the angle of this cosine.
const CONE: f32 = 0.5;

/// A cluster of fewer faces does not pay where shafts tell what is between.
const FACES: usize = 16;

/// What shines on some blocks.
pub struct Gather<'a> {
    world: &'a World<'a>,
    what: What<'a>,
    glow: &'a [Glow],
    thresholds: Thresholds,
    blocks: &'a [Block],
    /// By block.
    scale: Vec<Vec3>,
    /// Where all lie on one face.
    own: Option<Own>,
    ended: Ended,
}

/// The face of all blocks, as far as they cover it.
struct Own {
    face: u32,
    receiver: Receiver,
}

/// What may be between a node and the blocks.
enum Between {
    Faces(Vec<u32>),
    Anything,
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
    /// What is asked for, onto `blocks`.
    pub fn new(world: &'a World<'a>, question: &Question<'a>, blocks: &'a [Block]) -> Self {
        Self {
            world,
            what: question.what,
            glow: question.glow,
            thresholds: question.thresholds,
            blocks,
            scale: blocks.iter().map(|b| question.scale_of(b)).collect(),
            own: Own::of(world.mesh, blocks),
            ended: nobody(),
        }
    }

    /// Every link to the blocks, in the order of the clusters.
    pub fn links(&self, mut take: impl FnMut(Made)) {
        let active: Vec<u32> = (0..self.blocks.len() as u32).collect();
        if self.world.clusters.all.is_empty() {
            return;
        }
        self.visit_cluster(0, &active, &mut take);
    }

    /// The same by rays alone, face by face: block after block, level after level of the trees.
    pub fn by_rays(&self, mut take: impl FnMut(Made)) {
        let tree = self.world.tree;
        for (block, roots) in (0..self.blocks.len())
            .flat_map(|block| tree.roots.chunks(ROOTS).map(move |roots| (block, roots)))
        {
            let mut level = roots.to_vec();
            while !level.is_empty() {
                let mut parts = Vec::new();
                for k in level {
                    let node = &tree.nodes[k as usize];
                    if node.shooter.area <= 0.0 || self.is_dark(k) {
                        continue;
                    }
                    match self.choose(k, node, block as u32, &Between::Anything, &[]) {
                        Choice::Nothing => {}
                        Choice::Cut => parts.extend(node.children.clone()),
                        Choice::Link(link, edge) => take(Made {
                            block,
                            node: k,
                            link: &link,
                            edge,
                        }),
                    }
                }
                level = parts;
            }
        }
    }

    fn is_dark(&self, k: u32) -> bool {
        let glow = &self.glow[k as usize];
        glow.mean == Vec3::ZERO && glow.slope == [Vec3::ZERO; 2] && glow.rest == Vec3::ZERO
    }

    /// Of the `active` blocks those at which something can be found of what shines within a ball.
    fn reached<'b>(&self, active: &'b [u32], ball: (Vec3, f32)) -> Cow<'b, [u32]> {
        let What::Taken(objects) = self.what else {
            return Cow::Borrowed(active);
        };
        let reached = |b: &&u32| {
            let block = &self.blocks[**b as usize];
            objects.between(ball, (block.middle, block.reach))
        };
        active.iter().filter(reached).copied().collect()
    }

    fn visit_cluster(&self, k: u32, active: &[u32], take: &mut impl FnMut(Made)) {
        let number = self.world.tree.nodes.len() as u32 + k;
        let cluster = &self.world.clusters.all[k as usize];
        // What looks everywhere may have no flow and shine all the same.
        let wide = cluster.cone < CONE;
        let active = self.reached(active, (cluster.centre, cluster.radius));
        if !wide && self.is_dark(number) || active.is_empty() {
            return;
        }
        // Exact factors and shadows of a few faces cost less than rays.
        let few = cluster.faces.len() < FACES && self.shafts_tell(cluster);
        let mut cut = Vec::new();
        for b in active.iter() {
            let choice = if wide || few {
                Choice::Cut
            } else {
                self.choose_cluster(k, *b)
            };
            match choice {
                Choice::Nothing => {}
                Choice::Cut => cut.push(*b),
                Choice::Link(link, edge) => take(Made {
                    block: *b as usize,
                    node: number,
                    link: &link,
                    edge,
                }),
            }
        }
        if cut.is_empty() {
            return;
        }
        for part in cluster.parts {
            match part {
                Part::Cluster(c) => self.visit_cluster(c, &cut, take),
                Part::Face(f) => self.visit_face(f, &cut, take),
            }
        }
    }

    /// Whether little enough is before a cluster that shafts tell of it: asked of its first face.
    fn shafts_tell(&self, cluster: &Cluster) -> bool {
        let first = self.world.clusters.order[cluster.faces.start as usize];
        let root = &self.world.tree.nodes[self.world.tree.roots[first as usize] as usize];
        let tells = || matches!(self.between(root, Between::Anything), Between::Faces(_));
        self.own.is_some() && (root.shooter.area <= 0.0 || tells())
    }

    fn visit_face(&self, f: u32, active: &[u32], take: &mut impl FnMut(Made)) {
        let faces = &self.world.mesh.faces;
        if let Some(own) = &self.own
            && (f == own.face || !faces[own.face as usize].faces(&faces[f as usize]))
        {
            return;
        }
        let root = self.world.tree.roots[f as usize];
        self.visit(root, active, Between::Anything, take);
    }

    fn visit(&self, k: u32, active: &[u32], between: Between, take: &mut impl FnMut(Made)) {
        let node = &self.world.tree.nodes[k as usize];
        let ball = (node.shooter.centre, node.shooter.radius);
        if node.shooter.area <= 0.0 || self.is_dark(k) || self.is_beneath(node) {
            return;
        }
        let active = self.reached(active, ball);
        let between = self.between(node, between);
        if self.leaves_all(&between) {
            return;
        }
        let shadows = self.shadows(node, &between);
        let mut cut = Vec::new();
        for b in active.iter() {
            match self.choose(k, node, *b, &between, &shadows) {
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

    /// Whether no corner is above the plane of the blocks' face.
    fn is_beneath(&self, node: &Node) -> bool {
        let Some(own) = &self.own else {
            return false;
        };
        let plane = self.world.mesh.faces[own.face as usize].plane;
        let corners = node.shooter.corners.iter();
        corners
            .map(|c| plane.truncate().dot(*c) - plane.w)
            .all(|height| height <= CONTACT)
    }

    /// Whether nothing is between that could take anything.
    fn leaves_all(&self, between: &Between) -> bool {
        match (self.what, between) {
            (What::Taken(_), Between::Faces(faces)) => {
                !faces.iter().any(|k| self.world.mesh.is_object(*k))
            }
            _ => false,
        }
    }

    /// What is known to be between, or what a shaft finds.
    fn between(&self, node: &Node, known: Between) -> Between {
        let Some(receiver) = &self.own else {
            return known;
        };
        if matches!(known, Between::Faces(_)) {
            return known;
        }
        let [own, other] =
            [receiver.face, node.face].map(|k| &self.world.occluders.faces[k as usize]);
        let corners = node.shooter.corners.map(|c| c.as_dvec3());
        let count = if node.shooter.corners[2] == node.shooter.corners[3] {
            3
        } else {
            4
        };
        let polygon = Polygon::new(&corners[..count]);
        let shaft = Shaft::rays(&polygon, &other.plane, &own.polygon, &own.plane);
        let ends = [own.sheet, other.sheet];
        let faces = self.world.occluders.stopping(&shaft, ends, MOST);
        faces.map_or(Between::Anything, Between::Faces)
    }

    fn shadows(&self, node: &Node, between: &Between) -> Vec<(u32, Shadow)> {
        let (Between::Faces(faces), Some(own)) = (between, &self.own) else {
            return Vec::new();
        };
        let plane = &self.world.occluders.faces[own.face as usize].plane;
        let mut found = Vec::new();
        for k in faces {
            let polygon = &self.world.occluders.faces[*k as usize].polygon;
            let shadow = shadow(&node.shooter.corners, polygon, plane, &own.receiver);
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
        number: u32,
        between: &Between,
        shadows: &[(u32, Shadow)],
    ) -> Choice {
        let block = &self.blocks[number as usize];
        let pair = Pair {
            mesh: self.world.mesh,
            number: k,
            node,
            block,
            ended: &self.ended,
        };
        let arch = self.world.arch;
        let mut bound = arch.dispatch(Bounds { pair: &pair });
        if bound.factor <= 0.0 {
            return Choice::Nothing;
        }
        let glow = &self.glow[k as usize];
        let [mean, rest, x, y] =
            [glow.mean, glow.rest, glow.slope[0], glow.slope[1]].map(|v| self.share(v, number));
        let slope = x.max(y) * node.shooter.radius;
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
        let places = places(bound.within, mean + rest, self.thresholds.near);
        let factors = arch.dispatch(Factors {
            pair: &pair,
            places,
        });
        let most = factors[..block.count].iter().copied().fold(0.0, f32::max);
        bound.factor = bound.factor.min(EDGE * most);
        if most <= 0.0 {
            return Choice::Nothing;
        }
        let over = &over[..count];
        let stops = match (between, self.what) {
            (Between::Faces(_), What::Light) => Stops::Faces(over),
            (Between::Anything, What::Light) => Stops::Any(self.world.rays),
            (Between::Faces(_), What::Taken(_)) => Stops::Kept(over),
            (Between::Anything, What::Taken(_)) => Stops::Left(self.world.rays),
        };
        if let Stops::Kept(over) = stops
            && !over.iter().any(|k| self.world.mesh.is_object(*k))
        {
            return Choice::Nothing;
        }
        if let Stops::Faces([]) = stops {
            let link = arch.dispatch(Open {
                pair: &pair,
                factors,
            });
            return Choice::Link(Box::new(link), false);
        }
        let mut known = Known::default();
        let sampled = |samples| {
            arch.dispatch(Sampled {
                pair: &pair,
                factors,
                stops,
                samples,
                known: &mut known,
            })
        };
        through(&bound, [mean, rest], whole, self.thresholds, sampled)
    }

    fn choose_cluster(&self, k: u32, number: u32) -> Choice {
        let group = Group {
            mesh: self.world.mesh,
            tree: self.world.tree,
            clusters: self.world.clusters,
            rays: self.world.rays,
            number: k,
            block: &self.blocks[number as usize],
            passes: match self.what {
                What::Light => Sight::Clear,
                What::Taken(_) => Sight::Hidden,
            },
            ended: &self.ended,
        };
        let bound = group.bound();
        if bound.factor <= 0.0 {
            return Choice::Nothing;
        }
        let glow = &self.glow[self.world.tree.nodes.len() + k as usize];
        // Within the cone the flow is half of what the faces shine, or more.
        let flow = [glow.mean, glow.slope[0], glow.slope[1]].map(|v| v * v);
        let mean = self.share((flow[0] + flow[1] + flow[2]).map(f32::sqrt), number) / CONE;
        let rest = self.share(glow.rest, number);
        if rest * bound.uneven + mean * bound.sloped > self.thresholds.source {
            return Choice::Cut;
        }
        let places = places(bound.within, mean + rest, self.thresholds.near);
        let mut asked = group.asked(places);
        let sampled = |samples| asked.sampled(samples);
        through(&bound, [mean, rest], false, self.thresholds, sampled)
    }

    /// Of the RMS of the reflected light, what a block would reflect of `light` at F = 1.
    fn share(&self, light: Vec3, number: u32) -> f32 {
        (light.abs() * self.scale[number as usize]).max_element()
    }
}

impl Own {
    fn of(mesh: &Mesh, blocks: &[Block]) -> Option<Self> {
        let face = blocks[0].face()?;
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for block in blocks {
            if block.face() != Some(face) {
                return None;
            }
            low = low.min(block.low);
            high = high.max(block.high);
        }
        let receiver = Receiver {
            texels: 0..0,
            blocks: Vec::new(),
            low,
            high,
            frame: Frame::new(&mesh.faces[face as usize]),
        };
        Some(Self { face, receiver })
    }
}
