//! One method, timed as a user would wait for it, and judged.

use super::methods::Method;
use super::truth::Truth;
use super::{Figures, Measurement, Solver};
use crate::judge::diff::pair::Pair;
use crate::judge::diff::reflected::{Reflected, offsets};
use crate::judge::resample::{average, pieces};
use crate::plan::fits::{Limit, check};
use crate::solve::solved::Solved;
use crate::solve::solver::{self, Asked};
use crate::solve::task::Task;
use crate::solve::watch::Watch;
use common::energy::Energy;
use common::scene::Scene;
use common::texel::count;
use common::{Error, Result};
use glam::DVec3;
use gpu::Gpu;
use std::cell::Cell;
use std::ops::ControlFlow;
use std::time::Instant;

/// What is measured on, and by what.
pub struct Bench<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The GPU, where there is one.
    pub gpu: Option<&'a Gpu>,
    /// What the points are judged by.
    pub truth: &'a Truth,
    /// Texels a side that are asked for.
    pub texels: u32,
    /// A solve that takes longer (seconds) is given up.
    pub longest: f64,
}

/// How a solve was stopped.
#[derive(Clone, Copy, PartialEq)]
enum Stop {
    No,
    Late,
    Asked,
}

impl Bench<'_> {
    /// Solves once; none when `watch` broke. A failure is a measurement, too.
    pub fn measure(&self, method: &Method, watch: &Watch) -> Option<Measurement> {
        let start = Instant::now();
        let stop = Cell::new(Stop::No);
        let timed = |phase: &str, done: f64| {
            if watch.tell(phase, done).is_break() {
                stop.set(Stop::Asked);
            } else if stop.get() == Stop::No && start.elapsed().as_secs_f64() > self.longest {
                stop.set(Stop::Late);
            }
            if stop.get() == Stop::No {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        };
        let own = Watch::new(&timed);
        let solved = self.solve(method, &own);
        let seconds = start.elapsed().as_secs_f64();
        let result = match (stop.get(), solved) {
            (Stop::Asked, _) => return None,
            (Stop::Late, _) => Err(format!("took longer than {} s", self.longest)),
            (Stop::No, Ok(solved)) => self.judge(&solved),
            (Stop::No, Err(error)) => Err(error.to_string()),
        };
        let prepare = own.seconds(&["prepare"]);
        Some(Measurement {
            prepare,
            solve: seconds - prepare,
            result,
        })
    }

    fn solve(&self, method: &Method, watch: &Watch) -> Result<Solved> {
        let settings = &method.settings;
        let gpu = match method.solver {
            Solver::Gpu => Some(self.gpu.ok_or_else(|| Error::Device("no adapter".into()))?),
            Solver::Cpu | Solver::Matrix => None,
        };
        let texels = Some(self.texels);
        let solver = match (method.asked, method.solver) {
            (Some(error), _) => solver::Solver::to_error(gpu, Asked { error, texels }),
            (None, Solver::Matrix) => solver::Solver::Matrix,
            (None, _) => solver::Solver::on(gpu),
        };
        if solver.shoots() {
            check(self.scene, settings, solver.gpu(), Limit::of_this_machine())?;
        }
        let solved = self.scene.once(settings, solver, watch)?;
        if solved.one_by_one && method.sweep == "iteration" {
            return Err(Error::Usage(
                "this engine shoots one cell after the other: it would be the base again".into(),
            ));
        }
        Ok(solved)
    }

    /// The figures, or why there are none.
    fn judge(&self, solved: &Solved) -> std::result::Result<Figures, String> {
        let (mesh, run) = (&solved.mesh, &solved.run);
        let reflected = Reflected::of(self.scene, mesh, &run.field);
        if !reflected.values.iter().all(|v| v.is_finite()) {
            return Err("some texels are not finite numbers".into());
        }
        let truth = Reflected::from(&self.truth.stored);
        if truth.resolutions == reflected.resolutions && truth.values == reflected.values {
            return Err("is the truth itself, bit for bit: nothing is compared".into());
        }
        let lit = |values: &[DVec3]| values.iter().any(|v| *v != DVec3::ZERO);
        if lit(&truth.values) && !lit(&reflected.values) {
            return Err("reflects nothing at all".into());
        }
        if !run.converged {
            return Err(format!(
                "has not converged: {:.2} % unshot after {} shots",
                100.0 * run.unshot_fraction(),
                run.shooters
            ));
        }
        let pair = |a: &Reflected| Pair::new(a, &truth, None).map_err(|m| m.message);
        let (error, bias) = pair(&refined(&reflected, self.texels))?.worst();
        let (own_error, _) = pair(&reflected)?.worst();
        if !error.is_finite() {
            return Err("the truth is black in a channel in which it is not".into());
        }
        let mut linked = vec![false; mesh.cells.len()];
        for shot in &run.shots {
            linked[shot.cell as usize] = true;
        }
        Ok(Figures {
            error,
            own_error,
            bias,
            imbalance: Energy::new(mesh, &run.field, &run.shots).imbalance,
            unshot: run.unshot_fraction(),
            shots: run.shooters,
            passes: run.passes,
            linked: linked.iter().filter(|linked| **linked).count() as u64,
            one_by_one: solved.one_by_one,
        })
    }
}

/// The same on N×N texels at least: a coarse texel's value holds all over it.
fn refined<'a>(a: &Reflected<'a>, texels: u32) -> Reflected<'a> {
    let resolutions: Vec<[u32; 2]> = a
        .resolutions
        .iter()
        .map(|r| r.map(|side| if side < texels { texels } else { side }))
        .collect();
    let first = offsets(&a.resolutions);
    let mut values = Vec::with_capacity(resolutions.iter().map(|r| count(*r) as usize).sum());
    for (k, face) in a.scene.faces.iter().enumerate() {
        let own = &a.values[first[k]..first[k + 1]];
        if resolutions[k] == a.resolutions[k] {
            values.extend_from_slice(own);
        } else {
            let shared = pieces(face, a.resolutions[k], resolutions[k]);
            values.extend(average(own, &shared, resolutions[k]));
        }
    }
    Reflected {
        scene: a.scene,
        resolutions,
        values,
    }
}
