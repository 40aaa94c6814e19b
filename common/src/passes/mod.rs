//! Iterations in which many patches shoot at once: few passes instead of many shots.
//!
//! ```text
//! r ← r − α(d − ρ T d/A)    S ← S + α d    T_ci = Σ_{j∈c} w_ji A_j
//! ```
//! r is the unshot radiosity of a patch, S what it has shot, A its area, ρ its reflectance, w_ji the link from patch i to
//! texel j, and α the step along d. A patch shoots its mean residual, so the choice of shooters needs only the transfer T between patches.
//! A pass shoots d, chosen by [`iteration`], from many patches at once; the texels receive all shots
//! together at the end: H = Σ w S. The links and the sums are those of [`crate::shooting`], in which one
//! patch at a time shoots to every texel.

pub mod iteration;

use crate::error::Result;
use crate::mesh::Mesh;
use crate::settings::{Iteration, Schedule};
use crate::shooting::{self, RadiosityField, Restart, Shoot, Shot, SolveRun};
use glam::{DVec3, Vec3};
use iteration::PassState;
use std::ops::ControlFlow;

/// Shares of a patch's light: received by texels, and escaped.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PatchClosure {
    /// ΣF.
    pub form_factor_sum: f32,
    /// Share of its cosine-weighted hemisphere that meets no front.
    pub escaped: f32,
}

impl PatchClosure {
    /// Returns the factor on the patch's links: 1, or the factor that brings ΣF to 1 − escaped.
    pub fn link_scale(&self, conserve: bool) -> f32 {
        if conserve && self.form_factor_sum > 0.0 {
            (1.0 - self.escaped) / self.form_factor_sum
        } else {
            1.0
        }
    }
}

/// An engine that shoots from many patches at once.
pub trait Exchange {
    /// Returns whether the transfer between all patches fits into memory.
    fn transfer_fits(&self) -> bool;

    /// Returns whether each patch's links are scaled to its closure.
    fn conserves_energy(&self) -> bool;

    /// Makes the missing links of `patches` and their transfer to each patch; `watch` receives the number
    /// of patches that are done. Returns one closure for each patch; after a break, for the first of them.
    fn make_links(
        &mut self,
        patches: &[u32],
        watch: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<PatchClosure>>;

    /// Returns the flux that each patch receives when every linked patch i shoots `radiosity[i]`; W in the
    /// mesh's unit.
    fn exchange_flux(&mut self, radiosity: &[Vec3]) -> Result<Vec<Vec3>>;

    /// Returns the field after each patch i has shot `shot[i]` in all and `unshot[i]` remains:
    /// H = Σ w_ji shot_i, B = E + ρH.
    fn gather_field(&mut self, shot: &[Vec3], unshot: &[Vec3]) -> Result<RadiosityField>;
}

/// An engine for both kinds of iteration.
pub trait Engine: Restart + Exchange {}

impl<T: Restart + Exchange> Engine for T {}

/// Callback that receives the progress, 0…1, after the links of each patch and after every pass; it may break.
pub type ProgressCallback<'a> = &'a mut dyn FnMut(f64) -> ControlFlow<()>;

/// Solves by the schedule's iteration; by single shots if the transfer between patches does not fit into
/// the engine's memory.
pub fn solve_by_schedule(
    engine: &mut dyn Engine,
    mesh: &Mesh,
    schedule: &Schedule,
    watch: ProgressCallback,
) -> Result<SolveRun> {
    if schedule.iteration == Iteration::Southwell || !engine.transfer_fits() {
        return solve_by_shots(engine, &schedule.with_southwell(), watch);
    }
    let mut solve = PassSolver::new(engine, mesh, schedule);
    solve.run(watch)?;
    let mut field = solve.texel_field()?;
    if solve.has_uneven_patches() {
        for _ in 0..MAX_TEXEL_CORRECTIONS {
            let before = solve.passes;
            solve.correct_from_texels(&mut field);
            solve.run(watch)?;
            if solve.passes == before {
                break;
            }
            field = solve.texel_field()?;
            if solve.stagnated {
                break;
            }
        }
        solve.correct_from_texels(&mut field);
    }
    Ok(solve.finish_run(field))
}

/// Solves by single shots, the patch with the most unshot power first.
///
/// Errors: those of [`shooting::shoot_until_converged`].
pub fn solve_by_shots(engine: &mut dyn Shoot, schedule: &Schedule, watch: ProgressCallback) -> Result<SolveRun> {
    shooting::shoot_until_converged(engine, schedule, &mut |shot, emitted| {
        watch(shooting::solve_progress(shot, emitted, schedule.epsilon))
    })
}

/// Maximum rounds in which the patches' residuals are recomputed from their texels, where ρ varies within patches, and
/// shot; one more recomputation follows.
const MAX_TEXEL_CORRECTIONS: u32 = 8;

/// Passes of conjugate gradients without a gain ([`GAIN_RATIO`]) after which the solve ends: links too far from
/// reciprocal, or rounding, restore the residual that a pass removes. Where walls are white the unshot power
/// may rise before it falls: the slowest solve that converges, 145 passes at ρ = 0.99, has 22 passes without
/// a gain; those that do not converge have more than a thousand. The other iterations converge more slowly
/// where walls are white, so the limit does not apply to them.
const MAX_PASSES_WITHOUT_GAIN: u32 = 64;
/// Share of the last recorded unshot power below which a pass is a gain.
const GAIN_RATIO: f64 = 0.99;

/// State after the best pass, and the passes since the last gain.
struct BestPass {
    unshot: f64,
    residual: Vec<DVec3>,
    shot: Vec<DVec3>,
    /// Unshot power at the last gain, and the passes since.
    gain_reference: f64,
    passes_without_gain: u32,
}

impl BestPass {
    fn new(state: &PassState) -> Self {
        Self {
            // The first pass is always better.
            unshot: f64::INFINITY,
            residual: Vec::new(),
            shot: Vec::new(),
            gain_reference: state.unshot_power(),
            passes_without_gain: 0,
        }
    }

    fn record_pass(&mut self, state: &PassState) {
        let unshot = state.unshot_power();
        if unshot < self.unshot {
            self.unshot = unshot;
            self.residual.clone_from(&state.residual);
            self.shot.clone_from(&state.shot);
        }
        self.passes_without_gain += 1;
        if unshot < GAIN_RATIO * self.gain_reference {
            (self.gain_reference, self.passes_without_gain) = (unshot, 0);
        }
    }
}

struct PassSolver<'a> {
    engine: &'a mut dyn Exchange,
    mesh: &'a Mesh,
    schedule: &'a Schedule,
    state: PassState,
    /// Sums of each patch's links; none where the links have not been made.
    closures: Vec<Option<PatchClosure>>,
    emitted: f64,
    stagnated: bool,
    passes: u32,
    shooters: u64,
    /// True if the callback ended the solve.
    stopped: bool,
}

impl<'a> PassSolver<'a> {
    fn new(engine: &'a mut dyn Exchange, mesh: &'a Mesh, schedule: &'a Schedule) -> Self {
        let state = PassState::new(mesh);
        Self {
            engine,
            mesh,
            schedule,
            emitted: state.unshot_power(),
            state,
            closures: vec![None; mesh.patches.len()],
            stagnated: false,
            passes: 0,
            shooters: 0,
            stopped: false,
        }
    }

    fn unshot_threshold(&self) -> f64 {
        self.emitted * self.schedule.epsilon
    }

    fn run(&mut self, watch: ProgressCallback) -> Result<()> {
        let max_shooters = u64::from(self.schedule.max_shots);
        let mut best = BestPass::new(&self.state);
        while !self.stopped && self.state.unshot_power() > self.unshot_threshold() && self.shooters < max_shooters {
            let mut direction = self.choose_direction(max_shooters - self.shooters);
            let ended = self.make_missing_links(&mut direction, watch)?.is_break();
            let shooters = direction.iter().filter(|d| **d != DVec3::ZERO).count();
            if shooters == 0 {
                break;
            }
            let radiosity = self.scale_by_links(&direction);
            let received = self.engine.exchange_flux(&radiosity)?;
            self.state.apply_pass(self.schedule.iteration, &direction, &received);
            self.shooters += shooters as u64;
            self.passes += 1;
            best.record_pass(&self.state);
            let is_cg = self.schedule.iteration == Iteration::Cg;
            self.stagnated = is_cg && best.passes_without_gain >= MAX_PASSES_WITHOUT_GAIN;
            if self.stagnated {
                (self.state.residual, self.state.shot) = (best.residual, best.shot);
                break;
            }
            self.stopped = ended || watch(self.share_done()).is_break();
        }
        Ok(())
    }

    /// Returns whether reflectance varies within a patch.
    fn has_uneven_patches(&self) -> bool {
        self.mesh.patches.iter().any(|patch| {
            let texels = &self.mesh.texels[patch.texels()];
            texels.iter().any(|t| t.reflectance != texels[0].reflectance)
        })
    }

    /// Recomputes the patches' residuals from their texels: the mean of ρH is not the product of the means.
    fn correct_from_texels(&mut self, field: &mut RadiosityField) {
        let texels = &self.mesh.texels;
        let light = iteration::patch_means(self.mesh, |patch, k| {
            let reflected = texels[k].reflectance * field.irradiance[k].truncate();
            texels[k].emission * patch.open_share + reflected
        });
        self.state.restart_from_light(light);
        for (patch, unshot) in self.mesh.patches.iter().zip(&self.state.residual) {
            field.residual[patch.texels()].fill(unshot.as_vec3().extend(0.0));
        }
    }

    /// Chooses the radiosity that each patch shoots, from `max_shooters` patches at most. Patches without
    /// links shoot only if their power exceeds an equal share of half the threshold.
    fn choose_direction(&mut self, max_shooters: u64) -> Vec<DVec3> {
        let share = 0.5 * self.unshot_threshold() / self.mesh.patches.len() as f64;
        let takes_part = |k: usize| self.closures[k].is_some() || self.state.patch_power(k) > share;
        let taking_part: Vec<bool> = (0..self.mesh.patches.len()).map(takes_part).collect();
        let mut direction = self.state.next_direction(self.schedule.iteration, &taking_part);
        iteration::keep_strongest(&mut direction, &self.state.areas, max_shooters);
        direction
    }

    /// Makes the links that are missing; a patch without links after a break does not shoot.
    fn make_missing_links(&mut self, direction: &mut [DVec3], watch: ProgressCallback) -> Result<ControlFlow<()>> {
        let is_missing = |k: &u32| direction[*k as usize] != DVec3::ZERO && self.closures[*k as usize].is_none();
        let missing: Vec<u32> = (0..direction.len() as u32).filter(is_missing).collect();
        if missing.is_empty() {
            return Ok(ControlFlow::Continue(()));
        }
        let (all, known) = (direction.len() as f64, self.closures.iter().flatten().count());
        let mut flow = ControlFlow::Continue(());
        let closures = self.engine.make_links(&missing, &mut |made| {
            // A break persists: engines may report patches that were under way.
            if flow.is_continue() {
                flow = watch((known + made) as f64 / all);
            }
            flow
        })?;
        for (patch, closure) in missing.iter().zip(&closures) {
            self.closures[*patch as usize] = Some(*closure);
        }
        for patch in missing.iter().skip(closures.len()) {
            direction[*patch as usize] = DVec3::ZERO;
        }
        Ok(flow)
    }

    /// Returns `radiosity` times the factor of each patch's links.
    fn scale_by_links(&self, radiosity: &[DVec3]) -> Vec<Vec3> {
        let conserve = self.engine.conserves_energy();
        let scales = self
            .closures
            .iter()
            .map(|c| c.map_or(0.0, |closure| closure.link_scale(conserve)));
        radiosity
            .iter()
            .zip(scales)
            .map(|(b, scale)| b.as_vec3() * scale)
            .collect()
    }

    fn share_done(&self) -> f64 {
        let linked = self.closures.iter().flatten().count() as f64 / self.closures.len() as f64;
        let fallen = (self.emitted / self.state.unshot_power()).ln() / (1.0 / self.schedule.epsilon).ln();
        linked.max(fallen).clamp(0.0, 1.0)
    }

    /// Returns the texels' field after all shots.
    fn texel_field(&mut self) -> Result<RadiosityField> {
        let unshot: Vec<Vec3> = self.state.residual.iter().map(|r| r.as_vec3()).collect();
        let shot = self.scale_by_links(&self.state.shot);
        let mut field = self.engine.gather_field(&shot, &unshot)?;
        shooting::add_sky(self.mesh, &mut field);
        Ok(field)
    }

    /// Returns the run, with one shot per patch for all that it has shot.
    fn finish_run(self, field: RadiosityField) -> SolveRun {
        let unshot = self.state.unshot_power();
        let conserve = self.engine.conserves_energy();
        let linked = self
            .closures
            .iter()
            .enumerate()
            .filter_map(|(k, closure)| Some((k, (*closure)?)));
        let shots = linked.map(|(k, closure)| Shot {
            patch: k as u32,
            power: (self.state.shot[k] * self.state.areas[k]).as_vec3().into(),
            form_factor_sum: closure.form_factor_sum * closure.link_scale(conserve),
            escaped: closure.escaped,
            unshot: unshot as f32,
        });
        SolveRun {
            shots: shots.collect(),
            emitted: self.emitted as f32,
            converged: unshot <= self.unshot_threshold(),
            stagnated: self.stagnated,
            passes: self.passes,
            shooters: self.shooters,
            field,
        }
    }
}
