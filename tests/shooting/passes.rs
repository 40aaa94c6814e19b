//! Solves by passes on the GPU: links of many patches at once, transfer between patches, gathering by
//! texels.

use common::cover::sampled_mesh;
use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::passes::{self, PatchClosure};
use common::passes::{Engine, Exchange};
use common::scene::Scene;
use common::settings::{ItemBufferProjection, Iteration, Meshing, Raster, Schedule, Settings, Transport, Visibility};
use common::shooting::{RadiosityField, Shoot, SolveRun};
use cpu::CpuSolver;
use cpu::shader_twins::gather::update_radiosity;
use cpu::shader_twins::patch_transfer::patch_transfer;
use glam::Vec3;
use gpu::{Gpu, GpuSolver};
use radiosity_tests::bounds::U;
use radiosity_tests::engines::{item_buffer, open_gpu};
use radiosity_tests::shader_faults::{assert_faults_noticed, shader_fault};
use radiosity_tests::{box_in_room, lit_room};
use std::ops::ControlFlow;

fn settings(visibility: Visibility) -> Settings {
    Settings {
        meshing: Meshing {
            texels: 6,
            patches: 2,
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
    sampled_mesh(scene, &settings.meshing).unwrap()
}

fn all_patches(mesh: &Mesh) -> Vec<u32> {
    (0..mesh.patches.len() as u32).collect()
}

fn make_links(engine: &mut dyn Engine, patches: &[u32]) -> Vec<PatchClosure> {
    (engine.make_links(patches, &mut |_| ControlFlow::Continue(()))).unwrap()
}

fn solve(engine: &mut dyn Engine, mesh: &Mesh, settings: &Settings) -> SolveRun {
    passes::solve_by_schedule(engine, mesh, &settings.schedule, &mut |_| ControlFlow::Continue(())).unwrap()
}

/// Returns a different colour for each patch, with both signs; every fifth is 0.
fn colours(count: usize) -> Vec<Vec3> {
    let colour = |k: usize| {
        let x = (k * 37 % 101) as f32 / 101.0;
        Vec3::new(1.0 + x, 0.3 - x, x * x)
    };
    (0..count)
        .map(|k| if k % 5 == 3 { Vec3::ZERO } else { colour(k) })
        .collect()
}

/// Returns the links of every patch by single shots, and their closures.
fn single_links(engine: &mut GpuSolver, mesh: &Mesh) -> (Vec<Vec<f32>>, Vec<PatchClosure>) {
    let one = |patch| {
        let shot = engine.shoot(patch).unwrap();
        let links = engine.read_irradiance().unwrap().iter().map(|h| h.w).collect();
        let closure = PatchClosure {
            form_factor_sum: shot.form_factor_sum,
            escaped: shot.escaped,
        };
        (links, closure)
    };
    all_patches(mesh).into_iter().map(one).unzip()
}

/// Returns the bound on the difference of f32 sums of `n` products with and without fused multiply-adds;
/// software adapters do not fuse.
fn fusing_bound(gpu: &Gpu, n: usize, sum_of_terms: f64) -> f64 {
    if gpu.line.software {
        0.0
    } else {
        2.0 * (n as f64 + 1.0) * U * sum_of_terms
    }
}

fn close(a: Vec3, b: Vec3, bound: f64) -> bool {
    f64::from((a - b).abs().max_element()) <= bound
}

/// Returns Σ x·w in the order of the patches.
fn sum(shot: &[Vec3], link: impl Fn(usize) -> f32) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for (i, x) in shot.iter().enumerate() {
        if *x != Vec3::ZERO {
            sum += *x * link(i);
        }
    }
    sum
}

/// Compares the engine's exchange and field with the twins on the links of single shots.
fn equals_twins(gpu: &Gpu, mesh: &Mesh, engine: &mut GpuSolver, links: &[Vec<f32>]) -> bool {
    let shot = colours(mesh.patches.len());
    let unshot: Vec<Vec3> = shot.iter().rev().copied().collect();
    let terms = |w: &dyn Fn(usize) -> f32| {
        let sum = shot.iter().enumerate().map(|(i, x)| (*x * w(i)).abs());
        f64::from(sum.sum::<Vec3>().max_element())
    };
    let flux = engine.exchange_flux(&shot).unwrap();
    let exchanged = mesh.patches.iter().zip(&flux).all(|(patch, flux)| {
        let taken: Vec<f32> = links.iter().map(|row| patch_transfer(mesh, row, patch)).collect();
        let bound = fusing_bound(gpu, taken.len(), terms(&|i| taken[i]));
        close(*flux, sum(&shot, |i| taken[i]), bound)
    });
    engine.gather_field(&shot, &unshot).unwrap();
    let field = engine.read_field().unwrap();
    let collected = mesh.texels.iter().enumerate().all(|(k, texel)| {
        let h = sum(&shot, |i| links[i][k]);
        let bound = fusing_bound(gpu, links.len(), terms(&|i| links[i][k]));
        let b = update_radiosity(texel, texel.reflectance, h);
        close(field.irradiance[k].truncate(), h, bound) && close(field.radiosity[k].truncate(), b, 2.0 * bound)
    });
    let settled = mesh.patches.iter().zip(&unshot).all(|(patch, unshot)| {
        let texels = &field.residual[patch.texels()];
        texels.iter().all(|r| r.truncate() == *unshot)
    });
    exchanged && collected && settled
}

#[test]
fn links_of_many_patches_equal_single_shots_and_twins() {
    let gpu = open_gpu();
    let tessellated = ItemBufferProjection::Hemisphere(Raster::Tessellated);
    let kinds = [
        settings(Visibility::Rays),
        settings(item_buffer(128)),
        settings(Visibility::with_item_buffer(ItemBufferProjection::Hemicube, 128)),
        settings(Visibility::with_item_buffer(tessellated, 128)),
    ];
    for settings in kinds {
        let mesh = mesh(&box_in_room(), &settings);
        let mut single = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
        let (links, closures) = single_links(&mut single, &mesh);
        let mut engine = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
        assert!(engine.has_room());
        assert_eq!(make_links(&mut engine, &all_patches(&mesh)), closures, "{settings:?}");
        assert!(equals_twins(&gpu, &mesh, &mut engine, &links), "{settings:?}");
        // A second time, in another order, the results are the same.
        let reverse: Vec<u32> = all_patches(&mesh).into_iter().rev().collect();
        let mut again = make_links(&mut engine, &reverse);
        again.reverse();
        assert_eq!(again, closures);
        assert!(equals_twins(&gpu, &mesh, &mut engine, &links));
    }
}

#[test]
fn links_beyond_the_memory_budget_are_recomputed() {
    let gpu = open_gpu();
    let settings = settings(Visibility::Rays);
    let mesh = mesh(&box_in_room(), &settings);
    let row = 4 * mesh.texels.len() as u64;
    let patches = mesh.patches.len() as u64;
    // Seven rows; the transfer between patches takes more than five.
    assert!(4 * patches * patches <= 7 * row && 4 * patches * patches > 5 * row);
    let small = |rows| GpuSolver::with_budget(&gpu, &mesh, &settings.transport, &[], rows * row).unwrap();
    let mut single = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
    let (links, closures) = single_links(&mut single, &mesh);
    let mut engine = small(7);
    assert!(engine.has_room());
    assert_eq!(make_links(&mut engine, &all_patches(&mesh)), closures);
    assert!(equals_twins(&gpu, &mesh, &mut engine, &links));
    // A single shot in between takes a row.
    engine.shoot(3).unwrap();
    assert!(equals_twins(&gpu, &mesh, &mut engine, &links));
    assert!(!small(5).has_room());
    assert!(small(5).make_links(&[0], &mut |_| ControlFlow::Continue(())).is_err());
}

#[test]
fn comparison_with_twins_detects_faults_in_passes() {
    let gpu = open_gpu();
    let settings = settings(item_buffer(128));
    let mesh = mesh(&box_in_room(), &settings);
    let mut single = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
    let (links, _) = single_links(&mut single, &mesh);
    let is_noticed = |fault| {
        let mut engine = GpuSolver::with_faults(&gpu, &mesh, &settings.transport, &[fault]).unwrap();
        make_links(&mut engine, &all_patches(&mesh));
        !equals_twins(&gpu, &mesh, &mut engine, &links)
    };
    let faults = [
        ("exchange", "var i = 0u;", "var i = 1u;"),
        ("exchange", "sum += x", "sum = x"),
        ("exchange", "i * params.patches + c", "c * params.patches + i"),
        ("gather", "var i = params.first;", "var i = params.first + 1u;"),
        ("gather", "i < params.end", "i + 1u < params.end"),
        ("gather", "i % params.places", "(i + 1u) % params.places"),
        ("gather", "radiosity[k].xyz + reflected", "reflected"),
        (
            "patch_transfer",
            "shots[slot].transfer_start + patch_index",
            "patch_index",
        ),
        ("link", "shots[slot].place * params.texels", "slot * params.texels"),
        ("link", "let at = slot * params.texels + k;", "let at = k;"),
        ("lookup", "vec2i(tile_index()) * i32(IMAGE_SIZE)", "vec2i(0)"),
        ("projection", "slot / params.tiles", "0u"),
        (
            "view",
            "slot = group.z;\n    select_faces(select",
            "slot = 0u;\n    select_faces(select",
        ),
    ];
    let faults = faults.map(|(file, from, to)| shader_fault(file, from, to));
    assert_faults_noticed(faults, is_noticed);
}

#[test]
fn unwritten_device_result_is_an_error() {
    let gpu = open_gpu();
    let settings = settings(Visibility::Rays);
    let mesh = mesh(&box_in_room(), &settings);
    let failing = |file, from, to| {
        let fault = [shader_fault(file, from, to)];
        let mut engine = GpuSolver::with_faults(&gpu, &mesh, &settings.transport, &fault).unwrap();
        passes::solve_by_schedule(&mut engine, &mesh, &settings.schedule, &mut |_| {
            ControlFlow::Continue(())
        })
        .is_err()
    };
    let (from, to) = ("if c >= params.patches", "if c >= params.patches - 1u");
    assert!(failing("exchange", from, to));
    assert!(failing("closure", "slot = group.z;", "slot = 0u;"));
    let sum = "shots[slot].sum = rows[shots[slot].place].sum;";
    assert!(failing("closure", sum, ""));
}

/// Σ A|B − B′| over texels and channels.
fn area_difference(mesh: &Mesh, a: &RadiosityField, b: &RadiosityField) -> f64 {
    (0..mesh.texels.len())
        .map(|k| {
            let d = (a.radiosity[k] - b.radiosity[k]).truncate().abs();
            f64::from(d.element_sum() * mesh.texels[k].area)
        })
        .sum()
}

fn unshot(mesh: &Mesh, run: &SolveRun) -> f64 {
    let residual = mesh.texels.iter().zip(&run.field.residual);
    residual
        .map(|(texel, r)| f64::from(r.truncate().abs().element_sum() * texel.area))
        .sum()
}

#[test]
fn every_iteration_converges_to_the_southwell_solution() {
    let gpu = open_gpu();
    let scene = lit_room();
    for visibility in [Visibility::Rays, item_buffer(128)] {
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
            // Unshot light would add ρ/(1 − ρ) times itself; links may sum to some per cent more than 1.
            // Each sum is rounded at each shot.
            let left = 1.1 * rho / (1.0 - rho) * (unshot(&mesh, &run) + unshot(&mesh, &southwell));
            let shots = (southwell.shooters + mesh.patches.len() as u64) as f64;
            let rounding = 4.0 * U * shots * f64::from(southwell.emitted) / (1.0 - rho);
            let found = area_difference(&mesh, &run.field, &southwell.field);
            println!("{visibility:?} {iteration:?}: {found:.1e} of {left:.1e}");
            assert!(found <= left + rounding, "{iteration:?}: {found} > {left}");
        }
    }
}

/// Links by rays are bit-identical on both, and so are all passes.
#[test]
fn gpu_passes_equal_cpu_passes() {
    let gpu = open_gpu();
    for iteration in [Iteration::Cg, Iteration::Chebyshev] {
        let mut settings = settings(Visibility::Rays);
        settings.schedule.iteration = iteration;
        let mesh = mesh(&lit_room(), &settings);
        let cpu = solve(&mut CpuSolver::new(&mesh, &settings.transport), &mesh, &settings);
        let mut engine = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
        let gpu_run = solve(&mut engine, &mesh, &settings);
        if gpu.line.software {
            assert_eq!(cpu.shots, gpu_run.shots, "{iteration:?}");
            assert_eq!(cpu.field.radiosity, gpu_run.field.radiosity);
            assert_eq!(cpu.field.residual, gpu_run.field.residual);
            assert_eq!(cpu.field.irradiance, gpu_run.field.irradiance);
        } else {
            let bound = 10.0 * settings.schedule.epsilon * f64::from(cpu.emitted);
            assert!(area_difference(&mesh, &cpu.field, &gpu_run.field) <= bound);
        }
    }
}

#[test]
fn solve_reads_back_once_per_pass_and_batch() {
    let settings = settings(Visibility::Rays);
    let mesh = mesh(&lit_room(), &settings);
    let mut engine = GpuSolver::new(&open_gpu(), &mesh, &settings.transport).unwrap();
    let run = solve(&mut engine, &mesh, &settings);
    let counts = engine.queue_counts();
    // One read-back per pass, one per batch of links, one of the field.
    let batches = mesh.patches.len() as u32 / 8 + 2 * run.passes;
    assert!(counts.maps <= run.passes + batches + 1, "{counts:?}");
}

#[test]
fn solve_stopped_during_linking_keeps_its_energy_balance() {
    let gpu = open_gpu();
    for visibility in [Visibility::Rays, item_buffer(128)] {
        let settings = settings(visibility);
        let mesh = mesh(&lit_room(), &settings);
        let engines: [Box<dyn Engine>; 2] = [
            Box::new(CpuSolver::new(&mesh, &settings.transport)),
            Box::new(GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap()),
        ];
        for mut engine in engines {
            for stop in [1, 3, 30] {
                let mut reported = 0;
                let run = passes::solve_by_schedule(engine.as_mut(), &mesh, &settings.schedule, &mut |_| {
                    reported += 1;
                    if reported < stop {
                        ControlFlow::Continue(())
                    } else {
                        ControlFlow::Break(())
                    }
                })
                .unwrap();
                assert!(!run.converged && reported >= stop);
                let energy = EnergyBalance::new(&mesh, &run.field, &run.shots);
                // Roundings: one per patch in H, one per texel in a sum; some are two.
                let bound = 4.0 * (mesh.patches.len() + 64) as f64 * U;
                assert!(energy.imbalance <= bound, "{stop}: {energy:?}");
            }
            let mut reported = Vec::new();
            let closures = engine
                .make_links(&all_patches(&mesh), &mut |made| {
                    reported.push(made);
                    ControlFlow::Break(())
                })
                .unwrap();
            // Two batches of eight patches may be under way, or eight patches per thread.
            let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
            assert!((1..=8 * threads.max(2)).contains(&closures.len()));
            assert_eq!(reported, (1..=closures.len()).collect::<Vec<_>>());
        }
    }
}
