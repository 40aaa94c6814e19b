//! The one loop: select → visibility → form factor → deposit (Cohen 1988; the paper's Table 1 with
//! its two slips mended: the loop chooses its next shooter, and the shooter's residual is reset
//! inside it). docs/paper.md leads from each line of the paper's tables to its function.

use crate::constants::SELECT_LANES;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::reduce::tree_sum;
use crate::settings::{Iteration, Schedule};
use glam::{Vec3, Vec4};
use std::ops::ControlFlow;

/// What one shot did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// The shooter.
    pub cell: u32,
    /// Flux shot per channel, W in the mesh's unit: mean residual × area.
    pub power: [f32; 3],
    /// ΣF: the share of it that the texels took.
    pub form_factor_sum: f32,
    /// The share of the shooter's cosine hemisphere that meets no front.
    pub escaped: f32,
    /// Σ|r|A over texels and channels after the shot.
    pub unshot: f32,
}

/// Radiosity, residual and irradiance of every texel (W/m²; w of the irradiance is the form
/// factor of the latest shot, w of the others is unused), in the mesh's texel order.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Who computed it: a comparison refuses two fields of one origin.
    pub origin: String,
    /// B.
    pub radiosity: Vec<Vec4>,
    /// r, the unshot part of B.
    pub residual: Vec<Vec4>,
    /// H, received so far.
    pub irradiance: Vec<Vec4>,
}

/// Who shoots next.
#[derive(Clone, Copy, Debug)]
pub enum Order<'a> {
    /// Most unshot power first, until no more than `threshold` is unshot.
    Greedy {
        /// Σ|r|A at which the solve has converged.
        threshold: f32,
    },
    /// The cells of an earlier run's log, one after the other.
    Replay(&'a [u32]),
}

/// How texels of the room take a shot, when objects have been put into it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rule {
    /// Whether the shots carry the room's captured radiosity: then texels only note what they
    /// receive, the change in `irradiance` and what they had of it before the objects came in
    /// `radiosity`.
    pub captured: bool,
    /// What a texel of the room had already of a captured shot, or of an object's.
    pub subtracted: Subtracted,
    /// Whether texels of the room shoot on what they gain and lose.
    pub keep: bool,
}

impl Rule {
    /// A solve: whoever sees a shot takes it, and shoots it on.
    pub const PLAIN: Self = Self {
        captured: false,
        subtracted: Subtracted::Nothing,
        keep: true,
    };

    /// Whether links must be compared with what they were.
    pub fn compares(self) -> bool {
        self.captured || self.subtracted != Subtracted::Nothing
    }

    /// Refuses to compare links that are scaled to their closure: what they were had another.
    pub fn with(self, conserve: bool) -> Result<Self> {
        if conserve && self.compares() {
            return Err(Error::Usage(
                "links with and without objects are compared: they cannot be scaled".into(),
            ));
        }
        Ok(self)
    }
}

/// What is subtracted from a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subtracted {
    /// Nothing.
    Nothing,
    /// The link without the objects.
    Before,
    /// The form factor, whatever hides the texel (Table 2 as printed).
    Unhidden,
    /// The link itself: no change.
    All,
}

/// What shoots one cell after the other.
pub trait Shoot {
    /// Σ|r|A over the texels and channels of each cell.
    fn cell_power(&mut self) -> Result<Vec<f32>>;

    /// Shoots the mean residual of `cell` at every texel that sees it.
    fn shoot(&mut self, cell: u32) -> Result<Shot>;

    /// The texels' state.
    fn field(&mut self) -> Result<Field>;

    /// Shoots until the order ends, `max_shots` are shot or `watch` breaks. A solver that can
    /// choose its shooter by itself overrides this; the shots must be the same. One that works
    /// in batches finishes those under way after a break, and shows them to `watch` too.
    fn run(
        &mut self,
        order: Order,
        max_shots: u32,
        watch: &mut dyn FnMut(&Shot) -> ControlFlow<()>,
    ) -> Result<()> {
        // Table 1: line 2, the choice it leaves out (Table 2, line 1), then lines 3 to 15 as a shot.
        for k in 0..max_shots {
            let next = match order {
                Order::Greedy { threshold } => select(&self.cell_power()?, threshold),
                Order::Replay(log) => log.get(k as usize).copied(),
            };
            let Some(cell) = next else { break };
            let shot = self.shoot(cell)?;
            if watch(&shot).is_break() {
                break;
            }
        }
        Ok(())
    }
}

/// What can go on from any state, by any rule: relighting is made of that.
pub trait Restart: Shoot {
    /// Goes on from `field` by `rule`, with the `reflectance` of every texel.
    fn restart(&mut self, rule: Rule, reflectance: &[Vec3], field: &Field) -> Result<()>;
}

/// The cell with most unshot power, the lowest of equals; none when Σ ≤ threshold.
pub fn select(power: &[f32], threshold: f32) -> Option<u32> {
    if total(power) <= threshold {
        return None;
    }
    let mut best = 0;
    for k in 1..power.len() {
        if power[k] > power[best] {
            best = k;
        }
    }
    Some(best as u32)
}

/// Σ|r|A over all cells, added as the GPU adds it.
pub fn total(power: &[f32]) -> f32 {
    tree_sum::<f32, SELECT_LANES>(0.0, power.len(), |k| power[k])
}

/// A finished or stopped solve.
#[derive(Clone, Debug)]
pub struct Run {
    /// The log; of passes, all that each cell has shot as one shot.
    pub shots: Vec<Shot>,
    /// Σ|r|A before the first shot.
    pub emitted: f32,
    /// Whether unshot ≤ ε × emitted.
    pub converged: bool,
    /// Whether it was given up because what is unshot no longer fell.
    pub stagnated: bool,
    /// Passes over the cells; as many as shots where one shoots after the other.
    pub passes: u32,
    /// Shots: shooters, added over the passes.
    pub shooters: u64,
    /// The texels at the end.
    pub field: Field,
}

impl Run {
    /// Unshot over emitted power; 0 when nothing is emitted.
    pub fn unshot_fraction(&self) -> f64 {
        let unshot = self.shots.last().map_or(self.emitted, |shot| shot.unshot);
        if self.emitted > 0.0 {
            f64::from(unshot) / f64::from(self.emitted)
        } else {
            0.0
        }
    }

    /// The shooters, in order.
    pub fn cells(&self) -> Vec<u32> {
        self.shots.iter().map(|shot| shot.cell).collect()
    }
}

/// How far a solve has come, 0…1: unshot power falls roughly exponentially, so its logarithm is
/// the scale.
pub fn progress(shot: &Shot, emitted: f32, epsilon: f64) -> f64 {
    let done = (f64::from(emitted) / f64::from(shot.unshot)).ln() / (1.0 / epsilon).ln();
    if done.is_finite() {
        done.clamp(0.0, 1.0)
    } else {
        1.0
    }
}

/// Shoots greedily until the schedule is met; `watch` sees every shot and the emitted power.
///
/// Errors: the engine's; [`Error::Usage`] of an iteration over many cells at once.
pub fn solve(
    engine: &mut dyn Shoot,
    schedule: &Schedule,
    watch: &mut dyn FnMut(&Shot, f32) -> ControlFlow<()>,
) -> Result<Run> {
    one_by_one(schedule)?;
    let emitted = total(&engine.cell_power()?);
    let threshold = (f64::from(emitted) * schedule.epsilon) as f32;
    let mut shots = Vec::new();
    engine.run(
        Order::Greedy { threshold },
        schedule.max_shots,
        &mut |shot| {
            shots.push(*shot);
            watch(shot, emitted)
        },
    )?;
    let unshot = shots.last().map_or(emitted, |shot: &Shot| shot.unshot);
    Ok(Run {
        emitted,
        converged: unshot <= threshold,
        stagnated: false,
        passes: shots.len() as u32,
        shooters: shots.len() as u64,
        shots,
        field: engine.field()?,
    })
}

/// Who shoots one cell after the other knows no other iteration.
pub(crate) fn one_by_one(schedule: &Schedule) -> Result<()> {
    match schedule.iteration {
        Iteration::Southwell => Ok(()),
        other => Err(Error::Usage(format!(
            "{other:?} shoots from many cells at once, and here one shoots after the other"
        ))),
    }
}

/// Repeats the shooters of `log` on a fresh engine.
pub fn replay(engine: &mut dyn Shoot, log: &[u32]) -> Result<Run> {
    let emitted = total(&engine.cell_power()?);
    let mut shots = Vec::new();
    engine.run(Order::Replay(log), log.len() as u32, &mut |shot| {
        shots.push(*shot);
        ControlFlow::Continue(())
    })?;
    Ok(Run {
        emitted,
        converged: false,
        stagnated: false,
        passes: shots.len() as u32,
        shooters: shots.len() as u64,
        shots,
        field: engine.field()?,
    })
}

/// The state before the first shot (Table 1, line 1): B = E, H = 0, and r = E where no body buries it.
pub fn initial(mesh: &Mesh, origin: &str) -> Field {
    let emission: Vec<Vec4> = mesh.texels.iter().map(|t| t.emission.extend(0.0)).collect();
    let mut residual = emission.clone();
    for cell in mesh.cells.iter().filter(|cell| cell.open < 1.0) {
        for k in cell.texels() {
            residual[k] *= cell.open;
        }
    }
    Field {
        origin: origin.to_owned(),
        irradiance: vec![Vec4::ZERO; emission.len()],
        radiosity: emission,
        residual,
    }
}
