//! Compares CPU and GPU on one scene: measures every difference and evaluates criteria of agreement.
//!
//! There are three comparisons, because a direct comparison of rays with an item buffer would mix bugs with
//! discretisation errors:
//! WGSL ↔ scalar twin on the same input ([`stages`], [`link_stages`]); item buffer ↔ rays, pair by pair
//! ([`visibility`]); the whole GPU ↔ the CPU's solver on the GPU's own links. Only a fault
//! in the code can break one of these. The finite resolution of pixels is an error of the method: it is reported,
//! and its bound follows from the scene's silhouettes ([`visibility_bound`]). Where solvers differ, the shot, texel and
//! factor in which they part are found by following both ([`divergence`]).

pub mod all_stages;
pub mod checked_stages;
pub mod comparison;
pub mod criteria;
pub mod divergence;
pub mod function_calls;
mod gpu_solves;
pub mod hierarchical;
mod item_buffer;
pub mod link_diff;
pub mod link_stages;
pub mod parting;
pub mod presets;
mod races;
pub mod roundings;
mod snapped_triangles;
pub mod stages;
pub mod statistics;
pub mod truth;
mod turned_blocks;
pub mod visibility;
pub mod visibility_bound;

use crate::compare::all_stages::check_all_stages;
pub use crate::compare::comparison::ComparisonRequest;
use crate::compare::comparison::{Comparison, Preset};
use crate::compare::criteria::LinkBounds;
use crate::compare::gpu_solves::{GpuSolves, gather_shots, solve_timed};
use crate::diff::difference::{Difference, NOT_COMPARABLE, compare_fields};
use crate::solve::progress::ProgressMonitor;
use common::constants::MAX_LINK_BYTES;
use common::cover::sampled_mesh;
use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::passes::{Engine, Exchange};
use common::scene::Scene;
use common::settings::{Iteration, Visibility};
use common::shooting::Shoot;
use common::{Error, Result};
use cpu::CpuSolver;
use cpu::hierarchy::sky::{SKY_ERROR, receive_sky};
use gpu::GpuSolver;
use pollster::block_on;
use visibility::{LinkRows, VisibilityCheck};
use visibility_bound::VisibilityBound;

/// Solves `scene` by progressive shooting on both sides and evaluates all differences, without a truth.
///
/// Errors: the scene is invalid or too large, a solver fails, or `watch` interrupts.
pub fn compare_shooting(scene: &Scene, request: &ComparisonRequest, watch: &ProgressMonitor) -> Result<Comparison> {
    let requested = &request.settings;
    let mut mesh = sampled_mesh(scene, &requested.meshing)?;
    check_memory(scene, &mesh)?;
    let mut callback = |done| watch.report_share("light from outside", done);
    receive_sky(scene, &mut mesh, SKY_ERROR, &mut callback)?;
    let mut cpu_solver = CpuSolver::new(&mesh, &requested.with_visibility(Visibility::Rays).transport);
    let mut gpu_solver = GpuSolver::with_faults(request.gpu, &mesh, &requested.transport, request.faults)?;
    let mut gpu_settings = *requested;
    if !(cpu_solver.transfer_fits() && gpu_solver.transfer_fits()) {
        // A solve without memory for passes falls back to Southwell too.
        gpu_settings.schedule.iteration = Iteration::Southwell;
    }
    let settings = gpu_settings.with_visibility(Visibility::Rays);
    let (cpu, cpu_seconds) = solve_timed(&mut cpu_solver, &mesh, &settings, ("CPU", watch))?;
    watch.begin_phase("WGSL against twin")?;
    let inputs = (&mesh, cpu_solver.rays());
    let checked = block_on(check_all_stages(
        scene,
        inputs,
        &gpu_settings,
        (request.gpu, request.faults),
    ))?;
    let solvers = (&mut cpu_solver, &mut gpu_solver);
    let mut found = GpuSolves::new(checked, (&mesh, &gpu_settings, request), solvers, &cpu, watch)?;
    watch.begin_phase("verdict")?;
    let [cpu_energy, gpu_energy] = [&cpu, &found.free].map(|run| EnergyBalance::new(&mesh, &run.field, &run.shots));
    let [lockstep_difference, free_difference] =
        [&found.lockstep, &found.free].map(|run| compare_fields(&mesh, &run.field, &cpu.field));
    let mut comparison = Comparison {
        scene: scene.clone(),
        preset: Preset::Requested,
        error_target: None,
        settings,
        gpu_settings,
        adapter: request.gpu.line.name.clone(),
        cpu_energy,
        gpu_energy,
        seconds: [cpu_seconds, found.seconds],
        stages: found.stages.checks.clone(),
        pairs: std::mem::take(&mut found.visibility.statistics),
        lockstep_difference,
        free_difference,
        estimates: [None, None],
        error_map: None,
        truth_error: [None, None],
        truth: None,
        item_buffer: found.item_buffer.take(),
        criteria: Vec::new(),
        findings: Vec::new(),
        first_divergence: None,
        notes: found.stages.describe_unreached().into_iter().collect(),
        mesh,
        cpu,
        gpu: found.free,
        lockstep: found.lockstep,
    };
    if found.stages.refusal.is_some() {
        comparison.criteria = found.stages.criteria();
        return Ok(comparison);
    }
    let bounds = LinkBounds {
        twin_differences: [NOT_COMPARABLE; 2],
        shortfall: Some(f64::NAN),
        possible_differences: possible_differences(&comparison, &mut found.visibility),
    };
    let bounds = replay_on_links(&comparison, &found.visibility.gpu, bounds)?;
    comparison.criteria = criteria::agreement_criteria(&comparison, &bounds);
    comparison.findings = criteria::item_buffer_findings(&comparison);
    Ok(comparison)
}

/// Checks that the links of all patches fit in memory, the CPU's beside the GPU's.
///
/// Errors: they do not.
fn check_memory(scene: &Scene, mesh: &Mesh) -> Result<()> {
    let bytes = 4 * mesh.patches.len() as u64 * mesh.texels.len() as u64;
    if bytes > MAX_LINK_BYTES {
        return Err(Error::Usage(format!(
            "{}: comparing needs all {} × {} links at once, {} MiB of at most {}: lower --texels or --patches",
            scene.name,
            mesh.patches.len(),
            mesh.texels.len(),
            bytes >> 20,
            MAX_LINK_BYTES >> 20,
        )));
    }
    Ok(())
}

/// Compares the GPU with the CPU's solver on the GPU's links, by the CPU's shots and by the GPU's.
fn replay_on_links(c: &Comparison, links: &LinkRows, mut bounds: LinkBounds) -> Result<LinkBounds> {
    let patches = c.mesh.patches.len();
    if c.gpu.shots.iter().any(|shot| shot.patch as usize >= patches) {
        // A log with an invalid patch is not comparable.
        return Ok(bounds);
    }
    bounds.shortfall = None;
    let replays = [(&c.cpu, &c.lockstep), (&c.gpu, &c.gpu)];
    for (difference, (shots_of, run)) in bounds.twin_differences.iter_mut().zip(replays) {
        let mut twin = CpuSolver::with_links(&c.mesh, &c.gpu_settings.transport, &links.rows, &links.closures);
        if c.gpu_settings.schedule.iteration == Iteration::Southwell {
            bounds.shortfall = Some(replay_shots(&mut twin, &shots_of.shooter_log())?);
        } else {
            gather_shots(&mut twin, &links.closures, &c.mesh, shots_of)?;
        }
        *difference = compare_fields(&c.mesh, &run.field, &twin.read_field()?);
    }
    Ok(bounds)
}

/// Lets these patches shoot; returns the largest (strongest − chosen) / strongest power.
fn replay_shots(engine: &mut dyn Engine, log: &[u32]) -> Result<f64> {
    let mut shortfall = 0.0f64;
    for patch in log {
        let power = engine.patch_power()?;
        let strongest = power.iter().copied().fold(0.0, f32::max);
        if strongest > 0.0 {
            let missing = strongest - power[*patch as usize];
            shortfall = shortfall.max(f64::from(missing) / f64::from(strongest));
        }
        engine.shoot(*patch)?;
    }
    Ok(shortfall)
}

/// Returns the bounds of the differences: by silhouettes in lockstep, and by silhouettes and unshot light for free
/// runs.
fn possible_differences(c: &Comparison, check: &mut VisibilityCheck) -> [Difference; 2] {
    let (mesh, cpu) = (&c.mesh, &c.cpu);
    let rows = std::mem::take(&mut check.link_bounds);
    let bound = VisibilityBound::new(mesh, &check.cpu, rows, c.gpu_settings.transport.conserve);
    let fixed = c.gpu_settings.schedule.iteration != Iteration::Southwell;
    let lockstep = [bound.bound_of_links(cpu, fixed)];
    let free = [
        bound.bound_of_links(cpu, false),
        bound.bound_of_unshot(&cpu.field),
        bound.bound_of_unshot(&c.gpu.field),
    ];
    [&lockstep[..], &free].map(|parts| visibility_bound::bound_difference(mesh, parts, &cpu.field))
}
