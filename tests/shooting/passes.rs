//! Solves by passes on the GPU: links of many patches at once, transfer between patches, gathering by
//! texels.

use common::mesh::Mesh;
use common::passes::{self, Exchange, PatchClosure};
use common::settings::{ItemBufferProjection, Iteration, Settings, Visibility};
use common::shooting::Shoot;
use cpu::shader_twins::gather::update_radiosity;
use cpu::shader_twins::patch_transfer::patch_transfer;
use glam::Vec3;
use gpu::{GpuSolver, ShaderFault};
use radiosity_tests::bounds::U;
use radiosity_tests::engines::{
    all_patches, gpu_solver, hemicube, item_buffer, make_links, mesh_scene, settings_of, shared_gpu, solve_by_schedule,
};
use radiosity_tests::shader_faults::assert_faults_noticed;
use radiosity_tests::{box_in_room, lit_room};
use std::ops::ControlFlow;

fn settings(visibility: Visibility) -> Settings {
    let mut settings = settings_of([6, 2, 3], visibility, 1e-4);
    settings.schedule.iteration = Iteration::Cg;
    settings
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
fn fusing_bound(n: usize, sum_of_terms: f64) -> f64 {
    if shared_gpu().line.software {
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
fn equals_twins(mesh: &Mesh, engine: &mut GpuSolver, links: &[Vec<f32>]) -> bool {
    let shot = colours(mesh.patches.len());
    let unshot: Vec<Vec3> = shot.iter().rev().copied().collect();
    let terms = |w: &dyn Fn(usize) -> f32| {
        let sum = shot.iter().enumerate().map(|(i, x)| (*x * w(i)).abs());
        f64::from(sum.sum::<Vec3>().max_element())
    };
    let flux = engine.exchange_flux(&shot).unwrap();
    let exchanged = mesh.patches.iter().zip(&flux).all(|(patch, flux)| {
        let taken: Vec<f32> = links.iter().map(|row| patch_transfer(mesh, row, patch)).collect();
        let bound = fusing_bound(taken.len(), terms(&|i| taken[i]));
        close(*flux, sum(&shot, |i| taken[i]), bound)
    });
    engine.gather_field(&shot, &unshot).unwrap();
    let field = engine.read_field().unwrap();
    let collected = mesh.texels.iter().enumerate().all(|(k, texel)| {
        let h = sum(&shot, |i| links[i][k]);
        let bound = fusing_bound(links.len(), terms(&|i| links[i][k]));
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
    let kinds = [
        settings(Visibility::Rays),
        settings(item_buffer(128)),
        settings(hemicube(128)),
        settings(Visibility::with_item_buffer(ItemBufferProjection::Paper, 128)),
    ];
    for settings in kinds {
        let mesh = mesh_scene(&box_in_room(), &settings);
        let mut single = gpu_solver(&mesh, &settings.transport, &[]);
        let (links, closures) = single_links(&mut single, &mesh);
        let mut engine = gpu_solver(&mesh, &settings.transport, &[]);
        assert!(engine.transfer_fits());
        assert_eq!(make_links(&mut engine, &all_patches(&mesh)), closures, "{settings:?}");
        assert!(equals_twins(&mesh, &mut engine, &links), "{settings:?}");
        // A second time, in another order, the results are the same.
        let reverse: Vec<u32> = all_patches(&mesh).into_iter().rev().collect();
        let mut again = make_links(&mut engine, &reverse);
        again.reverse();
        assert_eq!(again, closures);
        assert!(equals_twins(&mesh, &mut engine, &links));
    }
}

#[test]
fn links_beyond_the_memory_budget_are_recomputed() {
    let settings = settings(Visibility::Rays);
    let mesh = mesh_scene(&box_in_room(), &settings);
    let row = 4 * mesh.texels.len() as u64;
    let patches = mesh.patches.len() as u64;
    // Seven rows; the transfer between patches takes more than five.
    assert!(4 * patches * patches <= 7 * row && 4 * patches * patches > 5 * row);
    let small = |rows| GpuSolver::with_budget(shared_gpu(), &mesh, &settings.transport, &[], rows * row).unwrap();
    let mut single = gpu_solver(&mesh, &settings.transport, &[]);
    let (links, closures) = single_links(&mut single, &mesh);
    let mut engine = small(7);
    assert!(engine.transfer_fits());
    assert_eq!(make_links(&mut engine, &all_patches(&mesh)), closures);
    assert!(equals_twins(&mesh, &mut engine, &links));
    // A single shot in between takes a row.
    engine.shoot(3).unwrap();
    assert!(equals_twins(&mesh, &mut engine, &links));
    assert!(!small(5).transfer_fits());
    assert!(small(5).make_links(&[0], &mut |_| ControlFlow::Continue(())).is_err());
}

#[test]
fn comparison_with_twins_detects_faults_in_passes() {
    let settings = settings(item_buffer(128));
    let mesh = mesh_scene(&box_in_room(), &settings);
    let (links, _) = single_links(&mut gpu_solver(&mesh, &settings.transport, &[]), &mesh);
    assert_faults_noticed("passes", |faults| {
        let mut engine = gpu_solver(&mesh, &settings.transport, faults);
        make_links(&mut engine, &all_patches(&mesh));
        let differs = !equals_twins(&mesh, &mut engine, &links);
        Vec::from_iter(differs.then(|| "differs".to_owned()))
    });
}

#[test]
fn unwritten_device_result_is_an_error() {
    let settings = settings(Visibility::Rays);
    let mesh = mesh_scene(&box_in_room(), &settings);
    for (file, from, to) in [
        ("exchange", "if c >= params.patches", "if c >= params.patches - 1u"),
        ("closure", "slot = group.z;", "slot = 0u;"),
        ("closure", "shots[slot].sum = rows[shots[slot].place].sum;", ""),
    ] {
        let mut engine = gpu_solver(&mesh, &settings.transport, &[ShaderFault { file, from, to }]);
        let go_on = &mut |_| ControlFlow::Continue(());
        let solved = passes::solve_by_schedule(&mut engine, &mesh, &settings.schedule, go_on);
        assert!(solved.is_err(), "{file}: {from}");
    }
}

#[test]
fn solve_reads_back_once_per_pass_and_batch() {
    let settings = settings(Visibility::Rays);
    let mesh = mesh_scene(&lit_room(), &settings);
    let mut engine = gpu_solver(&mesh, &settings.transport, &[]);
    let run = solve_by_schedule(&mut engine, &mesh, &settings.schedule);
    let counts = engine.queue_counts();
    // One read-back per pass, one per batch of links, one of the field.
    let batches = mesh.patches.len() as u32 / 8 + 2 * run.passes;
    assert!(counts.maps <= run.passes + batches + 1, "{counts:?}");
}
