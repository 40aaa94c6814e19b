//! Record of a solve: it changes nothing, and repeated by its own numbers it gives the solver's radiosity.

use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::shooting::{Shoot, SolveRun, shoot_until_converged};
use glam::DVec3;
use oracle::trace::ShotTrace;
use oracle::trace::packing::{HALF_ROUNDING, TexelLinks, TexelOrder};
use oracle::trace::recorder::{ShotRecorder, TraceLimits};
use radiosity_tests::engines::{each_engine, engine_settings, mesh_of, shoot_freely, shoot_on_cpu};
use radiosity_tests::lit_room;
use std::collections::HashMap;
use std::ops::ControlFlow;

const UNLIMITED: TraceLimits = TraceLimits {
    bytes: usize::MAX,
    links: usize::MAX,
};

/// Solves with a recorder in place.
fn record_solve(engine: &mut dyn Shoot, mesh: &Mesh, limits: TraceLimits) -> (SolveRun, ShotTrace) {
    let settings = engine_settings();
    let mut recorder = ShotRecorder::new(engine, mesh, &settings.transport, limits).unwrap();
    let run = shoot_until_converged(&mut recorder, &settings.schedule, &mut |_, _| ControlFlow::Continue(()));
    (run.unwrap(), recorder.into_trace())
}

/// Returns radiosity and residual after the recorded shots.
fn repeat_shots(mesh: &Mesh, trace: &ShotTrace) -> [Vec<DVec3>; 2] {
    let order = TexelOrder::new(mesh);
    let links = trace.links.iter().map(|own| (own.patch, own.unpack(&order).unwrap()));
    let links: HashMap<u32, TexelLinks> = links.collect();
    let initial = [&trace.initial.radiosity, &trace.initial.residual];
    let [mut radiosity, mut residual] =
        initial.map(|values| values.iter().map(|v| v.truncate().as_dvec3()).collect::<Vec<_>>());
    for traced in &trace.shots {
        let own = &links[&traced.shot.patch];
        for (at, k) in order.texels.iter().enumerate() {
            let link = f64::from(own.form_factors[at]) * f64::from(own.shares[at]);
            let change = mesh.texels[*k].reflectance.as_dvec3() * traced.radiosity.as_dvec3() * link;
            radiosity[*k] += change;
            residual[*k] += change;
        }
        residual[mesh.patches[traced.shot.patch as usize].texels()].fill(DVec3::ZERO);
    }
    [radiosity, residual]
}

/// Returns the largest difference of the repeated shots from the solver's field, over its bound. Form factor and share are
/// half floats: together they are off by twice the rounding and its square. The solver rounds each deposit to f32.
fn worst_over_bound(mesh: &Mesh, trace: &ShotTrace, run: &SolveRun) -> f64 {
    let halves = f64::from(HALF_ROUNDING);
    let roundings = run.shots.len() as f64 * f64::from(f32::EPSILON);
    let [radiosity, residual] = repeat_shots(mesh, trace);
    let mut worst: f64 = 0.0;
    for k in 0..mesh.texels.len() {
        let truth = run.field.radiosity[k].truncate().as_dvec3();
        let reflected = truth - mesh.texels[k].emission.as_dvec3();
        let bound = reflected * (2.0 * halves + halves * halves) + truth * roundings + DVec3::splat(1e-12);
        let unshot = run.field.residual[k].truncate().as_dvec3();
        for off in [radiosity[k] - truth, residual[k] - unshot] {
            worst = worst.max((off.abs() / bound).max_element());
        }
    }
    worst
}

#[test]
fn recorded_shots_repeat_the_solve_on_every_engine() {
    let mesh = mesh_of(&lit_room());
    each_engine(&mesh, |name, fresh| {
        let untraced = shoot_freely(&mut *fresh(), &engine_settings().schedule);
        let mut engine = fresh();
        let (run, mut trace) = record_solve(&mut *engine, &mesh, UNLIMITED);
        assert_eq!((&run.shots, &run.field), (&untraced.shots, &untraced.field), "{name}");
        assert!(trace.is_complete() && trace.shots.len() > 100, "{name}");
        for traced in &trace.shots {
            assert_eq!(traced.ranking[0].0, traced.shot.patch, "{name}");
            assert!(traced.ranking.is_sorted_by(|a, b| a.1 >= b.1), "{name}");
        }
        let last = trace.shots.last().unwrap().energy;
        let energy = EnergyBalance::new(&mesh, &run.field, &run.shots);
        assert_eq!(last.absorbed, energy.absorbed, "{name}");
        assert_eq!(last.unshot, energy.unshot, "{name}");
        assert_eq!(last.closure, energy.closure, "{name}");
        let worst = worst_over_bound(&mesh, &trace, &run);
        assert!(worst <= 1.0, "{name}: {worst}");
        // Faults are noticed: the links of one patch, and one shot.
        trace.links[0].exponent += 1;
        assert!(worst_over_bound(&mesh, &trace, &run) > 10.0, "{name}");
        trace.links[0].exponent -= 1;
        trace.shots[3].radiosity *= 1.05;
        assert!(worst_over_bound(&mesh, &trace, &run) > 2.0, "{name}");
    });
}

/// Where a texel does not see the whole shooter, the record names a face between them.
#[test]
fn hidden_texels_name_their_occluder() {
    let mesh = mesh_of(&lit_room());
    let mut engine = cpu::CpuSolver::new(&mesh, &engine_settings().transport);
    let (_, trace) = record_solve(&mut engine, &mesh, UNLIMITED);
    let order = TexelOrder::new(&mesh);
    let links = trace.links[0].unpack(&order).unwrap();
    let hidden: Vec<usize> = (0..order.texels.len()).filter(|at| links.shares[*at] < 1.0).collect();
    assert!(hidden.len() > 10);
    for at in hidden {
        // The faces of the box follow the six of the room.
        assert!((7..=12).contains(&links.occluders[at]), "{}", links.occluders[at]);
    }
}

#[test]
fn full_record_keeps_the_first_shots() {
    let mesh = mesh_of(&lit_room());
    let whole = shoot_on_cpu(&mesh, &engine_settings());
    let mut engine = cpu::CpuSolver::new(&mesh, &engine_settings().transport);
    let limits = TraceLimits {
        bytes: 20_000,
        ..UNLIMITED
    };
    let (run, trace) = record_solve(&mut engine, &mesh, limits);
    assert_eq!(run.shots, whole.shots);
    assert_eq!(trace.shot_count, whole.shots.len());
    assert!(!trace.is_complete() && trace.shots.len() > 5);
    for (traced, shot) in trace.shots.iter().zip(&whole.shots) {
        assert_eq!(traced.shot, *shot);
    }
    let fitting = trace.count_fitting(5_000, 80);
    assert!(fitting.0 > 0 && fitting.0 < trace.shots.len() && fitting.1 <= fitting.0);
    assert_eq!(trace.count_fitting(usize::MAX, 80).0, trace.shots.len());
    assert_eq!(trace.count_fitting(0, 80), (0, 0));
}
