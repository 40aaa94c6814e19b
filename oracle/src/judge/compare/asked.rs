//! A scene solved to an error on both, and judged: who finds links, question by question; the GPU's answer
//! against that of the CPU by the same decisions; and against that of the CPU as it solves by itself.

use super::difference::difference;
use super::finders::{Both, Found};
use super::verdict::{imbalance, of_stages};
use crate::judge::comparison::{Comparison, Gate, Way};
use crate::solve::check::Estimate;
use crate::solve::climb::climb;
use crate::solve::finder::OnGpu;
use crate::solve::left::rounding;
use crate::solve::solved::Solved;
use crate::solve::solver::Asked;
use crate::solve::task::Task;
use crate::solve::watch::Watch;
use common::Result;
use common::energy::Energy;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::Settings;
use cpu::hierarchy::find;
use cpu::hierarchy::solve::{Goal, solve_by};
use gpu::{Fault, Gpu};
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Instant;

/// One of the answers.
struct Answered {
    solved: Solved,
    estimate: Option<Estimate>,
    energy: Energy,
    seconds: f64,
}

/// Solves `scene` to an error on both sides and judges every difference; nothing is known of the truth.
pub fn compare(
    scene: &Scene,
    asked: Asked,
    settings: &Settings,
    (gpu, faults): (&Gpu, &[Fault]),
    watch: &Watch,
) -> Result<Comparison> {
    let solve = |way: find::Way, phase: &str| -> Result<Answered> {
        let told = |_: &str, done| watch.tell(phase, done);
        let start = Instant::now();
        let solved = climb(scene, settings, asked, way, &Watch::new(&told))?;
        Ok(Answered {
            seconds: start.elapsed().as_secs_f64(),
            estimate: scene.estimate(&solved)?,
            energy: Energy::new(&solved.mesh, &solved.run.field, &solved.run.shots),
            solved,
        })
    };
    let maker = OnGpu::maker(gpu, faults);
    let cpu = solve(find::Way::Shafts, "CPU")?;
    let on_gpu = solve(find::Way::By(&maker), "GPU")?;
    let by_rays = solve(find::Way::Rays, "CPU by rays")?;
    let found = found(scene, asked, gpu, faults, watch)?;
    let mesh = &cpu.solved.mesh;
    let apart = [
        difference(mesh, &on_gpu.solved.run.field, &by_rays.solved.run.field),
        difference(mesh, &on_gpu.solved.run.field, &cpu.solved.run.field),
    ];
    let stages = found.stages();
    let mut gates = of_stages(&stages);
    gates.extend(answers(
        [&cpu, &on_gpu],
        &found,
        apart.map(|d| d.relative_rms),
        asked,
    ));
    let mut notes = Vec::new();
    for (name, answered) in [("CPU", &cpu), ("GPU", &on_gpu)] {
        notes.extend(answered.told(asked).map(|note| format!("{name}: {note}")));
    }
    Ok(Comparison {
        scene: scene.clone(),
        way: Way::Asked,
        asked: Some(asked),
        settings: *settings,
        gpu_settings: *settings,
        adapter: gpu.line.name.clone(),
        seconds: [cpu.seconds, on_gpu.seconds],
        estimates: [cpu.estimate, on_gpu.estimate],
        off: {
            let moved = cpu.solved.moved.as_ref();
            moved.and_then(|moved| moved.map(&scene.faces, mesh))
        },
        stages,
        pairs: found.pairs(),
        lockstep_difference: apart[0],
        free_difference: apart[1],
        error: [None, None],
        truth: None,
        item_buffer: None,
        gates,
        findings: Vec::new(),
        notes,
        cpu_energy: cpu.energy,
        gpu_energy: on_gpu.energy,
        cpu: cpu.solved.run,
        gpu: on_gpu.solved.run,
        lockstep: by_rays.solved.run,
        mesh: cpu.solved.mesh,
    })
}

impl Answered {
    fn error(&self) -> Option<f64> {
        self.estimate.as_ref().map(|estimate| estimate.error)
    }

    fn told(&self, asked: Asked) -> impl Iterator<Item = String> {
        let estimate = self.estimate.as_ref();
        let moved = self.solved.moved.as_ref();
        let short = moved.and_then(|moved| moved.short_of(asked.error, estimate));
        short.into_iter().chain(estimate.and_then(Estimate::worse))
    }
}

/// Both are asked in one solve on even texels.
fn found(scene: &Scene, asked: Asked, gpu: &Gpu, faults: &[Fault], watch: &Watch) -> Result<Found> {
    watch.begin("link by link")?;
    let found = Rc::new(RefCell::new(Found::default()));
    let maker = Both::maker(gpu, faults, &found);
    let mesh = Mesh::uniform(scene, asked.texels.unwrap_or(EVEN).min(EVEN), 1)?;
    let goal = Goal::of(asked.error as f32);
    let mut told = |done| watch.tell("link by link", done);
    solve_by(scene, &mesh, &[], goal, find::Way::By(&maker), &mut told)?;
    Ok(*found.borrow())
}

/// Texels a side of a face on which both are asked for every link: the questions are of all sizes there.
const EVEN: u32 = 8;

fn answers(
    [cpu, gpu]: [&Answered; 2],
    found: &Found,
    [lockstep, free]: [f64; 2],
    asked: Asked,
) -> Vec<Gate> {
    let rounded = |answered: &Answered| rounding(&answered.solved.mesh, &answered.solved.run);
    let rounding = rounded(cpu) + rounded(gpu);
    // An estimate that is not there is no bound; nor is one far below what was asked, which no step was
    // needed to reach.
    let off = |answered: &Answered| answered.error().map_or(f64::NAN, |e| e.max(asked.error));
    let mut gates = vec![
        Gate::at_most(
            "lockstep: relative RMS",
            lockstep,
            rounding + asked.error * found.turned().sqrt(),
            "the CPU by rays takes the same decisions: rounding, and in blocks that it turns, what is asked",
        ),
        Gate::at_most(
            "free: relative RMS",
            free,
            rounding + off(cpu) + off(gpu),
            "how far the two may be off: what was asked, or what they say where that is more",
        ),
    ];
    for (name, answered) in [("CPU", cpu), ("GPU", gpu)] {
        let (mesh, run) = (&answered.solved.mesh, &answered.solved.run);
        gates.push(Gate::at_most(
            &format!("energy imbalance, {name}"),
            answered.energy.imbalance,
            imbalance(mesh, run, &answered.energy, 1.0),
            "roundings of what each face has shot, and of what texels hold",
        ));
    }
    gates
}
