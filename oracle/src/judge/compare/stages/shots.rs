//! The stages of a shot by given links: select, deposit, power.

use super::{Bench, Tallies, one};
use crate::judge::compare::tally::ulps;
use common::Result;
use common::shooting::{Field, Rule, Shoot, Shot, select as choose, total};
use cpu::twin::deposit::{ShotInFlight, deposit};
use cpu::twin::link::Baseline;
use cpu::twin::power;
use glam::{Vec3, Vec4};
use gpu::GpuSolver;
use gpu::probe::Row;
use rayon::prelude::*;

/// The state of a solve between two shots.
pub struct State {
    field: Field,
    power: Vec<f32>,
}

impl State {
    /// As the GPU has it.
    pub fn of(solver: &mut GpuSolver) -> Result<Self> {
        Ok(Self {
            field: solver.field()?,
            power: solver.cell_power()?,
        })
    }
}

/// One shot of the solver's own choice, or of `cell`; none when nothing is left to shoot.
pub fn shoot(solver: &mut GpuSolver, cell: Option<u32>) -> Result<Option<Shot>> {
    Ok(one(solver, cell)?.filter(|shot| shot.power.iter().any(|p| *p != 0.0)))
}

/// The choice among the powers that the GPU had.
pub fn select(before: &State, shot: &Shot, tallies: &mut Tallies) {
    tallies
        .select
        .same(choose(&before.power, 0.0) == Some(shot.cell));
}

impl Bench<'_> {
    /// The flux of the shot, its deposit by the GPU's links, and the powers after it.
    pub fn shot(
        &self,
        before: &State,
        shot: &Shot,
        row: &Row,
        after: &State,
        tallies: &mut Tallies,
    ) {
        let mesh = self.mesh;
        let cell = &mesh.cells[shot.cell as usize];
        let flux = Vec3::from(shot.power);
        let sum = power::power(mesh, &before.field, cell);
        for k in 0..3 {
            tallies.power.add(ulps(flux[k], sum[k], sum.w));
        }
        for (cell, w) in mesh.cells.iter().zip(&after.power) {
            tallies
                .power
                .add(ulps(*w, power::power(mesh, &after.field, cell).w, 0.0));
        }
        tallies
            .unshot
            .add(ulps(shot.unshot, total(&after.power), 0.0));
        tallies
            .closure
            .add(ulps(shot.form_factor_sum, row.sum * row.scale, 0.0));
        let reflectance: Vec<Vec3> = mesh.texels.iter().map(|t| t.reflectance).collect();
        let in_flight = ShotInFlight {
            mesh,
            cell,
            radiosity: flux / cell.shooter.area,
            scale: row.scale,
            rule: Rule::PLAIN,
            reflectance: &reflectance,
        };
        let of = |k: usize| deposited(&in_flight, k, row.links[k], &before.field, &after.field);
        let errors: Vec<[f64; 3]> = (0..mesh.texels.len()).into_par_iter().map(of).collect();
        for error in errors.into_iter().flatten() {
            tallies.deposit.add(error);
        }
    }
}

/// What the twin makes of texel `k`, against what the GPU made, in ulp.
fn deposited(
    in_flight: &ShotInFlight,
    k: usize,
    w: f32,
    before: &Field,
    after: &Field,
) -> [f64; 3] {
    let (mut b, mut r, mut h) = (
        before.radiosity[k],
        before.residual[k],
        before.irradiance[k],
    );
    deposit(
        in_flight,
        k as u32,
        w,
        Baseline::default(),
        (&mut b, &mut r, &mut h),
    );
    [
        (b, after.radiosity[k]),
        (r, after.residual[k]),
        (h, after.irradiance[k]),
    ]
    .map(|(twin, gpu)| off(gpu, twin))
}

/// The worst channel's error in ulp of the largest channel.
pub fn off(a: Vec4, b: Vec4) -> f64 {
    let size = a.truncate().abs().max_element();
    let channels = (0..3).map(|c| ulps(a[c], b[c], size));
    channels.fold(
        0.0,
        |worst, x| if x > worst || x.is_nan() { x } else { worst },
    )
}
