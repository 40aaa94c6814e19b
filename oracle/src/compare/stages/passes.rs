//! Checks the stages of a solve by passes: exchange and collect.

use super::shots::channel_error;
use super::{StageInputs, Tallies};
use crate::compare::statistics::ulp_distance;
use common::Result;
use common::passes::Exchange;
use common::shooting::Shoot;
use cpu::shader_twins::gather::update_radiosity;
use glam::Vec3;
use gpu::GpuSolver;
use gpu::probe::ProbedRow;
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// Lets the patches of `rows` shoot at once and checks the result; false if the GPU lacks memory for passes.
///
/// Errors: the device fails.
pub fn check_passes(
    inputs: &StageInputs,
    rows: &BTreeMap<u32, ProbedRow>,
    solver: &mut GpuSolver,
    tallies: &mut Tallies,
) -> Result<bool> {
    let mesh = inputs.mesh;
    if !solver.has_room() {
        return Ok(false);
    }
    let patches: Vec<u32> = rows.keys().copied().collect();
    solver.make_links(&patches, &mut |_| ControlFlow::Continue(()))?;
    let mut shot = vec![Vec3::ZERO; mesh.patches.len()];
    for (n, patch) in patches.iter().enumerate() {
        let x = (n + 1) as f32 / (patches.len() + 1) as f32;
        shot[*patch as usize] = Vec3::new(1.0 + x, 2.0 - x, x * x);
    }
    let taken = solver.read_transfers(&patches)?;
    let flux = solver.exchange_flux(&shot)?;
    for (c, flux) in flux.iter().enumerate() {
        let mut sum = Vec3::ZERO;
        for (patch, taken) in patches.iter().zip(&taken) {
            sum += shot[*patch as usize] * taken[c];
        }
        for k in 0..3 {
            tallies.exchange.add(ulp_distance(flux[k], sum[k], 0.0));
        }
    }
    let unshot: Vec<Vec3> = shot.iter().map(|x| *x * 0.25).collect();
    let links = solver.read_rows(&patches)?;
    solver.gather_field(&shot, &unshot)?;
    let field = solver.read_field()?;
    for (c, patch) in mesh.patches.iter().enumerate() {
        for k in patch.texels() {
            let mut sum = Vec3::ZERO;
            for (patch, links) in patches.iter().zip(&links) {
                sum += shot[*patch as usize] * links[k];
            }
            let texel = &mesh.texels[k];
            let radiosity = update_radiosity(texel, texel.reflectance, field.irradiance[k].truncate());
            tallies.collect.add(channel_error(field.irradiance[k], sum.extend(0.0)));
            tallies
                .collect
                .add(channel_error(field.radiosity[k], radiosity.extend(0.0)));
            tallies
                .collect
                .add(channel_error(field.residual[k], unshot[c].extend(0.0)));
        }
    }
    Ok(true)
}
