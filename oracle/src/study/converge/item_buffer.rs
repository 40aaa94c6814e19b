//! Errors of the item buffer against rays: projection × raster × size × lookup.
//!
//! Over all pairs of a shooter and a texel that face each other, centre to centre. The weighted shares are of
//! Σ F·A: what a pair wrongly judged takes from the transfer, or adds to it.

use common::Result;
use common::form_factor::{self, FormFactor};
use common::mesh::Mesh;
use common::rays::Rays;
use common::settings::{Drawing, Lookup, Projection, Raster, Transport, Visibility};
use common::shooting::{Order, Shoot};
use gpu::{Gpu, GpuSolver};
use rayon::prelude::*;
use serde::Serialize;
use std::ops::ControlFlow;
use std::time::Instant;

/// F below this is rounding: two solvers may disagree whether it is 0.
const FACING: f32 = 1e-7;
/// Shots of a timed run.
const SHOTS: usize = 32;
/// Timed runs, of which the fastest counts: other programs only ever slow one down.
const RUNS: usize = 3;

/// One way to use the item buffer, and what it got wrong.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Row {
    /// Projection.
    pub visibility: &'static str,
    /// How faces are drawn.
    pub raster: Raster,
    /// Pixels a side.
    pub size: u32,
    /// Pixels that a texel asks.
    pub lookup: Lookup,
    /// Pairs that face each other.
    pub facing: u64,
    /// Share of them that rays judge otherwise.
    pub mismatched: f64,
    /// Share of F·A that rays see and the item buffer does not.
    pub falsely_hidden: f64,
    /// Share of F·A that the item buffer sees and rays do not.
    pub falsely_seen: f64,
    /// Seconds of a cell's first shot, all stages, by the wall clock.
    pub shot_seconds: f64,
}

/// Every projection with the rasters that it has.
pub const PROJECTIONS: [Projection; 6] = [
    Projection::Paper,
    Projection::Hemisphere(Raster::Tessellated),
    Projection::Hemisphere(Raster::Pixel),
    Projection::Stereographic(Raster::Tessellated),
    Projection::Stereographic(Raster::Pixel),
    Projection::Hemicube,
];

/// Both lookups.
pub const LOOKUPS: [Lookup; 2] = [Lookup::Exact, Lookup::Neighbours];

/// A row for each of [`PROJECTIONS`] × `sizes` × [`LOOKUPS`]; `done` is told of each.
pub fn rows(
    gpu: &Gpu,
    mesh: &Mesh,
    form_factor: FormFactor,
    sizes: &[u32],
    done: &mut dyn FnMut(&Row),
) -> Result<Vec<Row>> {
    let truth = truth(mesh, form_factor);
    let mut rows = Vec::new();
    for projection in PROJECTIONS {
        for size in sizes {
            for lookup in LOOKUPS {
                let drawing = Drawing {
                    projection,
                    size: *size,
                    lookup,
                };
                let row = row(gpu, mesh, form_factor, drawing, &truth)?;
                done(&row);
                rows.push(row);
            }
        }
    }
    Ok(rows)
}

/// F·A of each texel and whether rays see it, for each cell; F = 0 where the pair does not count.
fn truth(mesh: &Mesh, kind: FormFactor) -> Vec<Vec<(f32, bool)>> {
    let rays = Rays::new(mesh);
    mesh.cells
        .par_iter()
        .map(|cell| {
            let pair = |texel: &common::mesh::Texel| {
                let normal = mesh.faces[texel.face as usize].normal;
                let shooter = &cell.shooter;
                let f = form_factor::form_factor(kind, shooter, texel.position, normal, texel.area);
                if texel.face == cell.face || f <= FACING {
                    return (0.0, false);
                }
                let ends = [cell.face, texel.face];
                let seen = rays.visible(shooter.centre, texel.position, ends);
                (f * texel.area, seen)
            };
            mesh.texels.iter().map(pair).collect()
        })
        .collect()
}

fn row(
    gpu: &Gpu,
    mesh: &Mesh,
    form_factor: FormFactor,
    drawing: Drawing,
    truth: &[Vec<(f32, bool)>],
) -> Result<Row> {
    let transport = Transport {
        visibility: Visibility::Drawn(drawing),
        form_factor,
        conserve: false,
    };
    let mut shot_seconds = f64::INFINITY;
    for _ in 1..RUNS {
        let mut solver = GpuSolver::new(gpu, mesh, &transport)?;
        shot_seconds = shot_seconds.min(seconds(&mut solver, mesh)?);
    }
    let mut solver = GpuSolver::new(gpu, mesh, &transport)?;
    shot_seconds = shot_seconds.min(seconds(&mut solver, mesh)?);
    let (mut facing, mut mismatched) = (0u64, 0u64);
    let (mut all, mut hidden, mut lit) = (0.0f64, 0.0f64, 0.0f64);
    for (cell, truth) in truth.iter().enumerate() {
        solver.shoot(cell as u32)?;
        for (h, (weight, seen)) in solver.irradiance()?.iter().zip(truth) {
            let weight = f64::from(*weight);
            facing += u64::from(weight > 0.0);
            all += weight;
            if weight > 0.0 && (h.w > 0.0) != *seen {
                mismatched += 1;
                *(if *seen { &mut hidden } else { &mut lit }) += weight;
            }
        }
    }
    let share = |part: f64, all: f64| if all > 0.0 { part / all } else { 0.0 };
    Ok(Row {
        visibility: drawing.projection.name(),
        raster: drawing.projection.raster(),
        size: drawing.size,
        lookup: drawing.lookup,
        facing,
        mismatched: share(mismatched as f64, facing as f64),
        falsely_hidden: share(hidden, all),
        falsely_seen: share(lit, all),
        shot_seconds,
    })
}

/// Seconds of a cell's first shot: later ones keep what it found out. One goes before, because
/// drivers compile a shader when it is first used.
fn seconds(solver: &mut GpuSolver, mesh: &Mesh) -> Result<f64> {
    let cells = mesh.cells.len();
    let shots = SHOTS.min(cells - 1);
    let log: Vec<u32> = (0..shots)
        .map(|k| (1 + k * (cells - 1) / shots) as u32)
        .collect();
    solver.shoot(0)?;
    let start = Instant::now();
    solver.run(Order::Replay(&log), shots as u32, &mut |_| {
        ControlFlow::Continue(())
    })?;
    Ok(start.elapsed().as_secs_f64() / shots.max(1) as f64)
}
