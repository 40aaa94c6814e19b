//! `compare`: one scene solved by both, every difference measured and judged.
//!
//! Three solvers, because rays against item buffer would mix bugs with discretisation:
//! WGSL ↔ scalar twin on the same item buffer (rounding only, [`stages`]); item buffer ↔ rays
//! (sampling only, [`pairs`]); both ↔ conservation of energy and each other ([`verdict`]).

pub mod difference;
mod outline;
pub mod pairs;
pub mod stages;
pub mod verdict;

use crate::comparison::{Comparison, ItemBufferPicture};
use common::Result;
use common::energy::Energy;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::{Settings, Visibility};
use common::shooting::{self, Engine, Run, Shot, replay, solve};
use cpu::CpuSolver;
use cpu::item_buffer::{ItemBuffer, View};
use difference::difference;
use gpu::{Fault, Gpu, GpuSolver};
use std::ops::ControlFlow;
use std::time::Instant;

/// What goes into a comparison beside the scene.
pub struct Request<'a> {
    /// Options; `visibility` is the GPU's, the CPU takes rays.
    pub settings: Settings,
    /// The device.
    pub gpu: &'a Gpu,
    /// Faults planted in the shaders: none but to prove that they are caught.
    pub faults: &'a [Fault],
}

/// Told what is going on: a phase's name, steps done and steps in all (0: unknown).
pub type Progress<'a> = &'a mut dyn FnMut(&str, u64, u64) -> ControlFlow<()>;

/// Solves `scene` on both sides and judges every difference.
pub fn compare(scene: &Scene, request: &Request, progress: Progress) -> Result<Comparison> {
    let gpu_settings = request.settings.clone();
    let settings = Settings {
        visibility: Visibility::Rays,
        ..gpu_settings.clone()
    };
    let mesh = Mesh::uniform(scene, settings.texels, settings.cells)?;
    let fresh = || GpuSolver::with_faults(request.gpu, &mesh, &gpu_settings, request.faults);

    let mut cpu_solver = CpuSolver::new(&mesh, &settings);
    let (cpu, cpu_seconds) = timed(&mut cpu_solver, &settings, &mut |shot, emitted| {
        watch(progress, "CPU", shot, emitted, &settings)
    })?;
    let (gpu, gpu_seconds) = timed(&mut fresh()?, &gpu_settings, &mut |shot, emitted| {
        watch(progress, "GPU", shot, emitted, &settings)
    })?;
    let _ = progress("lockstep", 0, 0);
    let lockstep = replay(&mut fresh()?, &cpu.cells())?;
    let _ = progress("WGSL against twin", 0, 0);
    let stages = stages::stages(&mesh, &gpu_settings, cpu_solver.rays(), &mut fresh()?)?;
    let item_buffer = picture(
        &mesh,
        &gpu_settings,
        cpu.shots.first().map_or(0, |shot| shot.cell),
        &mut fresh()?,
    )?;
    let mut done = 0;
    let pairs = pairs::pairs(
        &mesh,
        &gpu_settings,
        cpu_solver.rays(),
        &mut fresh()?,
        &mut || {
            done += 1;
            let _ = progress("visibility of all pairs", done, mesh.cells.len() as u64);
        },
    )?;

    let cpu_energy = Energy::new(&mesh, &cpu.field, &cpu.shots);
    let gpu_energy = Energy::new(&mesh, &gpu.field, &gpu.shots);
    let lockstep_difference = difference(&mesh, &lockstep.field, &cpu.field);
    let free_difference = difference(&mesh, &gpu.field, &cpu.field);
    let gates = verdict::gates(&verdict::Evidence {
        settings: &settings,
        stages: &stages,
        pairs: &pairs,
        lockstep: &lockstep_difference,
        free: &free_difference,
        runs: [&cpu, &gpu],
        energy: [&cpu_energy, &gpu_energy],
    });
    Ok(Comparison {
        scene: scene.clone(),
        mesh,
        settings,
        gpu_settings,
        adapter: request.gpu.line.name.clone(),
        cpu,
        gpu,
        lockstep,
        cpu_energy,
        gpu_energy,
        seconds: [cpu_seconds, gpu_seconds],
        stages,
        pairs,
        lockstep_difference,
        free_difference,
        item_buffer,
        gates,
    })
}

fn timed(
    engine: &mut dyn Engine,
    settings: &Settings,
    watch: &mut dyn FnMut(&Shot, f32) -> ControlFlow<()>,
) -> Result<(Run, f64)> {
    let start = Instant::now();
    let run = solve(engine, settings, watch)?;
    Ok((run, start.elapsed().as_secs_f64()))
}

/// Progress of a solve in thousandths.
fn watch(
    progress: Progress,
    phase: &str,
    shot: &Shot,
    emitted: f32,
    settings: &Settings,
) -> ControlFlow<()> {
    let done = shooting::progress(shot, emitted, settings.epsilon);
    progress(phase, (done * 1000.0) as u64, 1000)
}

/// What a shooter sees. Rays have no item buffer; one is drawn for the eye.
fn picture(
    mesh: &Mesh,
    settings: &Settings,
    cell: u32,
    solver: &mut GpuSolver,
) -> Result<ItemBufferPicture> {
    if settings.visibility == Visibility::Rays {
        let size = settings.item_buffer;
        let drawn = Settings {
            visibility: Visibility::Stereographic,
            ..settings.clone()
        };
        let view = View::new(mesh, cell, 0, &drawn);
        return Ok(ItemBufferPicture {
            cell,
            size,
            ids: ItemBuffer::draw(mesh, &view, mesh.room).ids,
        });
    }
    solver.shoot(cell)?;
    Ok(ItemBufferPicture {
        cell,
        size: settings.item_buffer,
        ids: solver.item_buffer()?,
    })
}
