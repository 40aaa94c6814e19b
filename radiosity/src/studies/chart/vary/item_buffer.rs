//! Visibility errors of the item buffer against rays: projection × raster × size × lookup.
//!
//! Compared over all pairs of a patch and a texel that face each other, centre to centre. Weighted
//! shares are of Σ F·A: the transfer that wrong pairs remove or add.

use common::Result;
use common::form_factor::{self, FormFactor};
use common::mesh::Mesh;
use common::rays::Rays;
use common::settings::{ItemBufferProjection, ItemBufferSettings, Lookup, Raster, Transport, Visibility};
use common::shooting::{Shoot, ShotOrder};
use gpu::{Gpu, GpuSolver};
use rayon::prelude::*;
use serde::Serialize;
use std::ops::ControlFlow;
use std::time::Instant;

/// A smaller form factor is rounding; two solvers may disagree whether it is 0.
const MIN_FORM_FACTOR: f32 = 1e-7;
/// Shots per timed run.
const TIMED_SHOTS: usize = 32;
/// Timed runs; the fastest counts, since other load only slows a run down.
const TIMED_RUNS: usize = 3;

/// Errors and time of one item-buffer setting.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ItemBufferRow {
    /// Name of the projection.
    pub visibility: &'static str,
    /// Rasterisation of faces.
    pub raster: Raster,
    /// Pixels per side.
    pub size: u32,
    /// Pixels read per texel.
    pub lookup: Lookup,
    /// Number of pairs that face each other.
    pub facing: u64,
    /// Share of the pairs on which rays disagree.
    pub mismatched: f64,
    /// Share of F·A visible to rays and hidden in the item buffer.
    pub falsely_hidden: f64,
    /// Share of F·A visible in the item buffer and hidden to rays.
    pub falsely_seen: f64,
    /// Wall-clock seconds of a patch's first shot, all stages.
    pub shot_seconds: f64,
}

/// Every projection with each of its rasterisations.
pub const TESTED_PROJECTIONS: [ItemBufferProjection; 6] = [
    ItemBufferProjection::Paper,
    ItemBufferProjection::Hemisphere(Raster::Tessellated),
    ItemBufferProjection::Hemisphere(Raster::Pixel),
    ItemBufferProjection::Stereographic(Raster::Tessellated),
    ItemBufferProjection::Stereographic(Raster::Pixel),
    ItemBufferProjection::Hemicube,
];

/// Both pixel lookups.
pub const TESTED_LOOKUPS: [Lookup; 2] = [Lookup::Exact, Lookup::Neighbours];

/// Measures a row for each of [`TESTED_PROJECTIONS`] × `sizes` × [`TESTED_LOOKUPS`] and calls `done` with it.
/// Errors: the GPU fails.
pub fn measure_rows(
    gpu: &Gpu,
    mesh: &Mesh,
    form_factor: FormFactor,
    sizes: &[u32],
    done: &mut dyn FnMut(&ItemBufferRow),
) -> Result<Vec<ItemBufferRow>> {
    let truth = trace_truth(mesh, form_factor);
    let mut rows = Vec::new();
    for projection in TESTED_PROJECTIONS {
        for size in sizes {
            for lookup in TESTED_LOOKUPS {
                let drawing = ItemBufferSettings {
                    projection,
                    size: *size,
                    lookup,
                };
                let row = measure_row(gpu, mesh, form_factor, drawing, &truth)?;
                done(&row);
                rows.push(row);
            }
        }
    }
    Ok(rows)
}

/// Returns for each patch and texel F·A and visibility by rays; F·A = 0 for pairs not compared.
fn trace_truth(mesh: &Mesh, kind: FormFactor) -> Vec<Vec<(f32, bool)>> {
    let rays = Rays::new(mesh);
    mesh.patches
        .par_iter()
        .map(|patch| {
            let pair = |texel: &common::mesh::Texel| {
                let normal = mesh.faces[texel.face as usize].normal;
                let shooter = &patch.shooter;
                let f = form_factor::form_factor(kind, shooter, texel.position, normal, texel.area);
                if texel.face == patch.face || f <= MIN_FORM_FACTOR {
                    return (0.0, false);
                }
                let ends = [patch.face, texel.face];
                let seen = rays.is_visible(shooter.centre, texel.position, ends);
                (f * texel.area, seen)
            };
            mesh.texels.iter().map(pair).collect()
        })
        .collect()
}

fn measure_row(
    gpu: &Gpu,
    mesh: &Mesh,
    form_factor: FormFactor,
    drawing: ItemBufferSettings,
    truth: &[Vec<(f32, bool)>],
) -> Result<ItemBufferRow> {
    let transport = Transport {
        visibility: Visibility::ItemBuffer(drawing),
        form_factor,
        conserve: false,
    };
    let mut shot_seconds = f64::INFINITY;
    for _ in 1..TIMED_RUNS {
        let mut solver = GpuSolver::new(gpu, mesh, &transport)?;
        shot_seconds = shot_seconds.min(time_first_shots(&mut solver, mesh)?);
    }
    let mut solver = GpuSolver::new(gpu, mesh, &transport)?;
    shot_seconds = shot_seconds.min(time_first_shots(&mut solver, mesh)?);
    let (mut facing, mut mismatched) = (0u64, 0u64);
    let (mut all, mut hidden, mut lit) = (0.0f64, 0.0f64, 0.0f64);
    for (cell, truth) in truth.iter().enumerate() {
        solver.shoot(cell as u32)?;
        for (h, (weight, seen)) in solver.read_irradiance()?.iter().zip(truth) {
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
    Ok(ItemBufferRow {
        visibility: drawing.projection.name(),
        raster: drawing.projection.raster_method(),
        size: drawing.size,
        lookup: drawing.lookup,
        facing,
        mismatched: share(mismatched as f64, facing as f64),
        falsely_hidden: share(hidden, all),
        falsely_seen: share(lit, all),
        shot_seconds,
    })
}

/// Times the first shot of patches, seconds per shot; later shots reuse links. One untimed shot
/// precedes, since drivers compile a shader at its first use.
fn time_first_shots(solver: &mut GpuSolver, mesh: &Mesh) -> Result<f64> {
    let patches = mesh.patches.len();
    let shots = TIMED_SHOTS.min(patches - 1);
    let log: Vec<u32> = (0..shots).map(|k| (1 + k * (patches - 1) / shots) as u32).collect();
    solver.shoot(0)?;
    let start = Instant::now();
    solver.run(
        ShotOrder::Replay(&log),
        shots as u32,
        &mut |_| ControlFlow::Continue(()),
    )?;
    Ok(start.elapsed().as_secs_f64() / shots.max(1) as f64)
}
