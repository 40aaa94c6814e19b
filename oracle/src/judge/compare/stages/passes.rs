//! The stages of a solve by passes: exchange and collect.

use super::shots::off;
use super::{Bench, Tallies};
use crate::judge::compare::tally::ulps;
use common::Result;
use common::passes::Exchange;
use common::shooting::Shoot;
use cpu::twin::accumulate::settle;
use glam::Vec3;
use gpu::GpuSolver;
use gpu::probe::Row;
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// The cells of `rows` shoot all at once; false where the GPU has no room for passes.
pub fn check(
    bench: &Bench,
    rows: &BTreeMap<u32, Row>,
    solver: &mut GpuSolver,
    tallies: &mut Tallies,
) -> Result<bool> {
    let mesh = bench.mesh;
    if !solver.has_room() {
        return Ok(false);
    }
    let cells: Vec<u32> = rows.keys().copied().collect();
    solver.link(&cells, &mut |_| ControlFlow::Continue(()))?;
    let mut shot = vec![Vec3::ZERO; mesh.cells.len()];
    for (n, cell) in cells.iter().enumerate() {
        let x = (n + 1) as f32 / (cells.len() + 1) as f32;
        shot[*cell as usize] = Vec3::new(1.0 + x, 2.0 - x, x * x);
    }
    let taken = solver.taken(&cells)?;
    let flux = solver.exchange(&shot)?;
    for (c, flux) in flux.iter().enumerate() {
        let mut sum = Vec3::ZERO;
        for (cell, taken) in cells.iter().zip(&taken) {
            sum += shot[*cell as usize] * taken[c];
        }
        for k in 0..3 {
            tallies.exchange.add(ulps(flux[k], sum[k], 0.0));
        }
    }
    let unshot: Vec<Vec3> = shot.iter().map(|x| *x * 0.25).collect();
    let links = solver.rows(&cells)?;
    solver.gather(&shot, &unshot)?;
    let field = solver.field()?;
    for (c, cell) in mesh.cells.iter().enumerate() {
        for k in cell.texels() {
            let mut sum = Vec3::ZERO;
            for (cell, links) in cells.iter().zip(&links) {
                sum += shot[*cell as usize] * links[k];
            }
            let texel = &mesh.texels[k];
            let radiosity = settle(texel, texel.reflectance, field.irradiance[k].truncate());
            tallies
                .collect
                .add(off(field.irradiance[k], sum.extend(0.0)));
            tallies
                .collect
                .add(off(field.radiosity[k], radiosity.extend(0.0)));
            tallies
                .collect
                .add(off(field.residual[k], unshot[c].extend(0.0)));
        }
    }
    Ok(true)
}
