//! The GPU's solves of a comparison of progressive shooting: by its own choices and by the CPU's, and all links.

use super::checked_stages::CheckedStages;
use super::comparison::{ComparisonRequest, ItemBufferPicture};
use super::criteria::shot_limit;
use super::visibility::{VisibilityCheck, check_visibility};
use super::visibility_bound::shot_radiosity;
use crate::solve::progress::ProgressMonitor;
use common::Result;
use common::mesh::{Mesh, Patch};
use common::passes::{self, Engine, Exchange, PatchClosure};
use common::settings::{Iteration, Settings};
use common::shooting::{RadiosityField, SolveRun, replay_log};
use cpu::CpuSolver;
use glam::{DVec3, Vec3, Vec4};
use gpu::GpuSolver;
use std::ops::ControlFlow;
use std::time::Instant;

/// Solutions of the GPU; after a refused result NaN, without links.
pub struct GpuSolves {
    /// All checks of stages.
    pub stages: CheckedStages,
    /// The run by its own choices.
    pub free: SolveRun,
    /// Its seconds.
    pub seconds: f64,
    /// The CPU's shooters replayed.
    pub lockstep: SolveRun,
    /// Item buffer of the first shooter; none for rays.
    pub item_buffer: Option<ItemBufferPicture>,
    /// All links beside the CPU's.
    pub visibility: VisibilityCheck,
}

impl GpuSolves {
    /// Solves on the GPU unless a stage left no result.
    ///
    /// Errors: the device fails though all stages agree; `watch` interrupts.
    pub fn new(
        stages: CheckedStages,
        inputs: (&Mesh, &Settings, &ComparisonRequest),
        solvers: (&mut CpuSolver, &mut GpuSolver),
        cpu: &SolveRun,
        watch: &ProgressMonitor,
    ) -> Result<Self> {
        let mut unknown = cpu.clone();
        for values in [
            &mut unknown.field.radiosity,
            &mut unknown.field.residual,
            &mut unknown.field.irradiance,
        ] {
            values.fill(Vec4::NAN);
        }
        let mut solves = Self {
            stages,
            lockstep: unknown.clone(),
            free: unknown,
            seconds: f64::NAN,
            item_buffer: None,
            visibility: VisibilityCheck::default(),
        };
        if solves.stages.refusal.is_none()
            && let Err(error) = solves.run(inputs, solvers, cpu, watch)
        {
            solves.stages.take_refusal(error)?;
        }
        Ok(solves)
    }

    /// Runs all solves, and compares all links.
    fn run(
        &mut self,
        (mesh, settings, request): (&Mesh, &Settings, &ComparisonRequest),
        (cpu_solver, gpu_solver): (&mut CpuSolver, &mut GpuSolver),
        cpu: &SolveRun,
        watch: &ProgressMonitor,
    ) -> Result<()> {
        let mut limited = *settings;
        limited.schedule.max_shots = settings.schedule.max_shots.min(shot_limit(cpu).saturating_add(1));
        (self.free, self.seconds) = solve_timed(gpu_solver, mesh, &limited, ("GPU", watch))?;
        watch.begin_phase("lockstep")?;
        self.lockstep = match settings.schedule.iteration {
            Iteration::Southwell => {
                let mut solver = GpuSolver::with_faults(request.gpu, mesh, &settings.transport, request.faults)?;
                replay_log(&mut solver, &cpu.shooter_log())?
            }
            _ => replay_passes(gpu_solver, mesh, cpu)?,
        };
        self.item_buffer = item_buffer_picture(settings, cpu, gpu_solver)?;
        let (mut done, all) = (0, mesh.patches.len() as u64);
        self.visibility = check_visibility(mesh, &settings.transport, cpu_solver, gpu_solver, &mut || {
            done += 1;
            watch.report_count("visibility of all pairs", done, all)
        })?;
        self.stages.checks.append(&mut self.visibility.stages);
        Ok(())
    }
}

/// Solves by a schedule, shown as `phase`; returns the seconds too.
///
/// Errors: the engine fails, or `watch` interrupts.
pub fn solve_timed(
    engine: &mut dyn Engine,
    mesh: &Mesh,
    settings: &Settings,
    (phase, watch): (&str, &ProgressMonitor),
) -> Result<(SolveRun, f64)> {
    let start = Instant::now();
    let run = passes::solve_by_schedule(engine, mesh, &settings.schedule, &mut |done| {
        watch.report_share(phase, done)
    })?;
    Ok((run, start.elapsed().as_secs_f64()))
}

/// Gathers the CPU's total shots of all patches at once on the GPU, which has the links.
fn replay_passes(solver: &mut GpuSolver, mesh: &Mesh, cpu: &SolveRun) -> Result<SolveRun> {
    let patches: Vec<u32> = (0..mesh.patches.len() as u32).collect();
    let closures = solver.make_links(&patches, &mut |_| ControlFlow::Continue(()))?;
    Ok(SolveRun {
        field: gather_shots(solver, &closures, mesh, cpu)?,
        ..cpu.clone()
    })
}

/// Returns the item buffer of the first shooter; none for rays.
fn item_buffer_picture(
    settings: &Settings,
    cpu: &SolveRun,
    solver: &mut GpuSolver,
) -> Result<Option<ItemBufferPicture>> {
    let Some(drawing) = settings.transport.visibility.item_buffer() else {
        return Ok(None);
    };
    let patch = cpu.shots.first().map_or(0, |shot| shot.patch);
    let mut first = None;
    solver.probe_links(patch, &mut |sample| {
        first.get_or_insert(sample.ids);
    })?;
    Ok(Some(ItemBufferPicture {
        patch,
        size: drawing.size,
        ids: first.unwrap_or_default(),
    }))
}

/// Gathers all shots of `run` at once, on links with these closures; after passes the unshot radiosity is constant over
/// each patch.
pub fn gather_shots(
    engine: &mut dyn Engine,
    closures: &[PatchClosure],
    mesh: &Mesh,
    run: &SolveRun,
) -> Result<RadiosityField> {
    let conserves = engine.conserves_energy();
    let scale = |(x, closure): (DVec3, &PatchClosure)| x.as_vec3() * closure.link_scale(conserves);
    let shot: Vec<Vec3> = shot_radiosity(mesh, run).into_iter().zip(closures).map(scale).collect();
    let unshot = |patch: &Patch| run.field.residual[patch.first as usize].truncate();
    let unshot: Vec<Vec3> = mesh.patches.iter().map(unshot).collect();
    engine.gather_field(&shot, &unshot)
}
