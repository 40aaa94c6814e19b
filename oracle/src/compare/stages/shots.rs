//! Checks the stages of a shot on given links (select, deposit, power), and those of passes (exchange, collect).

use super::StageChecker;
use crate::compare::statistics::{ErrorTally, larger_or_nan, ulp_distance};
use common::Result;
use common::passes::Exchange;
use common::shooting::{DepositRule, RadiosityField, Shoot, Shot, total_power};
use cpu::shader_twins::deposit::deposit;
use cpu::shader_twins::gather::update_radiosity;
use cpu::shader_twins::link::Baseline;
use cpu::shader_twins::select::load_shot;
use cpu::shader_twins::unshot_power::unshot_power;
use glam::{Vec3, Vec4};
use gpu::GpuSolver;
use gpu::probe::ProbedRow;
use rayon::prelude::*;
use std::ops::ControlFlow;

/// State of a solve between two shots: the field, and the power of each patch.
type ShotState = (RadiosityField, Vec<f32>);

impl StageChecker<'_> {
    /// Checks the flux of the shot, its deposit by the GPU's links, and the powers after it.
    pub fn check_shot(&mut self, shot: &Shot, row: &ProbedRow, [before, after]: [&ShotState; 2]) {
        let (mesh, tallies) = (self.mesh, &mut self.tallies);
        let flux = Vec3::from(shot.power);
        let sum = unshot_power(mesh, &before.0, &mesh.patches[shot.patch as usize]);
        for k in 0..3 {
            tallies.power.add(ulp_distance(flux[k], sum[k], sum.w));
        }
        for (patch, w) in mesh.patches.iter().zip(&after.1) {
            let twin = unshot_power(mesh, &after.0, patch).w;
            tallies.power.add(ulp_distance(*w, twin, 0.0));
        }
        let unshot = ulp_distance(shot.unshot, total_power(&after.1), 0.0);
        tallies.unshot.add(unshot);
        let sum = ulp_distance(shot.form_factor_sum, row.sum * row.scale, 0.0);
        tallies.closure.add(sum);
        let reflectance: Vec<Vec3> = mesh.texels.iter().map(|t| t.reflectance).collect();
        let rule = DepositRule::FULL_DEPOSIT;
        let in_flight = load_shot(mesh, shot.patch, flux, row.scale, rule, &reflectance);
        let (before, after) = (&before.0, &after.0);
        let errors_of = |k: usize| {
            let (mut b, mut r, mut h) = (before.radiosity[k], before.residual[k], before.irradiance[k]);
            let link = row.links[k];
            deposit(
                &in_flight,
                k as u32,
                link,
                Baseline::default(),
                (&mut b, &mut r, &mut h),
            );
            let pairs = [
                (b, after.radiosity[k]),
                (r, after.residual[k]),
                (h, after.irradiance[k]),
            ];
            pairs.map(|(twin, gpu)| channel_error(gpu, twin))
        };
        let errors: Vec<[f64; 3]> = (0..mesh.texels.len()).into_par_iter().map(errors_of).collect();
        tallies.deposit.merge(errors.into_iter().flatten().collect());
    }

    /// Lets `patches` shoot at once and checks the result.
    ///
    /// Errors: the device fails.
    pub fn check_passes(&mut self, patches: &[u32], solver: &mut GpuSolver) -> Result<()> {
        let mesh = self.mesh;
        solver.make_links(patches, &mut |_| ControlFlow::Continue(()))?;
        let mut shot = vec![Vec3::ZERO; mesh.patches.len()];
        for (n, patch) in patches.iter().enumerate() {
            let x = (n + 1) as f32 / (patches.len() + 1) as f32;
            shot[*patch as usize] = Vec3::new(1.0 + x, 2.0 - x, x * x);
        }
        let receive = |rows: &[Vec<f32>], k: usize| {
            let shares = patches.iter().zip(rows);
            shares.fold(Vec3::ZERO, |sum, (patch, row)| sum + shot[*patch as usize] * row[k])
        };
        let transfers = solver.read_transfers(patches)?;
        for (c, flux) in solver.exchange_flux(&shot)?.iter().enumerate() {
            let sum = receive(&transfers, c);
            let errors: ErrorTally = (0..3).map(|k| ulp_distance(flux[k], sum[k], 0.0)).collect();
            self.tallies.exchange.merge(errors);
        }
        let unshot: Vec<Vec3> = shot.iter().map(|x| *x * 0.25).collect();
        let links = solver.read_rows(patches)?;
        solver.gather_field(&shot, &unshot)?;
        let field = solver.read_field()?;
        for (c, patch) in mesh.patches.iter().enumerate() {
            for k in patch.texels() {
                let texel = &mesh.texels[k];
                let radiosity = update_radiosity(texel, texel.reflectance, field.irradiance[k].truncate());
                let pairs = [
                    (field.irradiance[k], receive(&links, k)),
                    (field.radiosity[k], radiosity),
                    (field.residual[k], unshot[c]),
                ];
                let errors = pairs.map(|(gpu, twin)| channel_error(gpu, twin.extend(0.0)));
                self.tallies.collect.merge(errors.into_iter().collect());
            }
        }
        Ok(())
    }
}

/// Returns the worst channel's error in ulp of the largest channel.
fn channel_error(a: Vec4, b: Vec4) -> f64 {
    let size = a.truncate().abs().max_element();
    (0..3).map(|c| ulp_distance(a[c], b[c], size)).fold(0.0, larger_or_nan)
}
