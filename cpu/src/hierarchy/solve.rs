//! The hierarchical solve, in four steps:
//!
//! ```text
//! direct    H_d = K E                  each lamp, at every texel
//! coarse    x = K_c ρ(H_d + x)         over kept links, until it is spent
//! fine      H_f = K ρ(H_d + x)         gathered anew at every texel
//! correct   δ = H_f − x;  y = K_c ρ(δ + y);  H = H_d + H_f + y
//! ```

use crate::hierarchy::block::{Block, Receivers};
use crate::hierarchy::coarse::{Coarse, Kept, exchange};
use crate::hierarchy::descent::{Descent, Feet, Lit};
use crate::hierarchy::gather::{Gather, Thresholds, World};
use crate::hierarchy::light::{Glow, pull};
use crate::hierarchy::tree::Tree;
use crate::matrix::open::{Element, feet};
use crate::occlusion::occluders::Occluders;
use crate::rows::lanes::Lane;
use crate::rows::receivers::LANES;
use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::Scene;
use common::{Error, Result};
use glam::{DVec3, Vec3};
use pulp::Arch;
use rayon::prelude::*;
use std::ops::{ControlFlow, Range};

/// Coarse receivers are no larger (the mesh is two units wide at most).
const COARSE: f32 = 0.09;
/// Bounces at most: what is left then is unshot.
const BOUNCES: usize = 1000;
/// Light is spent where so much of what was first sent is left.
const SPENT: f64 = 1e-4;
/// The same of the correction, which is a hundredth of the light.
const CORRECTED: f64 = 1e-2;
/// A face that reflects less counts as much as this one: its irradiance is asked for as well.
const DARKEST: f32 = 0.1;

/// What a solve may leave out, of the RMS of the reflected light.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    direct: Thresholds,
    coarse: Thresholds,
    fine: Thresholds,
}

impl Goal {
    /// For that error, a share.
    pub fn of(error: f32) -> Self {
        let at = |source: f32, visibility: f32| Thresholds {
            source: source * error,
            visibility: visibility * error,
            near: NEAR * source * error,
        };
        Self {
            direct: at(0.3, 0.1),
            coarse: at(0.5, 0.5),
            fine: at(0.25, 0.1),
        }
    }
}

/// What spots' centres leave out has the same sign at all nodes of a face beside them, and adds up.
const NEAR: f32 = 0.1;

/// How much of a solve each part takes, roughly.
const GUESS: Range<f64> = 0.0..0.05;
/// See [`GUESS`].
const DIRECT: Range<f64> = 0.05..0.2;
/// See [`GUESS`].
const LINKS: Range<f64> = 0.2..0.45;
/// See [`GUESS`].
const SPENDING: f64 = 0.5;
/// See [`GUESS`].
const FINE: Range<f64> = 0.55..1.0;
/// Tasks between two looks at whether to go on.
const TASKS: usize = 256;

/// Before anything is known.
const LOOSE: Thresholds = Thresholds {
    source: 2e-2,
    visibility: 2e-2,
    near: 2e-2,
};

/// Told how far the solve has come, 0…1; may break.
pub type Watch<'a> = &'a mut dyn FnMut(f64) -> ControlFlow<()>;

/// What a solve came to.
pub struct Outcome {
    /// H of each texel, the mean over its area, W/m².
    pub irradiance: Vec<Vec3>,
    /// What is unshot of its radiosity, on its open part.
    pub residual: Vec<Vec3>,
    /// The open share of its area.
    pub open: Vec<f32>,
    /// Links from nodes to texels or coarse nodes, over all steps.
    pub links: u64,
    /// Bounces.
    pub passes: u32,
}

/// Solves `scene` on the texels of `mesh`.
///
/// Errors: a face of W×H texels; [`Error::Interrupted`].
pub fn solve(scene: &Scene, mesh: &Mesh, goal: Goal, watch: Watch) -> Result<Outcome> {
    let tree = Tree::new(scene, mesh)?;
    let rays = Rays::new(mesh);
    let occluders = Occluders::rounded(mesh);
    let feet = feet(scene, mesh, &Occluders::new(scene, mesh), &rays);
    let world = World {
        mesh,
        tree: &tree,
        rays: &rays,
        occluders: &occluders,
        arch: Arch::new(),
    };
    Solve::new(world, &feet).run(goal, watch)
}

struct Solve<'a> {
    world: World<'a>,
    /// 1/RMS of the reflected light.
    scale: Vec3,
    /// Open share and open area of each texel.
    open: Vec<f32>,
    area: Vec<f32>,
    coarse: Coarse,
    feet: Feet,
    links: u64,
    passes: u32,
}

/// Light under way: what has arrived of it, and what is not shot yet.
struct Spent {
    received: Vec<Vec3>,
    unshot: Vec<Vec3>,
}

impl<'a> Solve<'a> {
    fn new(world: World<'a>, feet: &[(u32, Element)]) -> Self {
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
        Self {
            coarse: Coarse::new(mesh, world.tree, COARSE, &area),
            feet: Feet::new(world.tree, feet),
            world,
            scale: Vec3::ONE,
            open,
            area,
            links: 0,
            passes: 0,
        }
    }

    fn run(mut self, goal: Goal, watch: Watch) -> Result<Outcome> {
        let emission: Vec<Vec3> = self.world.mesh.texels.iter().map(|t| t.emission).collect();
        let lamps = self.glow(&emission);
        let guess = self.guess(&emission, &lamps, watch)?;
        let direct = self.at_texels(&lamps, goal.direct, DIRECT, watch)?;
        let direct_open = self.of_open(&direct);
        let once = self.reflected(&direct_open);
        let even = once.iter().zip(guess);
        let even: Vec<Vec3> = even.map(|(v, a)| *v + a).collect();
        let kept = self.kept(&self.glow(&even), goal.coarse, watch)?;
        let coarse = self.spend(&kept, &once, SPENT, watch)?;
        let light = sum(&direct_open, &coarse.received);
        let shone = self.reflected(&light);
        self.scale = self.inverse_rms(&light);
        let found = self.at_texels(&self.glow(&shone), goal.fine, FINE, watch)?;
        let new = self.of_open(&found);
        let delta: Vec<Vec3> = new
            .iter()
            .zip(&coarse.received)
            .map(|(f, x)| *f - *x)
            .collect();
        let corrected = self.spend(&kept, &self.reflected(&delta), CORRECTED, watch)?;
        let whole =
            (0..direct.len()).map(|k| direct[k] + found[k] + corrected.received[k] * self.open[k]);
        let left =
            (0..direct.len()).map(|k| (coarse.unshot[k] + corrected.unshot[k]) * self.open[k]);
        Ok(Outcome {
            irradiance: whole.collect(),
            residual: left.collect(),
            open: self.open,
            links: self.links,
            passes: self.passes,
        })
    }

    /// A first look at the direct light, for the scale; and what further bounces would add to each
    /// texel's radiosity if they spread evenly (the ambient term of Cohen et al. 1988).
    fn guess(&mut self, emission: &[Vec3], lamps: &[Glow], watch: Watch) -> Result<Vec<Vec3>> {
        let reflectance: Vec<Vec3> = self
            .world
            .mesh
            .texels
            .iter()
            .map(|t| t.reflectance)
            .collect();
        let grey = self.mean(&reflectance);
        let even = self.mean(emission).as_vec3();
        self.scale = self.inverse_rms(&vec![even; emission.len()]);
        let sums = self.gathered(lamps, LOOSE, &self.coarse.receivers, GUESS, watch)?;
        let sums: Vec<[Lane; 3]> = sums.into_iter().map(|lit| lit.sums).collect();
        let direct = self.coarse.received(&sums);
        let direct = self.coarse.spread(self.world.tree, &direct, emission.len());
        let bounced = self.mean(&self.reflected(&direct));
        let ambient = (bounced / (DVec3::ONE - grey).max(DVec3::splat(1e-2))).as_vec3();
        let light: Vec<Vec3> = direct.iter().map(|h| *h + ambient).collect();
        self.scale = self.inverse_rms(&light);
        Ok(reflectance.iter().map(|rho| ambient * *rho).collect())
    }

    fn glow(&self, value: &[Vec3]) -> Vec<Glow> {
        pull(self.world.tree, &self.area, value)
    }

    /// What arrives of `glow` at each texel, the mean over its area.
    fn at_texels(
        &self,
        glow: &[Glow],
        thresholds: Thresholds,
        part: Range<f64>,
        watch: Watch,
    ) -> Result<Vec<Vec3>> {
        let scale = |face: u32| self.scale * self.reflectance(face);
        let mut descent = Descent::new(
            self.world.tree,
            &self.feet,
            &scale,
            thresholds.source,
            self.area.len(),
        );
        let mut part = part;
        while let Some(spots) = descent.spots() {
            let receivers = Receivers::new(self.world.mesh, |f| spots[f].clone());
            // Nobody knows how far down it goes.
            let half = (part.start + part.end) / 2.0;
            let lit = self.gathered(glow, thresholds, &receivers, part.start..half, watch)?;
            descent.take(&receivers.blocks, &lit);
            part.start = half;
        }
        Ok(descent.texels())
    }

    /// What each block's lanes receive of `glow`.
    fn gathered(
        &self,
        glow: &[Glow],
        thresholds: Thresholds,
        receivers: &Receivers,
        part: Range<f64>,
        watch: Watch,
    ) -> Result<Vec<Lit>> {
        self.tasks(receivers, part, watch, |blocks| {
            let dark = Lit {
                sums: [[0.0; LANES]; 3],
                edge: false,
            };
            let mut lit = vec![dark; blocks.len()];
            self.gather(glow, thresholds, blocks).links(|made| {
                let own = &mut lit[made.block];
                made.link.add(&glow[made.node as usize], &mut own.sums);
                own.edge |= made.edge;
            });
            lit
        })
    }

    /// The links by which coarse nodes receive `glow`.
    fn kept(
        &mut self,
        glow: &[Glow],
        thresholds: Thresholds,
        watch: Watch,
    ) -> Result<Vec<Vec<Kept>>> {
        let kept = self.tasks(&self.coarse.receivers, LINKS, watch, |blocks| {
            let mut kept: Vec<Vec<Kept>> = blocks.iter().map(|_| Vec::new()).collect();
            self.gather(glow, thresholds, blocks).links(|made| {
                kept[made.block].push(Kept {
                    node: made.node,
                    link: made.link.clone(),
                });
            });
            kept
        })?;
        self.coarse.serve(&kept);
        self.links += kept.iter().map(|links| links.len() as u64).sum::<u64>();
        Ok(kept)
    }

    /// `task` of all blocks, in order; of the whole solve they are `part`.
    fn tasks<T: Send>(
        &self,
        receivers: &Receivers,
        part: Range<f64>,
        watch: Watch,
        task: impl Fn(&[Block]) -> Vec<T> + Sync,
    ) -> Result<Vec<T>> {
        let mut all = Vec::with_capacity(receivers.blocks.len());
        for some in receivers.tasks.chunks(TASKS) {
            let share = all.len() as f64 / receivers.blocks.len() as f64;
            if watch(part.start + share * (part.end - part.start)).is_break() {
                return Err(Error::Interrupted);
            }
            let parts = some
                .par_iter()
                .map(|blocks| task(&receivers.blocks[blocks.clone()]));
            all.extend(parts.collect::<Vec<_>>().into_iter().flatten());
        }
        Ok(all)
    }

    /// ρ of a face, as far as thresholds go.
    fn reflectance(&self, face: u32) -> Vec3 {
        self.albedo(face).max(Vec3::splat(DARKEST))
    }

    /// ρ of a face.
    fn albedo(&self, face: u32) -> Vec3 {
        let root = self.world.tree.roots[face as usize];
        let texel = self.world.tree.leaves(root)[0].texel as usize;
        self.world.mesh.texels[texel].reflectance
    }

    fn gather<'b>(
        &'b self,
        glow: &'b [Glow],
        thresholds: Thresholds,
        blocks: &'b [Block],
    ) -> Gather<'b> {
        let scale = self.scale * self.reflectance(blocks[0].face);
        Gather::new(&self.world, glow, scale, thresholds, blocks)
    }

    /// Light sent over the kept links until it is spent: x = K(source + ρx).
    fn spend(
        &mut self,
        kept: &[Vec<Kept>],
        source: &[Vec3],
        spent: f64,
        watch: Watch,
    ) -> Result<Spent> {
        let tree = self.world.tree;
        let mut glow = self.glow(source);
        let mut received = vec![Vec3::ZERO; self.coarse.count()];
        let mut unshot = received.clone();
        let (mut first, mut left, mut share) = (0.0, f64::INFINITY, 0.0);
        for bounce in 0..BOUNCES {
            // What is unshot counts with all its bounces: 1 + q + q² + …
            if left <= spent * first * (1.0 - share) {
                break;
            }
            if watch(SPENDING).is_break() {
                return Err(Error::Interrupted);
            }
            if bounce > 0 {
                self.coarse.glow(tree, &unshot, &mut glow);
            }
            let step = self.coarse.received(&exchange(kept, &glow));
            received = sum(&received, &step);
            unshot = self.coarse.times(tree, &step, |face| self.albedo(face));
            let next = self.coarse.power(&unshot);
            if bounce == 0 {
                first = next;
            } else if left > 0.0 {
                share = (next / left).min(0.99);
            }
            left = next;
            self.passes += 1;
        }
        let texels = source.len();
        Ok(Spent {
            received: self.coarse.spread(tree, &received, texels),
            unshot: self.coarse.spread(tree, &unshot, texels),
        })
    }

    /// ρH.
    fn reflected(&self, received: &[Vec3]) -> Vec<Vec3> {
        let texels = self.world.mesh.texels.iter();
        received
            .iter()
            .zip(texels)
            .map(|(h, t)| *h * t.reflectance)
            .collect()
    }

    /// The mean over open parts, from that over all.
    fn of_open(&self, received: &[Vec3]) -> Vec<Vec3> {
        let share = |(h, open): (&Vec3, &f32)| if *open > 0.0 { *h / *open } else { Vec3::ZERO };
        received.iter().zip(&self.open).map(share).collect()
    }

    /// The mean over all open area.
    fn mean(&self, value: &[Vec3]) -> DVec3 {
        let (mut sum, mut area) = (DVec3::ZERO, 0.0);
        for (v, a) in value.iter().zip(&self.area) {
            sum += v.as_dvec3() * f64::from(*a);
            area += f64::from(*a);
        }
        sum / area.max(f64::MIN_POSITIVE)
    }

    /// 1/RMS of what `light` makes texels reflect; 0 where nothing is.
    fn inverse_rms(&self, light: &[Vec3]) -> Vec3 {
        let texels = self.world.mesh.texels.iter();
        let square = |(h, rho): (&Vec3, Vec3)| (*h * rho.max(Vec3::splat(DARKEST))).powf(2.0);
        let squares = light.iter().zip(texels.map(|t| t.reflectance)).map(square);
        let rms = self.mean(&squares.collect::<Vec<_>>()).map(f64::sqrt);
        rms.map(|rms| if rms > 0.0 { 1.0 / rms } else { 0.0 })
            .as_vec3()
    }
}

fn sum(a: &[Vec3], b: &[Vec3]) -> Vec<Vec3> {
    a.iter().zip(b).map(|(a, b)| *a + *b).collect()
}
