//! `compare`: one scene solved by both, every difference measured and judged.
//!
//! Three comparisons, because comparing rays with an item buffer directly would mix bugs with
//! discretisation:
//! WGSL ↔ scalar twin on the same input ([`stages`]); item buffer ↔ rays, pair by pair ([`pairs`],
//! [`sights`]); the whole GPU ↔ the twin on the GPU's own links ([`linked`]). Only a fault
//! in the code can break one of these. What pixels cannot resolve is the method's error: it is
//! reported, and bounded by what the scene's silhouettes could bring ([`doubt`]).

pub mod asked;
pub mod counts;
pub mod difference;
pub mod doubt;
pub mod finders;
pub mod linked;
mod outline;
pub mod pairs;
mod raster;
pub mod sights;
pub mod stages;
pub mod tally;
pub mod truth;
pub mod verdict;
pub mod ways;

use crate::judge::comparison::{
    Comparison, Difference, Finding, Gate, ItemBufferPicture, Stage, Way,
};
use crate::solve::watch::Watch;
use common::constants::LINK_BYTES;
use common::cover::sampled;
use common::energy::Energy;
use common::mesh::Mesh;
use common::passes;
use common::passes::{Engine, Exchange};
use common::scene::Scene;
use common::settings::{Drawing, Iteration, Settings, Visibility};
use common::shooting::{Run, Shoot, replay};
use common::{Error, Result};
use cpu::CpuSolver;
use cpu::twin::item_buffer::ItemBuffer;
use cpu::twin::view::View;
use difference::difference;
use doubt::{Doubt, shot};
use glam::Vec3;
use gpu::{Fault, Gpu, GpuSolver};
use linked::{Linked, Links};
use sights::Sights;
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

/// Solves `scene` on both sides and judges every difference; nothing is known of the truth.
pub fn compare(scene: &Scene, request: &Request, watch: &Watch) -> Result<Comparison> {
    let asked = &request.settings;
    let mesh = sampled(scene, &asked.meshing)?;
    check_room(scene, &mesh)?;
    let mut cpu_solver = CpuSolver::new(&mesh, &asked.by(Visibility::Rays).transport);
    let mut gpu_solver =
        GpuSolver::with_faults(request.gpu, &mesh, &asked.transport, request.faults)?;
    let mut gpu_settings = *asked;
    if !(cpu_solver.has_room() && gpu_solver.has_room()) {
        // As a solve does where there is no room for passes.
        gpu_settings.schedule.iteration = Iteration::Southwell;
    }
    let settings = gpu_settings.by(Visibility::Rays);
    let fresh =
        || GpuSolver::with_faults(request.gpu, &mesh, &gpu_settings.transport, request.faults);
    let (cpu, cpu_seconds) = timed(&mut cpu_solver, &mesh, &settings, ("CPU", watch))?;
    let (gpu, gpu_seconds) = timed(&mut gpu_solver, &mesh, &gpu_settings, ("GPU", watch))?;
    watch.begin("lockstep")?;
    let single = gpu_settings.schedule.iteration == Iteration::Southwell;
    let lockstep = if single {
        replay(&mut fresh()?, &cpu.cells())?
    } else {
        repeat(&mut gpu_solver, &mesh, &cpu)?
    };
    watch.begin("WGSL against twin")?;
    let mut stages = stages::stages(
        &mesh,
        &gpu_settings.transport,
        cpu_solver.rays(),
        &mut fresh()?,
    )?;
    let item_buffer = picture(&mesh, &gpu_settings, &cpu, &mut gpu_solver)?;
    let (mut done, all) = (0, mesh.cells.len() as u64);
    let mut sights = sights::sights(
        &mesh,
        &gpu_settings.transport,
        &mut cpu_solver,
        &mut gpu_solver,
        &mut || {
            done += 1;
            watch.count("visibility of all pairs", done, all)
        },
    )?;
    stages.append(&mut sights.stages);
    watch.begin("verdict")?;
    let energy = [&cpu, &gpu].map(|run| Energy::new(&mesh, &run.field, &run.shots));
    let apart = [&lockstep, &gpu].map(|run| difference(&mesh, &run.field, &cpu.field));
    let solved = Solved {
        mesh: &mesh,
        settings: &gpu_settings,
        runs: [&cpu, &gpu],
        lockstep: &lockstep,
        energy: [&energy[0], &energy[1]],
        apart: [&apart[0], &apart[1]],
    };
    let (gates, findings) = solved.judged(&stages, &mut sights)?;
    let [cpu_energy, gpu_energy] = energy;
    Ok(Comparison {
        scene: scene.clone(),
        way: Way::Asked,
        asked: None,
        settings,
        gpu_settings,
        adapter: request.gpu.line.name.clone(),
        cpu_energy,
        gpu_energy,
        seconds: [cpu_seconds, gpu_seconds],
        stages,
        pairs: sights.pairs,
        lockstep_difference: apart[0],
        free_difference: apart[1],
        estimates: [None, None],
        off: None,
        error: [None, None],
        truth: None,
        item_buffer: Some(item_buffer),
        gates,
        findings,
        notes: Vec::new(),
        mesh,
        cpu,
        gpu,
        lockstep,
    })
}

/// What was solved.
struct Solved<'a> {
    mesh: &'a Mesh,
    settings: &'a Settings,
    runs: [&'a Run; 2],
    lockstep: &'a Run,
    energy: [&'a Energy; 2],
    apart: [&'a Difference; 2],
}

impl Solved<'_> {
    fn judged(&self, stages: &[Stage], sights: &mut Sights) -> Result<(Vec<Gate>, Vec<Finding>)> {
        let (mesh, settings) = (self.mesh, self.settings);
        let (twin, shortfall) =
            by_its_links(mesh, settings, &sights.gpu, self.runs, self.lockstep)?;
        let rows = std::mem::take(&mut sights.doubt);
        let doubt = Doubt::new(mesh, &sights.cpu, rows, settings.transport.conserve);
        let evidence = verdict::Evidence {
            mesh,
            settings,
            stages,
            pairs: &sights.pairs,
            apart: self.apart,
            possible: possible(self, &doubt),
            twin,
            shortfall,
            runs: self.runs,
            energy: self.energy,
        };
        Ok((verdict::gates(&evidence), verdict::findings(&evidence)))
    }
}

/// Links of all cells are kept, the CPU's beside the GPU's.
fn check_room(scene: &Scene, mesh: &Mesh) -> Result<()> {
    let bytes = 4 * mesh.cells.len() as u64 * mesh.texels.len() as u64;
    if bytes > LINK_BYTES {
        return Err(Error::Usage(format!(
            "{}: comparing needs all {} × {} links at once, {} MiB of at most {}: lower --texels or --cells",
            scene.name,
            mesh.cells.len(),
            mesh.texels.len(),
            bytes >> 20,
            LINK_BYTES >> 20,
        )));
    }
    Ok(())
}

fn timed(
    engine: &mut dyn Engine,
    mesh: &Mesh,
    settings: &Settings,
    (phase, watch): (&str, &Watch),
) -> Result<(Run, f64)> {
    let start = Instant::now();
    let run = passes::solve(engine, mesh, &settings.schedule, &mut |done| {
        watch.tell(phase, done)
    })?;
    Ok((run, start.elapsed().as_secs_f64()))
}

/// All that each cell has shot on the CPU, at once, by the solver that has the links.
fn repeat(solved: &mut GpuSolver, mesh: &Mesh, cpu: &Run) -> Result<Run> {
    let cells: Vec<u32> = (0..mesh.cells.len() as u32).collect();
    let closures = solved.link(&cells, &mut |_| ControlFlow::Continue(()))?;
    let conserves = solved.conserves();
    let scale = |(x, k): (Vec3, usize)| x * closures[k].scale(conserves);
    let shot: Vec<Vec3> = all_shot(mesh, cpu)
        .into_iter()
        .zip(0..)
        .map(scale)
        .collect();
    solved.gather(&shot, &unshot(mesh, cpu))?;
    Ok(Run {
        field: solved.field()?,
        ..cpu.clone()
    })
}

fn all_shot(mesh: &Mesh, run: &Run) -> Vec<Vec3> {
    shot(mesh, run).into_iter().map(|x| x.as_vec3()).collect()
}

/// What each cell has left; after passes it is the same all over the cell.
fn unshot(mesh: &Mesh, run: &Run) -> Vec<Vec3> {
    let of = |cell: &common::mesh::Cell| run.field.residual[cell.first as usize].truncate();
    mesh.cells.iter().map(of).collect()
}

/// The twin on the GPU's links against the GPU, by the CPU's shooters and by its own; and how much
/// less than the strongest its own shooters had.
fn by_its_links(
    mesh: &Mesh,
    settings: &Settings,
    links: &Links,
    [cpu, gpu]: [&Run; 2],
    lockstep: &Run,
) -> Result<([Difference; 2], Option<f64>)> {
    let cells = mesh.cells.len();
    if gpu.shots.iter().any(|shot| shot.cell as usize >= cells) {
        // A log that names no cell is no run.
        return Ok(([difference::NOT_COMPARABLE; 2], Some(f64::NAN)));
    }
    let single = settings.schedule.iteration == Iteration::Southwell;
    let mut shortfall = None;
    let mut both = Vec::new();
    for (script, run) in [(cpu, lockstep), (gpu, gpu)] {
        let mut twin = Linked::new(mesh, links, settings.transport.conserve);
        if single {
            for cell in script.cells() {
                twin.shoot(cell)?;
            }
            shortfall = Some(twin.shortfall());
        } else {
            twin.collect(&all_shot(mesh, script), &unshot(mesh, script));
        }
        both.push(difference(mesh, &run.field, &twin.into_field()));
    }
    Ok(([both[0], both[1]], shortfall))
}

/// What silhouettes could bring in lockstep, and with what both left unshot running free.
fn possible(solved: &Solved, doubt: &Doubt) -> [Difference; 2] {
    let (mesh, [cpu, gpu]) = (solved.mesh, solved.runs);
    let fixed = solved.settings.schedule.iteration != Iteration::Southwell;
    let lockstep = [doubt.of(cpu, fixed)];
    let free = [
        doubt.of(cpu, false),
        doubt.left(&cpu.field),
        doubt.left(&gpu.field),
    ];
    [
        doubt::difference(mesh, &lockstep, &cpu.field),
        doubt::difference(mesh, &free, &cpu.field),
    ]
}

/// What the first shooter sees. Rays have no item buffer; one is drawn for the eye.
fn picture(
    mesh: &Mesh,
    settings: &Settings,
    cpu: &Run,
    solver: &mut GpuSolver,
) -> Result<ItemBufferPicture> {
    let cell = cpu.shots.first().map_or(0, |shot| shot.cell);
    let mut ids = Vec::new();
    let size = match settings.transport.visibility {
        Visibility::Rays => {
            let view = View::new(mesh, cell, 0, &Drawing::DEFAULT);
            ids = ItemBuffer::draw(mesh, &view, mesh.room).ids;
            Drawing::DEFAULT.size
        }
        Visibility::Drawn(drawing) => {
            solver.probe(cell, &mut |sample| {
                if ids.is_empty() {
                    ids = sample.ids;
                }
            })?;
            drawing.size
        }
    };
    Ok(ItemBufferPicture { cell, size, ids })
}
