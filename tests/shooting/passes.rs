//! Solves by passes: links of many cells at once, what cells exchange, what texels collect.

use common::cover::sampled;
use common::energy::Energy;
use common::mesh::Mesh;
use common::passes::{self, Closure};
use common::passes::{Engine, Exchange};
use common::scene::Scene;
use common::settings::{
    Iteration, Meshing, Projection, Raster, Schedule, Settings, Transport, Visibility,
};
use common::shooting::{Field, Run, Shoot};
use cpu::CpuSolver;
use cpu::twin::accumulate::settle;
use cpu::twin::received::received;
use glam::Vec3;
use gpu::{Fault, Gpu, GpuSolver};
use radiosity_tests::bounds::U;
use radiosity_tests::engines::{drawn, gpu};
use radiosity_tests::{box_in_room, lit_room};
use std::ops::ControlFlow;

fn settings(visibility: Visibility) -> Settings {
    Settings {
        meshing: Meshing {
            texels: 6,
            cells: 2,
            samples: 3,
        },
        transport: Transport {
            visibility,
            ..Transport::default()
        },
        schedule: Schedule {
            epsilon: 1e-4,
            iteration: Iteration::Cg,
            ..Schedule::default()
        },
        ..Settings::default()
    }
}

fn mesh(scene: &Scene, settings: &Settings) -> Mesh {
    sampled(scene, &settings.meshing).unwrap()
}

fn all(mesh: &Mesh) -> Vec<u32> {
    (0..mesh.cells.len() as u32).collect()
}

fn link(engine: &mut dyn Engine, cells: &[u32]) -> Vec<Closure> {
    (engine.link(cells, &mut |_| ControlFlow::Continue(()))).unwrap()
}

fn solve(engine: &mut dyn Engine, mesh: &Mesh, settings: &Settings) -> Run {
    passes::solve(engine, mesh, &settings.schedule, &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap()
}

/// A different colour of each cell, of either sign; every fifth shoots nothing.
fn colours(count: usize) -> Vec<Vec3> {
    let colour = |k: usize| {
        let x = (k * 37 % 101) as f32 / 101.0;
        Vec3::new(1.0 + x, 0.3 - x, x * x)
    };
    (0..count)
        .map(|k| if k % 5 == 3 { Vec3::ZERO } else { colour(k) })
        .collect()
}

/// The links of every cell as single shots make them, and what each says of its sums.
fn single_links(engine: &mut GpuSolver, mesh: &Mesh) -> (Vec<Vec<f32>>, Vec<Closure>) {
    let one = |cell| {
        let shot = engine.shoot(cell).unwrap();
        let links = engine.irradiance().unwrap().iter().map(|h| h.w).collect();
        let closure = Closure {
            form_factor_sum: shot.form_factor_sum,
            escaped: shot.escaped,
        };
        (links, closure)
    };
    all(mesh).into_iter().map(one).unzip()
}

/// What f32 sums of `n` products may differ by where products and sums are fused: software
/// adapters fuse nothing.
fn fused(gpu: &Gpu, n: usize, sum_of_terms: f64) -> f64 {
    if gpu.line.software {
        0.0
    } else {
        2.0 * (n as f64 + 1.0) * U * sum_of_terms
    }
}

fn close(a: Vec3, b: Vec3, bound: f64) -> bool {
    f64::from((a - b).abs().max_element()) <= bound
}

/// Σ x·w, cell after cell.
fn sum(shot: &[Vec3], link: impl Fn(usize) -> f32) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for (i, x) in shot.iter().enumerate() {
        if *x != Vec3::ZERO {
            sum += *x * link(i);
        }
    }
    sum
}

/// The engine's exchange and field against the twins on the links of single shots.
fn against_twins(gpu: &Gpu, mesh: &Mesh, engine: &mut GpuSolver, links: &[Vec<f32>]) -> bool {
    let shot = colours(mesh.cells.len());
    let unshot: Vec<Vec3> = shot.iter().rev().copied().collect();
    let terms = |w: &dyn Fn(usize) -> f32| {
        let sum = shot.iter().enumerate().map(|(i, x)| (*x * w(i)).abs());
        f64::from(sum.sum::<Vec3>().max_element())
    };
    let flux = engine.exchange(&shot).unwrap();
    let exchanged = mesh.cells.iter().zip(&flux).all(|(cell, flux)| {
        let taken: Vec<f32> = links.iter().map(|row| received(mesh, row, cell)).collect();
        let bound = fused(gpu, taken.len(), terms(&|i| taken[i]));
        close(*flux, sum(&shot, |i| taken[i]), bound)
    });
    engine.gather(&shot, &unshot).unwrap();
    let field = engine.field().unwrap();
    let collected = mesh.texels.iter().enumerate().all(|(k, texel)| {
        let h = sum(&shot, |i| links[i][k]);
        let bound = fused(gpu, links.len(), terms(&|i| links[i][k]));
        let b = settle(texel, texel.reflectance, h);
        close(field.irradiance[k].truncate(), h, bound)
            && close(field.radiosity[k].truncate(), b, 2.0 * bound)
    });
    let settled = mesh.cells.iter().zip(&unshot).all(|(cell, unshot)| {
        let texels = &field.residual[cell.texels()];
        texels.iter().all(|r| r.truncate() == *unshot)
    });
    exchanged && collected && settled
}

#[test]
fn many_cells_at_once_are_single_shots_and_the_twins() {
    let gpu = gpu();
    let tessellated = Projection::Hemisphere(Raster::Tessellated);
    let kinds = [
        settings(Visibility::Rays),
        settings(drawn(128)),
        settings(Visibility::drawn(Projection::Hemicube, 128)),
        settings(Visibility::drawn(tessellated, 128)),
    ];
    for settings in kinds {
        let mesh = mesh(&box_in_room(), &settings);
        let mut single = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
        let (links, closures) = single_links(&mut single, &mesh);
        let mut engine = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
        assert!(engine.has_room());
        assert_eq!(link(&mut engine, &all(&mesh)), closures, "{settings:?}");
        assert!(
            against_twins(&gpu, &mesh, &mut engine, &links),
            "{settings:?}"
        );
        // A second time, in another order, nothing changes.
        let reverse: Vec<u32> = all(&mesh).into_iter().rev().collect();
        let mut again = link(&mut engine, &reverse);
        again.reverse();
        assert_eq!(again, closures);
        assert!(against_twins(&gpu, &mesh, &mut engine, &links));
    }
}

#[test]
fn links_beyond_the_budget_are_made_again() {
    let gpu = gpu();
    let settings = settings(Visibility::Rays);
    let mesh = mesh(&box_in_room(), &settings);
    let row = 4 * mesh.texels.len() as u64;
    let cells = mesh.cells.len() as u64;
    // Seven rows; what cells exchange takes more than five.
    assert!(4 * cells * cells <= 7 * row && 4 * cells * cells > 5 * row);
    let small =
        |rows| GpuSolver::with_budget(&gpu, &mesh, &settings.transport, &[], rows * row).unwrap();
    let mut single = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
    let (links, closures) = single_links(&mut single, &mesh);
    let mut engine = small(7);
    assert!(engine.has_room());
    assert_eq!(link(&mut engine, &all(&mesh)), closures);
    assert!(against_twins(&gpu, &mesh, &mut engine, &links));
    // A single shot in between takes a place.
    engine.shoot(3).unwrap();
    assert!(against_twins(&gpu, &mesh, &mut engine, &links));
    assert!(!small(5).has_room());
    assert!(
        small(5)
            .link(&[0], &mut |_| ControlFlow::Continue(()))
            .is_err()
    );
}

#[test]
fn a_wrong_pass_is_noticed() {
    let gpu = gpu();
    let settings = settings(drawn(128));
    let mesh = mesh(&box_in_room(), &settings);
    let mut single = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
    let (links, _) = single_links(&mut single, &mesh);
    let wrong = |file, from, to| {
        let fault = [Fault { file, from, to }];
        let mut engine = GpuSolver::with_faults(&gpu, &mesh, &settings.transport, &fault).unwrap();
        link(&mut engine, &all(&mesh));
        !against_twins(&gpu, &mesh, &mut engine, &links)
    };
    let faults = [
        ("exchange", "var i = 0u;", "var i = 1u;"),
        ("exchange", "sum += x", "sum = x"),
        ("exchange", "i * params.cells + c", "c * params.cells + i"),
        (
            "collect",
            "var i = params.first;",
            "var i = params.first + 1u;",
        ),
        ("collect", "i < params.end", "i + 1u < params.end"),
        ("collect", "i % params.places", "(i + 1u) % params.places"),
        ("collect", "radiosity[k].xyz + reflected", "reflected"),
        ("received", "shots[slot].taken + cell", "cell"),
        (
            "link",
            "shots[slot].place * params.texels",
            "slot * params.texels",
        ),
        ("link", "let at = slot * params.texels + k;", "let at = k;"),
        ("lookup", "vec2i(tile()) * i32(SIZE)", "vec2i(0)"),
        ("projection", "slot / params.tiles", "0u"),
        (
            "aim",
            "slot = group.z;\n    draw(select",
            "slot = 0u;\n    draw(select",
        ),
    ];
    for (file, from, to) in faults {
        assert!(wrong(file, from, to), "{file}, {to} was not noticed");
    }
}

#[test]
fn what_the_device_does_not_write_is_an_error() {
    let gpu = gpu();
    let settings = settings(Visibility::Rays);
    let mesh = mesh(&box_in_room(), &settings);
    let failing = |file, from, to| {
        let fault = [Fault { file, from, to }];
        let mut engine = GpuSolver::with_faults(&gpu, &mesh, &settings.transport, &fault).unwrap();
        passes::solve(&mut engine, &mesh, &settings.schedule, &mut |_| {
            ControlFlow::Continue(())
        })
        .is_err()
    };
    let (from, to) = ("if c >= params.cells", "if c >= params.cells - 1u");
    assert!(failing("exchange", from, to));
    assert!(failing("closure", "slot = group.z;", "slot = 0u;"));
    let sum = "shots[slot].sum = rows[shots[slot].place].sum;";
    assert!(failing("closure", sum, ""));
}

/// Σ A|B − B′| over texels and channels.
fn apart(mesh: &Mesh, a: &Field, b: &Field) -> f64 {
    (0..mesh.texels.len())
        .map(|k| {
            let d = (a.radiosity[k] - b.radiosity[k]).truncate().abs();
            f64::from(d.element_sum() * mesh.texels[k].area)
        })
        .sum()
}

fn unshot(mesh: &Mesh, run: &Run) -> f64 {
    let residual = mesh.texels.iter().zip(&run.field.residual);
    residual
        .map(|(texel, r)| f64::from(r.truncate().abs().element_sum() * texel.area))
        .sum()
}

#[test]
fn every_iteration_ends_at_southwells_answer() {
    let gpu = gpu();
    let scene = lit_room();
    for visibility in [Visibility::Rays, drawn(128)] {
        let mut settings = settings(visibility);
        let mesh = mesh(&scene, &settings);
        let largest = mesh.texels.iter().map(|t| t.reflectance.max_element());
        let rho = f64::from(largest.fold(0.0, f32::max));
        settings.schedule.iteration = Iteration::Southwell;
        let mut engine = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
        let southwell = solve(&mut engine, &mesh, &settings);
        assert!(southwell.converged);
        for iteration in [Iteration::Chebyshev, Iteration::Cg] {
            settings.schedule.iteration = iteration;
            let mut engine = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
            let run = solve(&mut engine, &mesh, &settings);
            assert!(run.converged, "{iteration:?}");
            // What is unshot is yet to be reflected, ρ of it at each of 1/(1 − ρ) times; links may
            // sum to some per cent more than 1. Each sum is rounded at each shot.
            let left = 1.1 * rho / (1.0 - rho) * (unshot(&mesh, &run) + unshot(&mesh, &southwell));
            let shots = (southwell.shooters + mesh.cells.len() as u64) as f64;
            let rounding = 4.0 * U * shots * f64::from(southwell.emitted) / (1.0 - rho);
            let found = apart(&mesh, &run.field, &southwell.field);
            println!("{visibility:?} {iteration:?}: {found:.1e} of {left:.1e}");
            assert!(found <= left + rounding, "{iteration:?}: {found} > {left}");
        }
    }
}

/// Links by rays are the same bits on both, and so are all passes.
#[test]
fn the_passes_of_the_gpu_are_those_of_the_cpu() {
    let gpu = gpu();
    for iteration in [Iteration::Cg, Iteration::Chebyshev] {
        let mut settings = settings(Visibility::Rays);
        settings.schedule.iteration = iteration;
        let mesh = mesh(&lit_room(), &settings);
        let cpu = solve(
            &mut CpuSolver::new(&mesh, &settings.transport),
            &mesh,
            &settings,
        );
        let mut engine = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
        let gpu_run = solve(&mut engine, &mesh, &settings);
        if gpu.line.software {
            assert_eq!(cpu.shots, gpu_run.shots, "{iteration:?}");
            assert_eq!(cpu.field.radiosity, gpu_run.field.radiosity);
            assert_eq!(cpu.field.residual, gpu_run.field.residual);
            assert_eq!(cpu.field.irradiance, gpu_run.field.irradiance);
        } else {
            let bound = 10.0 * settings.schedule.epsilon * f64::from(cpu.emitted);
            assert!(apart(&mesh, &cpu.field, &gpu_run.field) <= bound);
        }
    }
}

#[test]
fn few_numbers_cross_the_bus() {
    let settings = settings(Visibility::Rays);
    let mesh = mesh(&lit_room(), &settings);
    let mut engine = GpuSolver::new(&gpu(), &mesh, &settings.transport).unwrap();
    let run = solve(&mut engine, &mesh, &settings);
    let counts = engine.counts();
    // A read-back a pass, one for each batch of links, the field.
    let batches = mesh.cells.len() as u32 / 8 + 2 * run.passes;
    assert!(counts.maps <= run.passes + batches + 1, "{counts:?}");
}

#[test]
fn a_solve_that_is_stopped_while_it_links_keeps_its_balance() {
    let gpu = gpu();
    for visibility in [Visibility::Rays, drawn(128)] {
        let settings = settings(visibility);
        let mesh = mesh(&lit_room(), &settings);
        let engines: [Box<dyn Engine>; 2] = [
            Box::new(CpuSolver::new(&mesh, &settings.transport)),
            Box::new(GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap()),
        ];
        for mut engine in engines {
            for stop in [1, 3, 30] {
                let mut told = 0;
                let run = passes::solve(engine.as_mut(), &mesh, &settings.schedule, &mut |_| {
                    told += 1;
                    if told < stop {
                        ControlFlow::Continue(())
                    } else {
                        ControlFlow::Break(())
                    }
                })
                .unwrap();
                assert!(!run.converged && told >= stop);
                let energy = Energy::new(&mesh, &run.field, &run.shots);
                // As many roundings as cells in H, and as texels in a sum; some are two.
                let bound = 4.0 * (mesh.cells.len() + 64) as f64 * U;
                assert!(energy.imbalance <= bound, "{stop}: {energy:?}");
            }
            let mut told = Vec::new();
            let closures = engine
                .link(&all(&mesh), &mut |made| {
                    told.push(made);
                    ControlFlow::Break(())
                })
                .unwrap();
            // Two batches of eight may be under way, or eight cells of each thread.
            let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
            assert!((1..=8 * threads.max(2)).contains(&closures.len()));
            assert_eq!(told, (1..=closures.len()).collect::<Vec<_>>());
        }
    }
}
