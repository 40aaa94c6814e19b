//! The hierarchical solve, in four steps:
//!
//! ```text
//! direct    H_d = K E                  each lamp, at every texel
//! coarse    x = K_c ρ(H_d + x)         over kept links, until it is spent
//! fine      H_f = K ρ(H_d + x)         gathered anew at every texel
//! correct   δ = H_f − x;  y = K_c ρ(δ + y);  H = H_d + H_f + y, and again K ρ(δ + y) until y is little
//! ```

use crate::hierarchy::descent::Receiving;
use crate::hierarchy::find::Way;
use crate::hierarchy::light::Glow;
use crate::hierarchy::state::{Solve, prepared};
use crate::hierarchy::world::{Thresholds, Watch, What};
use crate::rows::lanes::Lane;
use common::Result;
use common::mesh::Mesh;
use common::scene::Scene;
use glam::{DVec3, Vec3};
use std::ops::Range;

/// Light is spent where so much of what was first sent is left.
const SPENT: f64 = 1e-4;
/// The same of the correction, which is a hundredth of the light.
pub(super) const CORRECTED: f64 = 1e-2;

/// What a solve may leave out, of the RMS of the reflected light.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    pub(super) direct: Thresholds,
    pub(super) coarse: Thresholds,
    pub(super) fine: Thresholds,
    pub(super) error: f32,
}

impl Goal {
    /// For that error, a share.
    pub fn of(error: f32) -> Self {
        let at = |source: f32, visibility: f32| Thresholds {
            source: source * error,
            visibility: visibility * error,
            near: NEAR * source * error,
            soft: 1.0,
        };
        Self {
            direct: at(0.3, 0.1),
            coarse: at(0.5, 0.5),
            fine: at(0.25, 0.1),
            error,
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
pub(super) const FINE: Range<f64> = 0.55..1.0;

/// Before anything is known.
const LOOSE: Thresholds = Thresholds {
    source: 2e-2,
    visibility: 2e-2,
    near: 2e-2,
    soft: 1.0,
};

/// What a solve came to.
pub struct Outcome {
    /// H of each texel, the mean over its area, W/m².
    pub irradiance: Vec<Vec3>,
    /// What is unshot of its radiosity, on its open part.
    pub residual: Vec<Vec3>,
    /// The open share of its area.
    pub open: Vec<f32>,
    /// How far the coarse light was off, of the RMS of the reflected light.
    pub off: Vec<f32>,
    /// Links from nodes to texels or coarse nodes, over all steps.
    pub links: u64,
    /// Bounces.
    pub passes: u32,
    /// Whether light was sent until it was spent.
    pub spent: bool,
}

/// Solves `scene` on the texels of `mesh`; `off` is how far coarse light was off at each of them, over what is
/// asked, where an earlier solve has found that; else it is empty.
///
/// Errors: a face of W×H texels; [`common::Error::Interrupted`].
pub fn solve(scene: &Scene, mesh: &Mesh, off: &[f32], goal: Goal, watch: Watch) -> Result<Outcome> {
    solve_by(scene, mesh, off, goal, Way::Shafts, watch)
}

/// The same with links that are found this `way`.
///
/// Errors: those of [`solve`]; of a device.
pub fn solve_by(
    scene: &Scene,
    mesh: &Mesh,
    off: &[f32],
    goal: Goal,
    way: Way,
    watch: Watch,
) -> Result<Outcome> {
    let emission: Vec<Vec3> = mesh.texels.iter().map(|t| t.emission).collect();
    prepared(scene, mesh, off, way, |solve| {
        solve.run(&emission, goal, watch)
    })
}

impl Solve<'_> {
    /// All that comes of `emission`, on the texels' open parts.
    fn run(mut self, emission: &[Vec3], goal: Goal, watch: Watch) -> Result<Outcome> {
        let lamps = self.glow(emission);
        let all = Receiving::on(0..self.world.mesh.faces.len());
        let first = self.first_look(emission, &lamps, watch)?;
        let ambient = self.ambient(&self.reflected(&first));
        let light: Vec<Vec3> = first.iter().map(|h| *h + ambient).collect();
        self.scale = self.inverse_rms(&light);
        let direct = self.at_texels(What::Light, &lamps, &all, goal.direct, DIRECT, watch)?;
        let direct_open = self.of_open(&direct);
        let once = self.reflected(&direct_open);
        let outcome = self.bounced(&once, &direct_open, ambient, goal, watch)?;
        let whole = direct.iter().zip(&outcome.irradiance);
        Ok(Outcome {
            irradiance: whole.map(|(direct, later)| *direct + *later).collect(),
            ..outcome
        })
    }

    /// What arrives of a radiosity that is shot, `once`, and of all that it makes shine; `light` is there
    /// already, for the scale, and `ambient` what further bounces may add to it.
    pub(super) fn bounced(
        mut self,
        once: &[Vec3],
        light: &[Vec3],
        ambient: Vec3,
        goal: Goal,
        watch: Watch,
    ) -> Result<Outcome> {
        let even = self.reflected(&vec![ambient; once.len()]);
        let kept = self.kept(&self.glow(&sum(once, &even)), goal.coarse, watch)?;
        let coarse = self.spend(&kept, once, SPENT, watch)?;
        let shone = sum(once, &self.reflected(&coarse.received));
        self.scale = self.inverse_rms(&sum(light, &coarse.received));
        let corrected = self.corrected(&kept, shone, coarse, goal, watch)?;
        let left = corrected.unshot.iter().zip(&self.open);
        Ok(Outcome {
            irradiance: corrected.irradiance,
            residual: left.map(|(unshot, open)| *unshot * *open).collect(),
            off: corrected.off,
            open: self.open,
            links: self.links,
            passes: self.passes,
            spent: corrected.done,
        })
    }

    /// The irradiance that further bounces of a radiosity would come to if they spread evenly (the ambient
    /// term of Cohen et al. 1988).
    pub(super) fn ambient(&self, once: &[Vec3]) -> Vec3 {
        let texels = self.world.mesh.texels.iter();
        let grey = self.mean(&texels.map(|t| t.reflectance).collect::<Vec<_>>());
        (self.mean(once) / (DVec3::ONE - grey).max(DVec3::splat(1e-2))).as_vec3()
    }

    /// What arrives of `lamps`, roughly; from then on the scale is that of the light so found.
    pub(super) fn first_look(
        &mut self,
        emission: &[Vec3],
        lamps: &[Glow],
        watch: Watch,
    ) -> Result<Vec<Vec3>> {
        let even = self.mean(emission).as_vec3();
        self.scale = self.inverse_rms(&vec![even; emission.len()]);
        let all = &self.coarse.receivers;
        let sums = self.gathered(What::Light, lamps, LOOSE, all, GUESS, watch)?;
        let sums: Vec<[Lane; 3]> = sums.into_iter().map(|lit| lit.sums).collect();
        let direct = self.coarse.received(&sums);
        let direct = self.coarse.spread(self.world.tree, &direct, emission.len());
        self.scale = self.inverse_rms(&direct);
        Ok(direct)
    }
}

pub(super) fn sum(a: &[Vec3], b: &[Vec3]) -> Vec<Vec3> {
    a.iter().zip(b).map(|(a, b)| *a + *b).collect()
}
