//! Checks the stages of a shot on given links (select, deposit, power), and those of passes (exchange, collect).

use super::{PASS_BUFFERS, StageChecker, buffer_ends, factor_scales};
use crate::compare::roundings::escape_difference;
use crate::compare::statistics::{ErrorTally, ValueSource};
use common::Result;
use common::passes::PatchClosure;
use common::sampling::pcg_hash;
use common::shooting::{DepositRule, RadiosityField, Restart, Shot, total_power};
use cpu::shader_twins::closure::sum_form_factors;
use cpu::shader_twins::deposit::deposit;
use cpu::shader_twins::gather::update_radiosity;
use cpu::shader_twins::link::Baseline;
use cpu::shader_twins::patch_transfer::patch_transfer;
use cpu::shader_twins::select::{count_workgroups, load_shot};
use cpu::shader_twins::unshot_power::unshot_power;
use glam::{Vec3, Vec4};
use gpu::GpuSolver;
use gpu::probe::ProbedRow;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// State of a solve between two shots: the field, and the power of each patch.
type ShotState = (RadiosityField, Vec<f32>);

impl StageChecker<'_> {
    /// Checks the flux of the shot, its deposit by the GPU's links, and the powers after it.
    pub fn check_shot(&mut self, shot: &Shot, row: &ProbedRow, [before, after]: [&ShotState; 2]) {
        let (mesh, tallies) = (self.mesh, &mut self.tallies);
        let flux = Vec3::from(shot.power);
        let shooter = shot.patch as usize;
        let source = ValueSource::shot_by(shot.patch);
        let sum = unshot_power(mesh, &before.0, &mesh.patches[shooter]);
        for k in 0..3 {
            tallies.power.add_ulps(source, [shooter, k], [flux[k], sum[k]], sum.w);
        }
        for (c, (patch, w)) in mesh.patches.iter().zip(&after.1).enumerate() {
            let twin = unshot_power(mesh, &after.0, patch).w;
            tallies.power.add_ulps(source, [c, 3], [*w, twin], 0.0);
        }
        let unshot = [shot.unshot, total_power(&after.1)];
        tallies
            .unshot
            .add_ulps(ValueSource::default(), [shooter, 0], unshot, 0.0);
        let sums = [shot.form_factor_sum, row.sum * row.scale];
        tallies
            .closure
            .add_ulps(ValueSource::default(), [shooter, 2], sums, 0.0);
        let reflectance: Vec<Vec3> = mesh.texels.iter().map(|t| t.reflectance).collect();
        let rule = DepositRule::FULL_DEPOSIT;
        let in_flight = load_shot(mesh, shot.patch, flux, row.scale, rule, &reflectance);
        let (before, after) = (&before.0, &after.0);
        let twin_of = |k: usize| {
            let (mut b, mut r, mut h) = (before.radiosity[k], before.residual[k], before.irradiance[k]);
            let state = (&mut b, &mut r, &mut h);
            deposit(&in_flight, k as u32, row.links[k], Baseline::default(), state);
            [b, r, h]
        };
        let twins: Vec<[Vec4; 3]> = (0..mesh.texels.len()).into_par_iter().map(twin_of).collect();
        for (k, twin) in twins.into_iter().enumerate() {
            add_texel(&mut tallies.deposit, source, k, after, twin);
        }
    }

    /// Checks the workgroups that the selection after shot `n` has counted, each beside all; `next` is whether the links of
    /// the next shooter are known, if there is one.
    pub fn add_workgroups(&mut self, n: usize, counted: &[[[u32; 3]; 2]], next: Option<bool>) {
        let is_shot = next.is_some();
        for (k, [found, all]) in counted.iter().enumerate() {
            // Whether links are made again depends on the memory for them.
            let is_needed = [is_shot, next == Some(false), is_shot].get(k).copied();
            let [x, y, _] = *all;
            let twin = count_workgroups([x, y, 1, 0], is_needed.unwrap_or(found[0] > 0));
            for (a, b) in found.iter().zip(twin) {
                (self.tallies.workgroups).add(ValueSource::default(), [n, k], [*a, b], f64::from(a.abs_diff(b)));
            }
        }
    }

    /// Lets the patches of `rows` shoot at once and checks the result.
    ///
    /// Errors: the device fails.
    pub async fn check_passes(&mut self, rows: &BTreeMap<u32, ProbedRow>, solver: &mut GpuSolver<'_>) -> Result<()> {
        let mesh = self.mesh;
        let patches: Vec<u32> = rows.keys().copied().collect();
        let patches = &patches[..];
        let closures = solver
            .request_links(patches, &mut |_| ControlFlow::Continue(()))
            .await?;
        let mut shot = vec![Vec3::ZERO; mesh.patches.len()];
        for (n, patch) in patches.iter().enumerate() {
            let x = (n + 1) as f32 / (patches.len() + 1) as f32;
            shot[*patch as usize] = Vec3::new(1.0 + x, 2.0 - x, x * x);
        }
        let receive = |rows: &[Vec<f32>], k: usize| {
            let shares = patches.iter().zip(rows);
            shares.fold(Vec3::ZERO, |sum, (patch, row)| sum + shot[*patch as usize] * row[k])
        };
        let transfers = solver.request_transfers(patches).await?;
        let links = solver.request_rows(patches).await?;
        for (n, (patch, row)) in rows.iter().enumerate() {
            self.check_side_by_side((*patch, row), (&links[n], &transfers[n], closures[n]));
        }
        buffer_ends::mark_ends(solver, &PASS_BUFFERS);
        for (c, flux) in solver.request_flux(&shot).await?.iter().enumerate() {
            let sum = receive(&transfers, c);
            for k in 0..3 {
                (self.tallies.exchange).add_ulps(ValueSource::default(), [c, k], [flux[k], sum[k]], 0.0);
            }
        }
        let unshot: Vec<Vec3> = shot.iter().map(|x| *x * 0.25).collect();
        let field = solver.request_gather(&shot, &unshot).await?;
        buffer_ends::check_ends(solver, &PASS_BUFFERS, self.tallies).await?;
        for (c, patch) in mesh.patches.iter().enumerate() {
            for k in patch.texels() {
                let texel = &mesh.texels[k];
                let radiosity = update_radiosity(texel, texel.reflectance, field.irradiance[k].truncate());
                let twin = [radiosity, unshot[c], receive(&links, k)].map(|value| value.extend(0.0));
                add_texel(&mut self.tallies.collect, ValueSource::default(), k, &field, twin);
            }
        }
        Ok(())
    }

    /// Checks the powers of a residual whose channels have different signs.
    ///
    /// Errors: the device fails.
    pub async fn check_signed_power(&mut self, solver: &mut GpuSolver<'_>) -> Result<()> {
        let mesh = self.mesh;
        let mut field = solver.request_field().await?;
        for (k, residual) in (0..).zip(&mut field.residual) {
            *residual = signed_colour(k);
        }
        let reflectance: Vec<Vec3> = mesh.texels.iter().map(|texel| texel.reflectance).collect();
        solver.restart_from(DepositRule::FULL_DEPOSIT, &reflectance, &field)?;
        let power = solver.request_power().await?;
        for (c, (patch, w)) in mesh.patches.iter().zip(power).enumerate() {
            let twin = unshot_power(mesh, &field, patch).w;
            (self.tallies.power).add_ulps(ValueSource::default(), [c, 3], [w, twin], 0.0);
        }
        Ok(())
    }

    /// Checks links that were made beside those of other patches, and their sums; `alone` were made by themselves.
    fn check_side_by_side(
        &mut self,
        (patch, alone): (u32, &ProbedRow),
        (links, transfers, closure): (&[f32], &[f32], PatchClosure),
    ) {
        let (mesh, tallies) = (self.mesh, &mut self.tallies);
        let (source, whole) = (ValueSource::shot_by(patch), ValueSource::default());
        let sizes = factor_scales(mesh, self.transport.form_factor, patch);
        for (k, (w, size)) in links.iter().zip(sizes).enumerate() {
            tallies
                .side_by_side
                .add_ulps(source, [k, 0], [*w, alone.links[k]], size);
        }
        for (c, (taker, taken)) in mesh.patches.iter().zip(transfers).enumerate() {
            let twin = patch_transfer(mesh, links, taker);
            tallies.received.add_ulps(source, [c, 0], [*taken, twin], 0.0);
        }
        let shooter = patch as usize;
        let sum = sum_form_factors(transfers, mesh.patches[shooter].shooter.area);
        (tallies.closure).add_ulps(whole, [shooter, 0], [closure.form_factor_sum, sum], 0.0);
        let escaped = [closure.escaped, alone.escaped];
        (tallies.escape).add(whole, [shooter, 0], escaped, escape_difference(escaped[0], escaped[1]));
    }
}

/// Returns a colour of which each channel is between 1 and 2, or between −2 and −1.
fn signed_colour(k: u32) -> Vec4 {
    let channel = |c: u32| {
        let bits = pcg_hash(3 * k + c);
        let size = 1.0 + (bits >> 8) as f32 / (1 << 24) as f32;
        if bits & 1 == 0 { size } else { -size }
    };
    Vec4::new(channel(0), channel(1), channel(2), 0.0)
}

/// Adds B, r and H of texel `k`; the error of a channel is in ulp of the largest one, that of the link in its own.
fn add_texel(tally: &mut ErrorTally, source: ValueSource, k: usize, field: &RadiosityField, twin: [Vec4; 3]) {
    let gpu = [field.radiosity[k], field.residual[k], field.irradiance[k]];
    for (n, (a, b)) in gpu.into_iter().zip(twin).enumerate() {
        let size = a.truncate().abs().max_element();
        for c in 0..3 {
            tally.add_ulps(source, [k, 3 * n + c], [a[c], b[c]], size);
        }
    }
    tally.add_ulps(source, [k, 9], [field.irradiance[k].w, twin[2].w], 0.0);
}
