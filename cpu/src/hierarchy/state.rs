//! A scene that is being solved, and what is asked of it: all texels, coarse links that are kept, light sent
//! over them.

use crate::hierarchy::block::Receivers;
use crate::hierarchy::cluster::Clusters;
use crate::hierarchy::coarse::{Coarse, Kept, exchange};
use crate::hierarchy::descent::{Descent, Feet, Lit, Receiving};
use crate::hierarchy::find::{Finder, OnCpu, Way};
use crate::hierarchy::light::{Glow, pull};
use crate::hierarchy::question::Question;
use crate::hierarchy::spend::Bounces;
use crate::hierarchy::tree::{Leaf, Tree};
use crate::hierarchy::world::{Thresholds, Watch, What, World};
use crate::matrix::open::{Element, feet};
use crate::occlusion::occluders::Occluders;
use common::mesh::{Mesh, Texel};
use common::rays::Rays;
use common::scene::Scene;
use common::{Error, Result};
use glam::{DVec3, Vec3};
use pulp::Arch;
use std::ops::{ControlFlow, Range};

/// Coarse receivers are no larger (the mesh is two units wide at most).
const COARSE: f32 = 0.09;
/// Nor where their light is known to be off by more than so many times what is asked: there light goes round
/// among what is smaller, as beneath a body that leans.
const ROUGH: f32 = 0.5;
/// But they need not be smaller than this: what they tell wrongly is gathered again.
const FINE: f32 = COARSE / 8.0;
/// A face that reflects less counts as much as this one: its irradiance is asked for as well.
const DARKEST: f32 = 0.1;
/// Where a solve makes its links and spends its light, of the whole, roughly.
const LINKS: Range<f64> = 0.2..0.45;
/// See [`LINKS`].
const SPENDING: f64 = 0.5;

/// `task` with the tree, the rays and the open parts of `mesh`; `off` is how far coarse light is known to be
/// off at each texel, over what is asked; empty: nobody knows.
pub(super) fn prepared<T>(
    scene: &Scene,
    mesh: &Mesh,
    off: &[f32],
    way: Way,
    task: impl FnOnce(Solve) -> Result<T>,
) -> Result<T> {
    let tree = Tree::new(scene, mesh)?;
    let rays = Rays::new(mesh);
    let occluders = Occluders::rounded(mesh);
    let feet = feet(scene, mesh, &Occluders::new(scene, mesh), &rays);
    let clusters = Clusters::new(mesh, &tree);
    let world = World {
        mesh,
        tree: &tree,
        clusters: &clusters,
        rays: &rays,
        occluders: &occluders,
        arch: Arch::new(),
    };
    let shafts = OnCpu { world, rays: false };
    let rays = OnCpu { world, rays: true };
    let other = match way {
        Way::By(maker) => Some(maker(&world)?),
        _ => None,
    };
    let light = other.as_deref().unwrap_or(match way {
        Way::Rays => &rays,
        _ => &shafts,
    });
    let finders = Finders {
        light,
        taken: &shafts,
    };
    task(Solve::new(world, finders, off, &feet))
}

/// Who finds what.
struct Finders<'a> {
    light: &'a dyn Finder,
    /// What objects take is asked of few, and shafts say of whom.
    taken: &'a dyn Finder,
}

/// The open share of each texel of `mesh`.
pub fn open(scene: &Scene, mesh: &Mesh) -> Vec<f32> {
    let rays = Rays::new(mesh);
    let mut open = vec![1.0; mesh.texels.len()];
    for (k, element) in feet(scene, mesh, &Occluders::new(scene, mesh), &rays) {
        open[k as usize] = element.open as f32;
    }
    open
}

pub(super) struct Solve<'a> {
    pub(super) world: World<'a>,
    finders: Finders<'a>,
    /// ρ of each face.
    pub(super) albedo: Vec<Vec3>,
    /// H of each texel's open part which is there whatever is solved; none: nothing.
    pub(super) known: Vec<Vec3>,
    /// 1/RMS of the reflected light.
    pub(super) scale: Vec3,
    /// Open share and open area of each texel.
    pub(super) open: Vec<f32>,
    pub(super) area: Vec<f32>,
    pub(super) coarse: Coarse,
    pub(super) feet: Feet,
    pub(super) links: u64,
    pub(super) passes: u32,
}

/// Of each texel: what has arrived, and what is not shot yet.
pub(super) struct Spent {
    pub(super) received: Vec<Vec3>,
    pub(super) unshot: Vec<Vec3>,
    pub(super) done: bool,
}

impl<'a> Solve<'a> {
    fn new(world: World<'a>, finders: Finders<'a>, off: &[f32], feet: &[(u32, Element)]) -> Self {
        let mesh = world.mesh;
        let mut open = vec![1.0; mesh.texels.len()];
        for (k, element) in feet {
            open[*k as usize] = element.open as f32;
        }
        let area: Vec<f32> = mesh
            .texels
            .iter()
            .zip(&open)
            .map(|(t, o)| t.area * o)
            .collect();
        let whole = |k: u32| {
            let radius = world.tree.nodes[k as usize].shooter.radius;
            let even = || {
                let leaves = world.tree.leaves(k);
                let off = |leaf: &Leaf| off.get(leaf.texel as usize).copied().unwrap_or(0.0);
                let squares: f32 = leaves.iter().map(|leaf| off(leaf).powi(2)).sum();
                squares <= ROUGH * ROUGH * leaves.len() as f32
            };
            radius <= COARSE && (radius <= FINE || even())
        };
        Self {
            coarse: Coarse::new(mesh, world.tree, world.clusters, whole, &area),
            feet: Feet::new(world.tree, feet),
            albedo: {
                let roots = world.tree.roots.iter();
                roots.map(|k| world.tree.reflectance(mesh, *k)).collect()
            },
            known: Vec::new(),
            world,
            finders,
            scale: Vec3::ONE,
            open,
            area,
            links: 0,
            passes: 0,
        }
    }

    pub(super) fn glow(&self, value: &[Vec3]) -> Vec<Glow> {
        let mut glows = pull(self.world.tree, &self.area, value);
        self.world.clusters.pull(self.world.tree, &mut glows);
        glows
    }

    /// `what` of `glow` at each texel that is `receiving`, the mean over its area.
    pub(super) fn at_texels(
        &self,
        what: What,
        glow: &[Glow],
        receiving: &Receiving,
        thresholds: Thresholds,
        part: Range<f64>,
        watch: Watch,
    ) -> Result<Vec<Vec3>> {
        let scale = |face: u32| self.scale * reflectance(&self.albedo, face);
        let mut descent = Descent::new(
            self.world.tree,
            &self.feet,
            &scale,
            thresholds.source,
            receiving,
            self.area.len(),
        );
        let mut part = part;
        while let Some(spots) = descent.spots() {
            let receivers = Receivers::new(self.world.mesh, &self.world.clusters.order, |f| {
                spots[f].clone()
            });
            // Nobody knows how far down it goes.
            let half = (part.start + part.end) / 2.0;
            let lit = self.gathered(what, glow, thresholds, &receivers, part.start..half, watch)?;
            descent.take(&receivers.blocks, &lit);
            part.start = half;
        }
        Ok(descent.texels())
    }

    /// `what` of `glow` at each block's lanes.
    pub(super) fn gathered(
        &self,
        what: What,
        glow: &[Glow],
        thresholds: Thresholds,
        receivers: &Receivers,
        part: Range<f64>,
        watch: Watch,
    ) -> Result<Vec<Lit>> {
        let (scale, albedo) = (self.scale, &self.albedo);
        let question = Question {
            what,
            glow,
            thresholds,
            receivers,
            scale: &|face| scale * reflectance(albedo, face),
            part,
        };
        let finder = match what {
            What::Light => self.finders.light,
            What::Taken(_) => self.finders.taken,
        };
        finder.gathered(&question, watch)
    }

    /// The links by which coarse nodes receive `glow`.
    pub(super) fn kept(
        &mut self,
        glow: &[Glow],
        thresholds: Thresholds,
        watch: Watch,
    ) -> Result<Vec<Vec<Kept>>> {
        let (scale, albedo) = (self.scale, &self.albedo);
        let question = Question {
            what: What::Light,
            glow,
            thresholds,
            receivers: &self.coarse.receivers,
            scale: &|face| scale * reflectance(albedo, face),
            part: LINKS,
        };
        let kept = self.finders.light.kept(&question, watch)?;
        self.coarse.serve(&kept);
        let ones = self.glow(&vec![Vec3::ONE; self.area.len()]);
        self.coarse.close(&exchange(&kept, &ones));
        self.links += kept.iter().map(|links| links.len() as u64).sum::<u64>();
        Ok(kept)
    }

    /// Light sent over the kept links until it is spent: x = K(source + ρx).
    pub(super) fn spend(
        &mut self,
        kept: &[Vec<Kept>],
        source: &[Vec3],
        spent: f64,
        watch: Watch,
    ) -> Result<Spent> {
        let tree = self.world.tree;
        let glow = self.glow(source);
        let mut bounces = Bounces {
            tree,
            clusters: self.world.clusters,
            coarse: &mut self.coarse,
            kept,
            glow,
            passes: 0,
        };
        let mut go_on = || match watch(SPENDING) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Interrupted),
        };
        let over = bounces.spend(spent, &mut go_on)?;
        self.passes += bounces.passes;
        let texels = source.len();
        Ok(Spent {
            received: self.coarse.spread(tree, &over.received, texels),
            unshot: self.coarse.spread(tree, &over.unshot, texels),
            done: over.done,
        })
    }

    /// ρH.
    pub(super) fn reflected(&self, received: &[Vec3]) -> Vec<Vec3> {
        let texels = self.world.mesh.texels.iter();
        received
            .iter()
            .zip(texels)
            .map(|(h, t)| *h * t.reflectance)
            .collect()
    }

    /// The mean over open parts, from that over all.
    pub(super) fn of_open(&self, received: &[Vec3]) -> Vec<Vec3> {
        let share = |(h, open): (&Vec3, &f32)| if *open > 0.0 { *h / *open } else { Vec3::ZERO };
        received.iter().zip(&self.open).map(share).collect()
    }

    /// The mean over all open area.
    pub(super) fn mean(&self, value: &[Vec3]) -> DVec3 {
        let (mut sum, mut area) = (DVec3::ZERO, 0.0);
        for (v, a) in value.iter().zip(&self.area) {
            sum += v.as_dvec3() * f64::from(*a);
            area += f64::from(*a);
        }
        sum / area.max(f64::MIN_POSITIVE)
    }

    /// 1/RMS of what `light`, with what is known, makes texels reflect; 0 where nothing is.
    pub(super) fn inverse_rms(&self, light: &[Vec3]) -> Vec3 {
        let texels = self.world.mesh.texels.iter();
        let square = |(k, texel): (usize, &Texel)| {
            let known = self.known.get(k).copied().unwrap_or_default();
            ((light[k] + known) * texel.reflectance.max(Vec3::splat(DARKEST))).powf(2.0)
        };
        let squares = texels.enumerate().map(square);
        let rms = self.mean(&squares.collect::<Vec<_>>()).map(f64::sqrt);
        rms.map(|rms| if rms > 0.0 { 1.0 / rms } else { 0.0 })
            .as_vec3()
    }
}

/// ρ of a face, as far as thresholds go.
fn reflectance(albedo: &[Vec3], face: u32) -> Vec3 {
    albedo[face as usize].max(Vec3::splat(DARKEST))
}
