//! Checks the stages of a shot on given links: select, deposit, power.

use super::{StageInputs, Tallies};
use crate::compare::statistics::ulp_distance;
use common::Result;
use common::shooting::{DepositRule, RadiosityField, Shoot, Shot, ShotOrder, select_shooter, total_power};
use cpu::shader_twins::deposit::{ShotInFlight, deposit};
use cpu::shader_twins::link::Baseline;
use cpu::shader_twins::select::load_shot;
use cpu::shader_twins::unshot_power;
use glam::{Vec3, Vec4};
use gpu::GpuSolver;
use gpu::probe::ProbedRow;
use rayon::prelude::*;
use std::ops::ControlFlow;

/// State of a solve between two shots.
pub struct ShotState {
    field: RadiosityField,
    power: Vec<f32>,
}

impl ShotState {
    /// Reads the state of the GPU.
    ///
    /// Errors: the device fails.
    pub fn read_from(solver: &mut GpuSolver) -> Result<Self> {
        Ok(Self {
            field: solver.read_field()?,
            power: solver.patch_power()?,
        })
    }
}

/// Runs one shot of the strongest patch or of `patch`; none if no power remains.
///
/// Errors: the device fails.
pub fn shoot_next(solver: &mut GpuSolver, patch: Option<u32>) -> Result<Option<Shot>> {
    let script = patch.map(|patch| [patch]);
    let order = match &script {
        None => ShotOrder::Greedy { threshold: 0.0 },
        Some(script) => ShotOrder::Replay(script),
    };
    let mut done = None;
    solver.run(order, 1, &mut |shot| {
        done = Some(*shot);
        ControlFlow::Continue(())
    })?;
    Ok(done.filter(|shot| shot.power.iter().any(|p| *p != 0.0)))
}

/// Checks the selection among the powers that the GPU had.
pub fn check_selection(before: &ShotState, shot: &Shot, tallies: &mut Tallies) {
    tallies
        .select
        .add_equality(select_shooter(&before.power, 0.0) == Some(shot.patch));
}

impl StageInputs<'_> {
    /// Checks the flux of the shot, its deposit by the GPU's links, and the powers after it.
    pub fn check_shot(
        &self,
        before: &ShotState,
        shot: &Shot,
        row: &ProbedRow,
        after: &ShotState,
        tallies: &mut Tallies,
    ) {
        let mesh = self.mesh;
        let patch = &mesh.patches[shot.patch as usize];
        let flux = Vec3::from(shot.power);
        let sum = unshot_power::unshot_power(mesh, &before.field, patch);
        for k in 0..3 {
            tallies.power.add(ulp_distance(flux[k], sum[k], sum.w));
        }
        for (patch, w) in mesh.patches.iter().zip(&after.power) {
            tallies.power.add(ulp_distance(
                *w,
                unshot_power::unshot_power(mesh, &after.field, patch).w,
                0.0,
            ));
        }
        tallies
            .unshot
            .add(ulp_distance(shot.unshot, total_power(&after.power), 0.0));
        tallies
            .closure
            .add(ulp_distance(shot.form_factor_sum, row.sum * row.scale, 0.0));
        let reflectance: Vec<Vec3> = mesh.texels.iter().map(|t| t.reflectance).collect();
        let rule = DepositRule::FULL_DEPOSIT;
        let in_flight = load_shot(mesh, shot.patch, flux, row.scale, rule, &reflectance);
        let of = |k: usize| deposit_errors(&in_flight, k, row.links[k], &before.field, &after.field);
        let errors: Vec<[f64; 3]> = (0..mesh.texels.len()).into_par_iter().map(of).collect();
        for error in errors.into_iter().flatten() {
            tallies.deposit.add(error);
        }
    }
}

/// Returns the errors of B, r and H of texel `k` against the twin, in ulp.
fn deposit_errors(
    in_flight: &ShotInFlight,
    k: usize,
    w: f32,
    before: &RadiosityField,
    after: &RadiosityField,
) -> [f64; 3] {
    let (mut b, mut r, mut h) = (before.radiosity[k], before.residual[k], before.irradiance[k]);
    deposit(in_flight, k as u32, w, Baseline::default(), (&mut b, &mut r, &mut h));
    [
        (b, after.radiosity[k]),
        (r, after.residual[k]),
        (h, after.irradiance[k]),
    ]
    .map(|(twin, gpu)| channel_error(gpu, twin))
}

/// Returns the worst channel's error in ulp of the largest channel.
pub fn channel_error(a: Vec4, b: Vec4) -> f64 {
    let size = a.truncate().abs().max_element();
    let channels = (0..3).map(|c| ulp_distance(a[c], b[c], size));
    channels.fold(0.0, |worst, x| if x > worst || x.is_nan() { x } else { worst })
}
