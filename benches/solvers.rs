//! Times one shot, and one solve to an error of 10 %, by CPU rays, CPU twin and GPU, each on a fresh engine, in rounds so
//! that other load affects all three alike. Prints the times, their ratios to CPU rays, and the error of each.

use common::mesh::Mesh;
use common::passes::Engine;
use common::settings::{ItemBufferSettings, Settings, Transport, Visibility};
use common::shooting::{ShotOrder, SolveRun};
use cpu::CpuSolver;
use gpu::{Gpu, GpuSolver};
use radiosity_benches::accuracy::AccuracyTarget;
use radiosity_benches::{median_and_range, whole_faces};
use radiosity_tests::engines::solve_by_schedule;
use radiosity_tests::{bundled_scene, furnace, paper_room};
use std::ops::ControlFlow;
use std::time::Instant;

/// Error of a timed solve: relative RMS of B − E.
const ERROR_BOUND: f64 = 0.1;
/// Shots per run; a single one would mostly time the transfer to the device.
const TIMED_SHOTS: u32 = 4;
const TIMED_ROUNDS: usize = 5;

/// Name, whether visibility is by rays (else by item buffer), and whether it runs on the GPU.
const SOLVERS: [(&str, bool, bool); 3] = [
    ("CPU rays", true, false),
    ("CPU twin", false, false),
    ("GPU", false, true),
];

fn main() {
    let gpu = Gpu::open(None).expect("the bench compares with a GPU, a software one at least");
    println!(
        "Seconds, and the ratio to CPU rays, median of {TIMED_ROUNDS} rounds (least, largest); GPU: {}",
        gpu.line.name
    );
    // 1 536, 39 936 and 172 032 texels.
    let scenes = [
        (furnace(0.7), 16),
        (paper_room(), 16),
        (bundled_scene("paper_room_objects.obj"), 32),
    ];
    for (scene, texels) in scenes {
        let mesh = Mesh::uniform(&scene, texels, 1).expect("the rooms are sound");
        let target = AccuracyTarget::new(mesh, whole_faces(texels));
        println!("{} faces {texels}²", scene.faces.len());
        measure_room(&target, &gpu);
    }
}

fn measure_room(target: &AccuracyTarget, gpu: &Gpu) {
    let settings = target.settings_to(ERROR_BOUND);
    let rounds = [(); TIMED_ROUNDS].map(|()| {
        SOLVERS.map(|(_, by_rays, on_gpu)| {
            let visibility = match by_rays {
                true => Visibility::Rays,
                false => Visibility::ItemBuffer(ItemBufferSettings::DEFAULT),
            };
            let transport = Transport {
                visibility,
                ..settings.transport
            };
            time_solver(&target.mesh, &Settings { transport, ..settings }, on_gpu.then_some(gpu))
        })
    });
    for (k, (name, ..)) in SOLVERS.iter().enumerate() {
        for (what, words) in ["one shot", "one solve"].iter().enumerate() {
            let [seconds, ..] = median_and_range(rounds.iter().map(|round| round[k].0[what]));
            let ratios = rounds.iter().map(|round| round[k].0[what] / round[0].0[what]);
            let [median, least, largest] = median_and_range(ratios);
            println!("  {name:<9} {words:<10} {seconds:9.4} s {median:8.2} ({least:.2}, {largest:.2})");
        }
        let run = &rounds[0][k].1;
        let error = target.relative_rms(&run.field) * 100.0;
        println!("  {name:<9} error {error:.2} % ({} shots)", run.shots.len());
    }
}

/// Returns the seconds of one shot and of one solve, and the solve.
fn time_solver(mesh: &Mesh, settings: &Settings, gpu: Option<&Gpu>) -> ([f64; 2], SolveRun) {
    let make_engine = || -> Box<dyn Engine> {
        match gpu {
            Some(gpu) => Box::new(GpuSolver::new(gpu, mesh, &settings.transport).expect("the rooms fit any GPU")),
            None => Box::new(CpuSolver::new(mesh, &settings.transport)),
        }
    };
    let log: Vec<u32> = (0..TIMED_SHOTS).map(|k| k % mesh.patches.len() as u32).collect();
    let mut engine = make_engine();
    let start = Instant::now();
    let shots = engine.run(ShotOrder::Replay(&log), TIMED_SHOTS, &mut |_| ControlFlow::Continue(()));
    shots.expect("shots succeed");
    let shot = start.elapsed().as_secs_f64() / f64::from(TIMED_SHOTS);
    let mut engine = make_engine();
    let start = Instant::now();
    let run = solve_by_schedule(&mut *engine, mesh, &settings.schedule);
    ([shot, start.elapsed().as_secs_f64()], run)
}
