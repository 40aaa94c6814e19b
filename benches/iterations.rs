//! Every iteration to 1 % in a cube with 5×5 patches per wall, of which the centre patch of one wall
//! emits, with all visibility known beforehand: passes, shots, and time over Southwell's.

use common::mesh::Mesh;
use common::passes::Exchange;
use common::scene::{Face, Scene};
use common::settings::{Iteration, Schedule, Settings};
use common::shooting::Run;
use common::texel;
use cpu::CpuSolver;
use glam::{DVec3, Vec3};
use radiosity_benches::accuracy::{Target, run};
use radiosity_benches::whole_faces;
use radiosity_tests::room;
use std::ops::ControlFlow;
use std::time::Instant;

const SIDE: u32 = 5;
const BOUND: f64 = 0.01;
const ROUNDS: usize = 7;
const ALL: [Iteration; 3] = [Iteration::Southwell, Iteration::Chebyshev, Iteration::Cg];

fn main() {
    for texels in [1, 8, 32] {
        for reflectance in [0.5, 0.7, 0.9] {
            measure(texels, reflectance);
        }
    }
}

/// The cube.
fn cube(reflectance: f32) -> Scene {
    let grey = Vec3::splat(reflectance);
    let walls = room(DVec3::ZERO, DVec3::ONE, true, Vec3::ZERO, grey);
    let mut faces = Vec::new();
    for wall in &walls {
        for part in 0..SIDE * SIDE {
            let corners = texel::outline(wall, [SIDE, SIDE], part).padded();
            faces.push(Face::quad(&wall.name, corners, Vec3::ZERO, grey));
        }
    }
    faces[(SIDE * SIDE / 2) as usize].emission = Vec3::ONE;
    Scene {
        name: format!("cube, reflectance {reflectance}"),
        faces,
        notes: Vec::new(),
    }
}

fn measure(texels: u32, reflectance: f32) {
    let mesh = Mesh::uniform(&cube(reflectance), texels, 1).expect("the cube is sound");
    let target = Target::new(mesh, whole_faces(texels));
    let settings = ALL.map(|iteration| match iteration {
        Iteration::Southwell => Settings {
            schedule: Schedule {
                iteration,
                epsilon: 0.0,
                max_shots: target.southwell_shots(BOUND).len() as u32,
            },
            ..target.settings
        },
        _ => {
            let mut of = target.clone();
            of.settings.schedule.iteration = iteration;
            of.settings_to(BOUND)
        }
    });
    let mut engine = CpuSolver::new(&target.mesh, &settings[0].transport);
    let all: Vec<u32> = (0..target.mesh.cells.len() as u32).collect();
    let linked = engine.link(&all, &mut |_| ControlFlow::Continue(()));
    linked.expect("the CPU links");
    let rounds: Vec<Vec<(f64, Run)>> = (0..ROUNDS)
        .map(|_| {
            let timed = settings.iter().map(|settings| {
                target.restart(&mut engine);
                let start = Instant::now();
                let run = run(&mut engine, &target.mesh, settings);
                (start.elapsed().as_secs_f64(), run)
            });
            timed.collect()
        })
        .collect();
    println!("reflectance {reflectance}, {texels}×{texels} texels a patch, to 1 %");
    for (k, iteration) in ALL.iter().enumerate() {
        let mut ratios: Vec<f64> = rounds.iter().map(|round| round[k].0 / round[0].0).collect();
        ratios.sort_by(f64::total_cmp);
        let (seconds, run) = &rounds[ROUNDS - 1][k];
        println!(
            "  {:<10} {:5} passes {:6} shots {:9.3} ms, over Southwell's {:.4} ({:.4}, {:.4}), error {:.2} %",
            format!("{iteration:?}"),
            run.passes,
            run.shooters,
            seconds * 1e3,
            ratios[ROUNDS / 2],
            ratios[0],
            ratios[ROUNDS - 1],
            100.0 * target.error(&run.field),
        );
    }
}
