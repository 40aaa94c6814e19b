//! Compares hierarchical solves to a requested error: the linkers request by request ([`LinkDiff`]), the GPU's
//! solution with that of the CPU by the same refinement (rays), and with that of the CPU by its own refinement.

use super::criteria::imbalance_bound;
use super::function_calls::check_link_functions;
use super::link_diff::{LinkDiff, LinkerPair};
use crate::compare::comparison::{Comparison, Criterion, Preset};
use crate::diff::difference::compare_fields;
use crate::solve::error_estimate::{ErrorHistory, mean_reflections, rounding_error};
use crate::solve::gpu_linker::LinkerOnGpu;
use crate::solve::progress::ProgressMonitor;
use crate::solve::regather::ErrorEstimate;
use crate::solve::solve_to_error::solve_adaptively_within;
use crate::solve::solved::Solved;
use crate::solve::solver::ErrorTarget;
use crate::solve::task::SolveTask;
use common::Result;
use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::Settings;
use cpu::hierarchy::linker;
use cpu::hierarchy::sky::receive_sky;
use cpu::hierarchy::solver::{ErrorBudget, solve_with_links};
use glam::Vec4;
use gpu::{Gpu, ShaderFault};
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Instant;

/// Steps that rounding may add to the GPU's solve: it refines as the CPU by rays does. Wrong links would refine to the end.
const MORE_STEPS: u32 = 1;

/// Solution of one side.
struct SolvedSide {
    solved: Solved,
    estimate: Option<ErrorEstimate>,
    energy: EnergyBalance,
    seconds: f64,
}

impl SolvedSide {
    /// Replaces the solution by NaN.
    fn into_unknown(mut self) -> Self {
        let run = &mut self.solved.run;
        run.field.radiosity.fill(Vec4::NAN);
        self.energy = EnergyBalance::new(&self.solved.mesh, &run.field, &run.shots);
        self.estimate = None;
        self
    }
}

/// Solves `scene` to an error on both sides and evaluates all differences, without a truth.
///
/// Errors: the scene is invalid, a solver fails, or `watch` interrupts.
pub fn compare_hierarchical(
    scene: &Scene,
    target: ErrorTarget,
    settings: &Settings,
    (gpu, faults): (&Gpu, &[ShaderFault]),
    watch: &ProgressMonitor,
) -> Result<Comparison> {
    let solve = |method: linker::LinkMethod, phase: &str, max_steps: u32| -> Result<SolvedSide> {
        let report = |_: &str, done| watch.report_share(phase, done);
        let start = Instant::now();
        let progress = ProgressMonitor::new(&report);
        let solved = solve_adaptively_within(scene, settings, target, (method, max_steps), &progress)?;
        Ok(SolvedSide {
            seconds: start.elapsed().as_secs_f64(),
            estimate: scene.estimate_error(&solved)?,
            energy: EnergyBalance::new(&solved.mesh, &solved.run.field, &solved.run.shots),
            solved,
        })
    };
    let factory = LinkerOnGpu::factory_on(gpu, faults);
    let cpu = solve(linker::LinkMethod::Shafts, "CPU", u32::MAX)?;
    let by_rays = solve(linker::LinkMethod::Rays, "CPU by rays", u32::MAX)?;
    let max_steps = by_rays.solved.history.as_ref().map_or(1, ErrorHistory::steps) + MORE_STEPS;
    let mut diff = diff_links(scene, target, gpu, faults, watch)?;
    let mut on_gpu = None;
    if diff.stages.refusal.is_none() {
        match solve(linker::LinkMethod::Custom(&factory), "GPU", max_steps) {
            Ok(side) => on_gpu = Some(side),
            Err(error) => diff.stages.take_refusal(error)?,
        }
    }
    let on_gpu = match on_gpu {
        Some(side) => side,
        None => solve(linker::LinkMethod::Rays, "GPU", max_steps)?.into_unknown(),
    };
    let mesh = &cpu.solved.mesh;
    let differences = [
        compare_fields(mesh, &on_gpu.solved.run.field, &by_rays.solved.run.field),
        compare_fields(mesh, &on_gpu.solved.run.field, &cpu.solved.run.field),
    ];
    let mut criteria = diff.criteria();
    criteria.extend(answer_criteria(
        [&cpu, &on_gpu],
        &diff,
        differences.map(|d| d.relative_rms),
        target,
    ));
    let notes_of = |(name, side): (&'static str, &SolvedSide)| {
        let (history, estimate) = (side.solved.history.as_ref(), side.estimate.as_ref());
        let short = history.and_then(|history| history.describe_unmet_target(target.error, estimate));
        let worst = estimate.and_then(|estimate| estimate.describe_worst_faces(scene));
        short
            .into_iter()
            .chain(worst)
            .map(move |note| format!("{name}: {note}"))
    };
    let notes = [("CPU", &cpu), ("GPU", &on_gpu)]
        .into_iter()
        .flat_map(notes_of)
        .chain(diff.stages.describe_unreached())
        .collect();
    Ok(Comparison {
        scene: scene.clone(),
        preset: Preset::Requested,
        error_target: Some(target),
        settings: *settings,
        gpu_settings: *settings,
        adapter: gpu.line.name.clone(),
        seconds: [cpu.seconds, on_gpu.seconds],
        estimates: [cpu.estimate, on_gpu.estimate],
        error_map: {
            let history = cpu.solved.history.as_ref();
            history.and_then(|history| history.error_map(&scene.faces, mesh))
        },
        pairs: diff.block_statistics(),
        stages: diff.stages.checks,
        lockstep_difference: differences[0],
        free_difference: differences[1],
        truth_error: [None, None],
        truth: None,
        item_buffer: None,
        criteria,
        findings: Vec::new(),
        first_divergence: None,
        notes,
        cpu_energy: cpu.energy,
        gpu_energy: on_gpu.energy,
        cpu: cpu.solved.run,
        gpu: on_gpu.solved.run,
        lockstep: by_rays.solved.run,
        mesh: cpu.solved.mesh,
    })
}

/// Runs both linkers in one solve on uniform texels and compares them.
fn diff_links(
    scene: &Scene,
    target: ErrorTarget,
    gpu: &Gpu,
    faults: &[ShaderFault],
    watch: &ProgressMonitor,
) -> Result<LinkDiff> {
    watch.begin_phase("link by link")?;
    let diff = Rc::new(RefCell::new(LinkDiff::default()));
    let factory = LinkerPair::linker_factory(gpu, faults, &diff);
    let mut mesh = Mesh::uniform(
        scene,
        target.texels.unwrap_or(LINK_DIFF_TEXELS).min(LINK_DIFF_TEXELS),
        1,
    )?;
    let goal = ErrorBudget::for_error(target.error as f32);
    let mut report = |done| watch.report_share("link by link", done);
    receive_sky(scene, &mut mesh, target.error as f32, &mut report)?;
    solve_with_links(
        scene,
        &mesh,
        &[],
        goal,
        linker::LinkMethod::Custom(&factory),
        &mut report,
    )?;
    let mut diff = diff.take();
    if diff.stages.refusal.is_none() {
        match check_link_functions(gpu, faults) {
            Ok(mut checks) => diff.stages.checks.append(&mut checks),
            Err(error) => diff.stages.take_refusal(error)?,
        }
    }
    Ok(diff)
}

/// Texels per side of a face in the comparison of linkers; these make requests of all sizes.
const LINK_DIFF_TEXELS: u32 = 8;

fn answer_criteria(
    [cpu, gpu]: [&SolvedSide; 2],
    diff: &LinkDiff,
    [lockstep, free]: [f64; 2],
    target: ErrorTarget,
) -> Vec<Criterion> {
    let rounding_of = |side: &SolvedSide| rounding_error(&side.solved.mesh, &side.solved.run);
    // Links that round otherwise gain or lose as much at each reflection.
    let links = diff.largest_rounding() * mean_reflections(&cpu.solved.mesh, &cpu.solved.run);
    let rounding = rounding_of(cpu) + rounding_of(gpu) + links;
    // A missing estimate is no bound. An estimate far below the target is replaced by the target.
    let allowed_error =
        |side: &SolvedSide| (side.estimate.as_ref()).map_or(f64::NAN, |estimate| estimate.error.max(target.error));
    let mut criteria = vec![
        Criterion::at_most(
            "lockstep: relative RMS",
            lockstep,
            rounding + target.error * diff.largest_turned_share().sqrt(),
            "the CPU by rays refines alike: rounding, and the requested error in blocks where rounding turns a decision",
        ),
        Criterion::at_most(
            "free: relative RMS",
            free,
            rounding + allowed_error(cpu) + allowed_error(gpu),
            "sum of both errors: the requested one, or the estimate if it is larger",
        ),
    ];
    for (name, side) in [("CPU", cpu), ("GPU", gpu)] {
        let (mesh, run) = (&side.solved.mesh, &side.solved.run);
        criteria.push(Criterion::at_most(
            &format!("energy imbalance, {name}"),
            side.energy.imbalance,
            imbalance_bound(mesh, run, &side.energy, 1.0),
            "roundings of the power that each face has shot, and of the power that texels hold",
        ));
    }
    criteria
}
