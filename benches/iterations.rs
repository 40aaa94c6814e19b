//! Compares the iterations to an error of 1 % in a cube with 5×5 patches per wall, of which the centre
//! patch of one wall emits, with all links built beforehand: passes, shots, time over Southwell's.

use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::{Iteration, Schedule, Settings};
use common::shooting::SolveRun;
use cpu::CpuSolver;
use glam::Vec3;
use radiosity_benches::accuracy::AccuracyTarget;
use radiosity_benches::{median_and_range, whole_faces};
use radiosity_tests::engines::{all_patches, make_links, solve_by_schedule};
use radiosity_tests::{divide_faces, furnace};
use std::time::Instant;

const PATCHES_PER_SIDE: u32 = 5;
const ERROR_BOUND: f64 = 0.01;
const TIMED_ROUNDS: usize = 7;
const ALL_ITERATIONS: [Iteration; 3] = [Iteration::Southwell, Iteration::Chebyshev, Iteration::Cg];

fn main() {
    for texels in [1, 8, 32] {
        for reflectance in [0.5, 0.7, 0.9] {
            measure_iterations(texels, reflectance);
        }
    }
}

fn measure_iterations(texels: u32, reflectance: f32) {
    let mut faces = divide_faces(&furnace(reflectance).faces, PATCHES_PER_SIDE);
    faces.iter_mut().for_each(|face| face.emission = Vec3::ZERO);
    faces[(PATCHES_PER_SIDE * PATCHES_PER_SIDE / 2) as usize].emission = Vec3::ONE;
    let scene = Scene {
        faces,
        ..Scene::default()
    };
    let mesh = Mesh::uniform(&scene, texels, 1).expect("the cube is sound");
    let target = AccuracyTarget::new(mesh, whole_faces(texels));
    let settings = ALL_ITERATIONS.map(|iteration| match iteration {
        Iteration::Southwell => Settings {
            schedule: Schedule {
                iteration,
                epsilon: 0.0,
                max_shots: target.southwell_shots(ERROR_BOUND).len() as u32,
            },
            ..target.settings
        },
        _ => {
            let mut of = target.clone();
            of.settings.schedule.iteration = iteration;
            of.settings_to(ERROR_BOUND)
        }
    });
    let mut engine = CpuSolver::new(&target.mesh, &settings[0].transport);
    make_links(&mut engine, &all_patches(&target.mesh));
    let rounds: Vec<Vec<(f64, SolveRun)>> = (0..TIMED_ROUNDS)
        .map(|_| {
            let timed = settings.iter().map(|settings| {
                target.restart_engine(&mut engine);
                let start = Instant::now();
                let run = solve_by_schedule(&mut engine, &target.mesh, &settings.schedule);
                (start.elapsed().as_secs_f64(), run)
            });
            timed.collect()
        })
        .collect();
    println!("reflectance {reflectance}, {texels}×{texels} texels a patch, to 1 %");
    for (k, iteration) in ALL_ITERATIONS.iter().enumerate() {
        let [median, least, largest] = median_and_range(rounds.iter().map(|round| round[k].0 / round[0].0));
        let (seconds, run) = &rounds[TIMED_ROUNDS - 1][k];
        println!(
            "  {:<10} {:5} passes {:6} shots {:9.3} ms, over Southwell's {median:.4} ({least:.4}, {largest:.4}), error {:.2} %",
            format!("{iteration:?}"),
            run.passes,
            run.shooters,
            seconds * 1e3,
            100.0 * target.relative_rms(&run.field),
        );
    }
}
