//! The loop over whole cells: few passes instead of many shots.
//!
//! ```text
//! r ← r − α(d − ρ T d/A)    S ← S + α d    T_ci = Σ_{j∈c} w_ji A_j
//! ```
//! A shot is a cell's mean residual, so what cells give each other (T) is all that the choice of
//! shooters needs. A pass shoots d from many cells at once, chosen by [`iteration`]; the texels
//! take all shots together at the end: H = Σ w S. The links and the sums are those of
//! [`crate::shooting`], which shoots one cell after the other to every texel.

pub mod iteration;

use crate::error::Result;
use crate::mesh::{Cell, Mesh};
use crate::settings::{Iteration, Schedule};
use crate::shooting::{self, Field, Restart, Run, Shot};
use glam::{DVec3, Vec3};
use iteration::State;
use std::ops::ControlFlow;

/// The share of a cell's light that texels took, and that left.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Closure {
    /// ΣF.
    pub form_factor_sum: f32,
    /// The share of its cosine hemisphere that meets no front.
    pub escaped: f32,
}

impl Closure {
    /// What the cell's links are multiplied by: 1, or what brings ΣF to 1 − escaped.
    pub fn scale(&self, conserve: bool) -> f32 {
        if conserve && self.form_factor_sum > 0.0 {
            (1.0 - self.escaped) / self.form_factor_sum
        } else {
            1.0
        }
    }
}

/// What can shoot from many cells at once.
pub trait Exchange {
    /// Whether there is room for what all cells give each other.
    fn has_room(&self) -> bool;

    /// Whether each cell's links are scaled to its closure.
    fn conserves(&self) -> bool;

    /// Makes the links of `cells`, those that are not kept, and what they bring to each cell;
    /// `watch` is told how many are made. What was made when it breaks: one closure each, for the
    /// first of them.
    fn link(
        &mut self,
        cells: &[u32],
        watch: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<Closure>>;

    /// The flux that each cell receives when every linked cell i shoots `radiosity[i]`; W in the
    /// mesh's unit.
    fn exchange(&mut self, radiosity: &[Vec3]) -> Result<Vec<Vec3>>;

    /// The field after each cell i has shot `shot[i]` in all and has `unshot[i]` left:
    /// H = Σ w_ji shot_i, B = E + ρH.
    fn gather(&mut self, shot: &[Vec3], unshot: &[Vec3]) -> Result<Field>;
}

/// What can do both.
pub trait Engine: Restart + Exchange {}

impl<T: Restart + Exchange> Engine for T {}

/// Told the share done, 0…1, after every link and every pass; may break.
pub type Watch<'a> = &'a mut dyn FnMut(f64) -> ControlFlow<()>;

/// Solves by the iteration that the schedule asks for; by single shots where the engine cannot hold
/// what cells exchange.
pub fn solve(
    engine: &mut dyn Engine,
    mesh: &Mesh,
    schedule: &Schedule,
    watch: Watch,
) -> Result<Run> {
    if schedule.iteration == Iteration::Southwell || !engine.has_room() {
        return shooting::solve(engine, &schedule.one_by_one(), &mut |shot, emitted| {
            watch(shooting::progress(shot, emitted, schedule.epsilon))
        });
    }
    let mut solve = Passes::new(engine, mesh, schedule);
    solve.run(watch)?;
    let mut field = solve.field()?;
    if solve.varies() {
        for _ in 0..ROUNDS {
            let before = solve.passes;
            solve.correct(&mut field);
            solve.run(watch)?;
            if solve.passes == before {
                break;
            }
            field = solve.field()?;
            if solve.stagnated {
                break;
            }
        }
        solve.correct(&mut field);
    }
    solve.finish(field)
}

/// Where ρ varies within cells, the texels tell so often what cells have left.
const ROUNDS: u32 = 8;

/// Passes of conjugate gradients without [`GAIN`] after which no more will bring any: links too far
/// from reciprocal, or rounding, give back what a pass takes. What is unshot may rise before it
/// falls where walls are white: of solves that converge the slowest, 145 passes at ρ = 0.99, goes
/// on for 22 passes without; those that do not, for more than a thousand. Other iterations are
/// slower than that where walls are white, and healthy.
const FUTILE: u32 = 64;
/// What is unshot has fallen if it is below this share of the least before.
const GAIN: f64 = 0.99;

/// The state after the best pass, and what has come of the search for a better one.
struct Best {
    unshot: f64,
    residual: Vec<DVec3>,
    shot: Vec<DVec3>,
    /// What was unshot when it last fell, and the passes since.
    mark: f64,
    futile: u32,
}

impl Best {
    fn new(state: &State) -> Self {
        Self {
            // Anything is better than nothing shot.
            unshot: f64::INFINITY,
            residual: Vec::new(),
            shot: Vec::new(),
            mark: state.unshot(),
            futile: 0,
        }
    }

    fn note(&mut self, state: &State) {
        let unshot = state.unshot();
        if unshot < self.unshot {
            self.unshot = unshot;
            self.residual.clone_from(&state.residual);
            self.shot.clone_from(&state.shot);
        }
        self.futile += 1;
        if unshot < GAIN * self.mark {
            (self.mark, self.futile) = (unshot, 0);
        }
    }

    fn restore(self, state: &mut State) {
        (state.residual, state.shot) = (self.residual, self.shot);
    }
}

struct Passes<'a> {
    engine: &'a mut dyn Exchange,
    mesh: &'a Mesh,
    schedule: &'a Schedule,
    state: State,
    /// What the links of a cell are known to sum to; none where they have not been made.
    closures: Vec<Option<Closure>>,
    emitted: f64,
    stagnated: bool,
    passes: u32,
    shooters: u64,
    /// Whether someone had it end.
    stopped: bool,
}

impl<'a> Passes<'a> {
    fn new(engine: &'a mut dyn Exchange, mesh: &'a Mesh, schedule: &'a Schedule) -> Self {
        let state = State::new(mesh);
        Self {
            engine,
            mesh,
            schedule,
            emitted: state.unshot(),
            state,
            closures: vec![None; mesh.cells.len()],
            stagnated: false,
            passes: 0,
            shooters: 0,
            stopped: false,
        }
    }

    fn threshold(&self) -> f64 {
        self.emitted * self.schedule.epsilon
    }

    fn run(&mut self, watch: Watch) -> Result<()> {
        let most = u64::from(self.schedule.max_shots);
        let mut best = Best::new(&self.state);
        while !self.stopped && self.state.unshot() > self.threshold() && self.shooters < most {
            let mut direction = self.direction(most - self.shooters);
            let ended = self.link(&mut direction, watch)?.is_break();
            let shooters = direction.iter().filter(|d| **d != DVec3::ZERO).count();
            if shooters == 0 {
                break;
            }
            self.exchange(&direction)?;
            self.shooters += shooters as u64;
            self.passes += 1;
            best.note(&self.state);
            self.stagnated = self.schedule.iteration == Iteration::Cg && best.futile >= FUTILE;
            if self.stagnated {
                best.restore(&mut self.state);
                break;
            }
            self.stopped = ended || watch(self.done()).is_break();
        }
        Ok(())
    }

    /// Whether the texels of some cell reflect unlike.
    fn varies(&self) -> bool {
        let texels = &self.mesh.texels;
        self.mesh.cells.iter().any(|cell| {
            let own = &texels[cell.texels()];
            own.iter().any(|t| t.reflectance != own[0].reflectance)
        })
    }

    /// What cells have left as their texels tell it: the mean of ρH is not that of ρ times that of H.
    fn correct(&mut self, field: &mut Field) {
        let mean = |cell: &Cell| {
            let (mut sum, mut area) = (DVec3::ZERO, 0.0);
            for k in cell.texels() {
                let texel = &self.mesh.texels[k];
                let reflected = texel.reflectance * field.irradiance[k].truncate();
                let own = f64::from(texel.area);
                sum += own * (texel.emission * cell.open + reflected).as_dvec3();
                area += own;
            }
            if area > 0.0 { sum / area } else { DVec3::ZERO }
        };
        let light: Vec<DVec3> = self.mesh.cells.iter().map(mean).collect();
        self.state.start_again(light);
        for (cell, left) in self.mesh.cells.iter().zip(&self.state.residual) {
            field.residual[cell.texels()].fill(left.as_vec3().extend(0.0));
        }
    }

    /// Of cells without links only those shoot that the threshold cannot do without.
    fn direction(&mut self, most: u64) -> Vec<DVec3> {
        let share = 0.5 * self.threshold() / self.mesh.cells.len() as f64;
        let taking_part: Vec<bool> = (0..self.mesh.cells.len())
            .map(|k| self.closures[k].is_some() || self.state.power(k) > share)
            .collect();
        let mut direction = self.state.direction(self.schedule.iteration, &taking_part);
        iteration::strongest(&mut direction, &self.state.areas, most);
        direction
    }

    /// Makes the links that are missing; a cell whose links are not made when `watch` breaks does
    /// not shoot.
    fn link(&mut self, direction: &mut [DVec3], watch: Watch) -> Result<ControlFlow<()>> {
        let missing: Vec<u32> = (0..direction.len())
            .filter(|k| direction[*k] != DVec3::ZERO && self.closures[*k].is_none())
            .map(|k| k as u32)
            .collect();
        if missing.is_empty() {
            return Ok(ControlFlow::Continue(()));
        }
        let all = direction.len() as f64;
        let known = self.closures.iter().flatten().count();
        let mut flow = ControlFlow::Continue(());
        let closures = self.engine.link(&missing, &mut |made| {
            // A break lasts: engines may have more under way.
            if flow.is_continue() {
                flow = watch((known + made) as f64 / all);
            }
            flow
        })?;
        for (cell, closure) in missing.iter().zip(&closures) {
            self.closures[*cell as usize] = Some(*closure);
        }
        for cell in missing.iter().skip(closures.len()) {
            direction[*cell as usize] = DVec3::ZERO;
        }
        Ok(flow)
    }

    fn exchange(&mut self, direction: &[DVec3]) -> Result<()> {
        let radiosity = self.scaled(direction);
        let received = self.engine.exchange(&radiosity)?;
        self.state
            .shoot(self.schedule.iteration, direction, &received);
        Ok(())
    }

    /// What the links carry of `radiosity`.
    fn scaled(&self, radiosity: &[DVec3]) -> Vec<Vec3> {
        let scale = |k: usize| {
            self.closures[k].map_or(0.0, |closure| closure.scale(self.engine.conserves()))
        };
        (0..radiosity.len())
            .map(|k| radiosity[k].as_vec3() * scale(k))
            .collect()
    }

    fn done(&self) -> f64 {
        let linked = self.closures.iter().flatten().count() as f64 / self.closures.len() as f64;
        let fallen = (self.emitted / self.state.unshot()).ln() / (1.0 / self.schedule.epsilon).ln();
        linked.max(fallen).clamp(0.0, 1.0)
    }

    /// What the texels have of all that was shot.
    fn field(&mut self) -> Result<Field> {
        let unshot: Vec<Vec3> = self.state.residual.iter().map(|r| r.as_vec3()).collect();
        let shot = self.scaled(&self.state.shot);
        self.engine.gather(&shot, &unshot)
    }

    fn finish(self, field: Field) -> Result<Run> {
        let left = self.state.unshot();
        Ok(Run {
            shots: self.shots(left as f32),
            emitted: self.emitted as f32,
            converged: left <= self.threshold(),
            stagnated: self.stagnated,
            passes: self.passes,
            shooters: self.shooters,
            field,
        })
    }

    /// All that each cell has shot, as one shot.
    fn shots(&self, unshot: f32) -> Vec<Shot> {
        let conserve = self.engine.conserves();
        (0..self.closures.len())
            .filter_map(|k| Some((k, self.closures[k]?)))
            .map(|(k, closure)| Shot {
                cell: k as u32,
                power: (self.state.shot[k] * self.state.areas[k]).as_vec3().into(),
                form_factor_sum: closure.form_factor_sum * closure.scale(conserve),
                escaped: closure.escaped,
                unshot,
            })
            .collect()
    }
}
