//! The shooting loop of progressive radiosity: select → visibility → form factor → deposit (Cohen 1988; the
//! paper's Table 1 with two corrections: the loop chooses its next shooter, and the shooter's residual is
//! reset inside the loop). docs/paper.md maps each line of the paper's tables to its function.

use crate::constants::SELECT_LANES;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::reduce::tree_sum;
use crate::settings::{Iteration, Schedule};
use glam::{Vec3, Vec4};
use std::ops::ControlFlow;

/// Record of one shot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// Index of the patch that shot.
    pub patch: u32,
    /// Flux shot per channel, W in the mesh's unit: mean residual × area.
    pub power: [f32; 3],
    /// ΣF: the share of the power that the texels received.
    pub form_factor_sum: f32,
    /// Share of the shooter's cosine-weighted hemisphere that meets no front.
    pub escaped: f32,
    /// Σ|r|A over texels and channels after the shot.
    pub unshot: f32,
}

/// Radiosity, residual and irradiance of every texel (W/m²; w of the irradiance is the form
/// factor of the latest shot, w of the others is unused), in the mesh's texel order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RadiosityField {
    /// Name of the engine that computed it: a comparison refuses two fields of one origin.
    pub origin: String,
    /// B.
    pub radiosity: Vec<Vec4>,
    /// r, the unshot part of B.
    pub residual: Vec<Vec4>,
    /// H, received so far.
    pub irradiance: Vec<Vec4>,
}

/// Order of the shooters.
#[derive(Clone, Copy, Debug)]
pub enum ShotOrder<'a> {
    /// Largest unshot power first, until no more than `threshold` is unshot.
    Greedy {
        /// Σ|r|A at which the solve has converged.
        threshold: f32,
    },
    /// The patches of an earlier run's log, in its order.
    Replay(&'a [u32]),
}

/// Rule by which texels of the room receive a shot after objects have been put into it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DepositRule {
    /// True if the shots carry the room's captured radiosity. Then texels only record irradiance: its
    /// change in `irradiance`, and the irradiance without the objects in `radiosity`.
    pub captured: bool,
    /// Part of a captured shot, or of an object's, that a texel of the room had already received.
    pub subtracted: SubtractedLink,
    /// True if texels of the room shoot the change of their radiosity.
    pub reshoot: bool,
}

impl DepositRule {
    /// Rule of a solve: a texel receives every shot that it sees, and reflects it.
    pub const FULL_DEPOSIT: Self = Self {
        captured: false,
        subtracted: SubtractedLink::Nothing,
        reshoot: true,
    };

    /// Returns whether links are compared with those without the objects.
    pub fn compares_links(self) -> bool {
        self.captured || self.subtracted != SubtractedLink::Nothing
    }

    /// Checks the rule against `conserve`.
    ///
    /// Errors: [`Error::Usage`] of links that are compared and scaled to their closure, which differs
    /// without the objects.
    pub fn check_conserve(self, conserve: bool) -> Result<Self> {
        if conserve && self.compares_links() {
            return Err(Error::Usage(
                "links with and without objects are compared, so they cannot be scaled".into(),
            ));
        }
        Ok(self)
    }
}

/// Part that is subtracted from a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SubtractedLink {
    /// Nothing.
    Nothing,
    /// The link without the objects.
    Before,
    /// The form factor without visibility (Table 2 as printed).
    Unhidden,
    /// The link itself: its change is 0.
    All,
}

/// An engine that shoots one patch at a time.
pub trait Shoot {
    /// Returns Σ|r|A over the texels and channels of each patch.
    fn patch_power(&mut self) -> Result<Vec<f32>>;

    /// Shoots the mean residual of `patch` to every texel that sees it.
    fn shoot(&mut self, patch: u32) -> Result<Shot>;

    /// Returns the texels' state.
    fn read_field(&mut self) -> Result<RadiosityField>;

    /// Shoots until the order ends, after `max_shots`, or until `watch` breaks. A solver that chooses its
    /// shooter itself overrides this function; the shots must be the same. A solver that works in batches
    /// completes those under way after a break, and passes their shots to `watch` too.
    fn run(&mut self, order: ShotOrder, max_shots: u32, watch: &mut dyn FnMut(&Shot) -> ControlFlow<()>) -> Result<()> {
        // Table 1: line 2, the missing choice of the shooter (Table 2, line 1), then lines 3 to 15 as a shot.
        if max_shots == 0 {
            return Ok(());
        }
        let mut next = select_first(self, order)?;
        for done in 1..=max_shots {
            let Some(patch) = next else { break };
            let shot = self.shoot(patch)?;
            if watch(&shot).is_break() || done == max_shots {
                break;
            }
            next = select_next(self, order, done)?;
        }
        Ok(())
    }
}

/// An engine that continues from any state by any rule, as relighting needs.
pub trait Restart: Shoot {
    /// Continues from `field` by `rule`, with the `reflectance` of every texel.
    fn restart_from(&mut self, rule: DepositRule, reflectance: &[Vec3], field: &RadiosityField) -> Result<()>;
}

/// Returns the first shooter of `order`; none if there is none.
pub fn select_first<E: Shoot + ?Sized>(engine: &mut E, order: ShotOrder) -> Result<Option<u32>> {
    choose_shooter(order, 0, || engine.patch_power())
}

/// Returns the shooter of `order` after `done` shots; none at its end.
pub fn select_next<E: Shoot + ?Sized>(engine: &mut E, order: ShotOrder, done: u32) -> Result<Option<u32>> {
    choose_shooter(order, done, || engine.patch_power())
}

/// Returns the shooter of `order` after `done` shots; a greedy order chooses by `power`, a replay by its log.
pub fn choose_shooter(order: ShotOrder, done: u32, power: impl FnOnce() -> Result<Vec<f32>>) -> Result<Option<u32>> {
    Ok(match order {
        ShotOrder::Greedy { threshold } => select_shooter(&power()?, threshold),
        ShotOrder::Replay(log) => log.get(done as usize).copied(),
    })
}

/// Returns the patch with the largest unshot power, the lowest of equals; none if Σ ≤ threshold.
pub fn select_shooter(power: &[f32], threshold: f32) -> Option<u32> {
    let (total, best) = reduce_power(power);
    if total <= threshold { None } else { Some(best) }
}

/// Returns Σ|r|A over all patches, and the patch with the largest, the lowest of equals.
pub fn reduce_power(power: &[f32]) -> (f32, u32) {
    let mut best = 0;
    for k in 1..power.len() {
        if power[k] > power[best] {
            best = k;
        }
    }
    (total_power(power), best as u32)
}

/// Returns Σ|r|A over all patches, summed in the GPU's order.
pub fn total_power(power: &[f32]) -> f32 {
    tree_sum::<f32, SELECT_LANES>(0.0, power.len(), |k| power[k])
}

/// Outcome of a finished or stopped solve.
#[derive(Clone, Debug, Default)]
pub struct SolveRun {
    /// The log of shots; after passes, one shot per patch with all that it has shot.
    pub shots: Vec<Shot>,
    /// Σ|r|A before the first shot.
    pub emitted: f32,
    /// True if unshot ≤ ε × emitted.
    pub converged: bool,
    /// True if the solve ended because its unshot power no longer fell.
    pub stagnated: bool,
    /// Passes over the patches; the number of shots if one patch shoots at a time.
    pub passes: u32,
    /// Number of shots: shooters, summed over the passes.
    pub shooters: u64,
    /// The texels at the end.
    pub field: RadiosityField,
}

impl SolveRun {
    /// Returns unshot over emitted power; 0 if nothing is emitted.
    pub fn unshot_fraction(&self) -> f64 {
        let unshot = self.shots.last().map_or(self.emitted, |shot| shot.unshot);
        if self.emitted > 0.0 {
            f64::from(unshot) / f64::from(self.emitted)
        } else {
            0.0
        }
    }

    /// Returns the shooters in order.
    pub fn shooter_log(&self) -> Vec<u32> {
        self.shots.iter().map(|shot| shot.patch).collect()
    }
}

/// Returns the progress of a solve, 0…1, on the scale of the logarithm of unshot power, which falls roughly
/// exponentially.
pub fn solve_progress(shot: &Shot, emitted: f32, epsilon: f64) -> f64 {
    let done = (f64::from(emitted) / f64::from(shot.unshot)).ln() / (1.0 / epsilon).ln();
    if done.is_finite() { done.clamp(0.0, 1.0) } else { 1.0 }
}

/// Shoots the largest unshot power first until the schedule is met; `watch` receives every shot and the
/// emitted power.
///
/// Errors: the engine's; [`Error::Usage`] of an iteration over many patches at once.
pub fn shoot_until_converged(
    engine: &mut dyn Shoot,
    schedule: &Schedule,
    watch: &mut dyn FnMut(&Shot, f32) -> ControlFlow<()>,
) -> Result<SolveRun> {
    let series = ShotSeries::until_converged(schedule, &engine.patch_power()?)?;
    shoot_series(engine, series, watch)
}

/// Checks that the schedule's iteration shoots one patch at a time.
pub(crate) fn require_southwell(schedule: &Schedule) -> Result<()> {
    match schedule.iteration {
        Iteration::Southwell => Ok(()),
        other => Err(Error::Usage(format!(
            "{other:?} shoots from many patches at once, and this solve shoots from one at a time"
        ))),
    }
}

/// Shoots the patches of `log`, in its order, on a fresh engine.
pub fn replay_log(engine: &mut dyn Shoot, log: &[u32]) -> Result<SolveRun> {
    let series = ShotSeries::of_log(log, &engine.patch_power()?);
    shoot_series(engine, series, &mut |_, _| ControlFlow::Continue(()))
}

fn shoot_series(
    engine: &mut dyn Shoot,
    mut series: ShotSeries,
    watch: &mut dyn FnMut(&Shot, f32) -> ControlFlow<()>,
) -> Result<SolveRun> {
    let (order, max_shots) = (series.order, series.max_shots);
    engine.run(order, max_shots, &mut |shot| series.record_shot(shot, watch))?;
    Ok(series.into_run(engine.read_field()?))
}

/// A solve under way: its order, and its shots so far. An engine that a caller has to await goes through it as a [`Shoot`]
/// does: unshot power, shots, field.
pub struct ShotSeries<'a> {
    /// Order of the shooters.
    pub order: ShotOrder<'a>,
    /// Most shots.
    pub max_shots: u32,
    emitted: f32,
    shots: Vec<Shot>,
}

impl<'a> ShotSeries<'a> {
    /// Returns the series that shoots the largest unshot power first until the schedule is met, from the unshot power of
    /// each patch.
    ///
    /// Errors: [`Error::Usage`] of an iteration over many patches at once.
    pub fn until_converged(schedule: &Schedule, power: &[f32]) -> Result<Self> {
        require_southwell(schedule)?;
        let emitted = total_power(power);
        let threshold = (f64::from(emitted) * schedule.epsilon) as f32;
        Ok(Self {
            order: ShotOrder::Greedy { threshold },
            max_shots: schedule.max_shots,
            emitted,
            shots: Vec::new(),
        })
    }

    /// Returns the series that shoots the patches of `log`.
    fn of_log(log: &'a [u32], power: &[f32]) -> Self {
        Self {
            order: ShotOrder::Replay(log),
            max_shots: log.len() as u32,
            emitted: total_power(power),
            shots: Vec::new(),
        }
    }

    /// Records a shot, and passes it to `watch` with the emitted power.
    pub fn record_shot(
        &mut self,
        shot: &Shot,
        watch: &mut dyn FnMut(&Shot, f32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.shots.push(*shot);
        watch(shot, self.emitted)
    }

    /// Returns the outcome, with the texels at the end.
    pub fn into_run(self, field: RadiosityField) -> SolveRun {
        let unshot = self.shots.last().map_or(self.emitted, |shot| shot.unshot);
        SolveRun {
            emitted: self.emitted,
            converged: matches!(self.order, ShotOrder::Greedy { threshold } if unshot <= threshold),
            stagnated: false,
            passes: self.shots.len() as u32,
            shooters: self.shots.len() as u64,
            shots: self.shots,
            field,
        }
    }
}

/// Returns the state before the first shot (Table 1, line 1): B = E, H = 0, and r = E times the open share. Light from
/// outside has arrived already: it is H, and its reflection B and r.
pub fn initial_field(mesh: &Mesh, origin: &str) -> RadiosityField {
    let emission: Vec<Vec4> = mesh.texels.iter().map(|t| t.emission.extend(0.0)).collect();
    let mut residual = emission.clone();
    for patch in mesh.patches.iter().filter(|patch| patch.open_share < 1.0) {
        for k in patch.texels() {
            residual[k] *= patch.open_share;
        }
    }
    let mut field = RadiosityField {
        origin: origin.to_owned(),
        irradiance: vec![Vec4::ZERO; emission.len()],
        radiosity: emission,
        residual,
    };
    for (k, texel) in mesh.texels.iter().enumerate().filter(|(_, t)| t.sky != Vec3::ZERO) {
        field.residual[k] += (texel.reflectance * texel.sky).extend(0.0);
    }
    add_sky(mesh, &mut field);
    field
}

/// Adds the light from outside to H, and its reflection to B.
pub fn add_sky(mesh: &Mesh, field: &mut RadiosityField) {
    for (k, texel) in mesh.texels.iter().enumerate().filter(|(_, t)| t.sky != Vec3::ZERO) {
        field.irradiance[k] += texel.sky.extend(0.0);
        field.radiosity[k] += (texel.reflectance * texel.sky).extend(0.0);
    }
}
