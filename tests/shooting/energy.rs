//! Energy balance after every shot, on random scenes, CPU and GPU; and its detection of broken engines.

use approx::abs_diff_eq;
use common::energy::EnergyBalance;
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::passes::Engine;
use common::settings::{Meshing, Schedule, Settings, Transport, Visibility};
use common::shooting::{RadiosityField, Shoot, Shot, ShotOrder, select_shooter};
use cpu::CpuSolver;
use glam::{Vec3, Vec4};
use gpu::{Gpu, GpuSolver, ShaderFault};
use oracle::exact;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use radiosity_tests::bounds::{U, energy_rounding};
use radiosity_tests::engines::item_buffer;
use radiosity_tests::random_rooms::{RandomRoom, closed_room, open_room};
use radiosity_tests::shader_faults::{assert_faults_noticed, shader_fault};
use radiosity_tests::{furnace, lit_room, random_cases};
use std::ops::ControlFlow;

/// Bounds on the imbalance by the contract.
const CPU_IMBALANCE: f64 = 1e-5;
const GPU_IMBALANCE: f64 = 1e-4;

/// Shots per case.
const SHOTS: u32 = 48;

fn settings(sample: &RandomRoom, visibility: Visibility) -> Settings {
    Settings {
        meshing: Meshing {
            patches: sample.patches,
            ..Meshing::default()
        },
        transport: Transport {
            form_factor: sample.form_factor,
            visibility,
            ..Transport::default()
        },
        schedule: Schedule {
            max_shots: SHOTS,
            ..Schedule::default()
        },
        ..Settings::default()
    }
}

/// Conditions on a scene and a solver.
#[derive(Clone, Copy)]
struct Rules {
    /// True if nothing may escape.
    closed: bool,
    /// Bound on the imbalance.
    imbalance: f64,
}

/// Checks the conditions that hold after any shot.
fn check_state(mesh: &Mesh, field: &RadiosityField, shots: &[Shot], rules: Rules) -> Result<(), TestCaseError> {
    let energy = EnergyBalance::new(mesh, field, shots);
    let bound = energy_rounding(&energy, mesh.area_unit(), shots).min(rules.imbalance);
    prop_assert!(
        energy.imbalance <= bound,
        "imbalance {} > {bound}: {energy:?}",
        energy.imbalance
    );
    let unit = 1.0 / mesh.area_unit();
    let unshot = unit * energy.unshot.iter().sum::<f64>();
    if let Some(shot) = shots.last() {
        prop_assert!(shot.power.iter().all(|p| *p >= 0.0), "{shot:?}");
        // Sums over the channels, the texels and the patches: 2u, 8u and 9u.
        prop_assert!(
            abs_diff_eq!(f64::from(shot.unshot), unshot, epsilon = 19.0 * U * unshot),
            "{shot:?} {unshot}"
        );
        prop_assert!(!rules.closed || shot.escaped == 0.0, "{shot:?}");
    }
    let n = shots.len() as f64;
    for (k, texel) in mesh.texels.iter().enumerate() {
        let [b, r, h] = [&field.radiosity, &field.residual, &field.irradiance].map(|v| v[k].truncate());
        prop_assert!(
            b.is_finite()
                && h.is_finite()
                && b.min_element() >= 0.0
                && r.min_element() >= 0.0
                && h.min_element() >= 0.0
        );
        prop_assert!(r.cmple(b).all(), "more is unshot than there is: {r} of {b}");
        // Both sides are rounded at each of n additions, and thrice in each product.
        let reflected = texel.reflectance.as_dvec3() * h.as_dvec3();
        let difference = (b.as_dvec3() - texel.emission.as_dvec3() - reflected).abs();
        prop_assert!(
            difference.cmple(b.as_dvec3() * (2.0 * n + 6.0) * U).all(),
            "B − E − ρH = {difference} of {b}"
        );
    }
    Ok(())
}

/// Shoots from one patch at a time, the most powerful first, and checks after each shot.
fn shoot_with_checks(
    engine: &mut dyn Engine,
    mesh: &Mesh,
    settings: &Settings,
    rules: Rules,
) -> Result<Vec<Shot>, TestCaseError> {
    let mut shots = Vec::new();
    check_state(mesh, &engine.read_field().unwrap(), &shots, rules)?;
    let threshold = settings.schedule.epsilon as f32 * engine.patch_power().unwrap().iter().sum::<f32>();
    while shots.len() < settings.schedule.max_shots as usize
        && let Some(patch) = select_shooter(&engine.patch_power().unwrap(), threshold)
    {
        shots.push(engine.shoot(patch).unwrap());
        check_state(mesh, &engine.read_field().unwrap(), &shots, rules)?;
    }
    Ok(shots)
}

proptest! {
    #![proptest_config(random_cases(96))]

    #[test]
    fn energy_balances_in_closed_rooms(sample in closed_room()) {
        let mesh = sample.room_mesh();
        let settings = settings(&sample, Visibility::Rays);
        shoot_with_checks(&mut CpuSolver::new(&mesh, &settings.transport), &mesh, &settings, Rules { closed: true, imbalance: CPU_IMBALANCE })?;
    }

    #[test]
    fn energy_balances_in_open_rooms(sample in open_room()) {
        let mesh = sample.room_mesh();
        let settings = settings(&sample, Visibility::Rays);
        shoot_with_checks(&mut CpuSolver::new(&mesh, &settings.transport), &mesh, &settings, Rules { closed: false, imbalance: CPU_IMBALANCE })?;
    }
}

/// The share that escapes through a missing wall is Lambert's factor to that wall.
#[test]
fn escaped_share_equals_form_factor_of_opening() {
    // Four standard errors of 1024 stratified directions.
    const BOUND: f64 = 4.0 * 0.003;
    for missing in 0..6 {
        let mut cube = furnace(0.5);
        let wall = cube.faces.remove(missing);
        let mesh = Mesh::uniform(&cube, 4, 2).unwrap();
        let mut engine = CpuSolver::new(&mesh, &Settings::default().transport);
        for patch in 0..mesh.patches.len() as u32 {
            let escaped = f64::from(engine.shoot(patch).unwrap().escaped);
            let shooter = &mesh.patches[patch as usize].shooter;
            let centre = shooter.centre.as_dvec3() * mesh.unit + 0.5;
            let exact = exact::point_to_polygon(centre, shooter.normal.as_dvec3(), wall.outline());
            assert!(
                abs_diff_eq!(escaped, exact, epsilon = BOUND),
                "wall {missing}, patch {patch}: {escaped} is not {exact}"
            );
        }
    }
}

/// Returns six closed and six open rooms, the same in every run.
fn twelve_rooms() -> Vec<(RandomRoom, bool)> {
    let mut runner = TestRunner::deterministic();
    let mut draw = |is_closed: bool| {
        let strategy = if is_closed {
            closed_room().boxed()
        } else {
            open_room().boxed()
        };
        (strategy.new_tree(&mut runner).unwrap().current(), is_closed)
    };
    (0..12).map(|k| draw(k % 2 == 0)).collect()
}

#[test]
fn gpu_energy_balances_and_gpu_selects_like_host() {
    let gpu = Gpu::open(None).unwrap();
    for (sample, closed) in twelve_rooms() {
        let mesh = sample.room_mesh();
        let settings = settings(&sample, item_buffer(256));
        let mut engine = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
        let rules = Rules {
            closed,
            imbalance: GPU_IMBALANCE,
        };
        let stepped = shoot_with_checks(&mut engine, &mesh, &settings, rules).unwrap();
        let mut free = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
        let threshold = settings.schedule.epsilon as f32 * free.patch_power().unwrap().iter().sum::<f32>();
        let mut shots = Vec::new();
        free.run(ShotOrder::Greedy { threshold }, SHOTS, &mut |shot| {
            shots.push(*shot);
            ControlFlow::Continue(())
        })
        .unwrap();
        assert_eq!(shots, stepped);
        assert_eq!(free.read_field().unwrap(), engine.read_field().unwrap());
    }
}

/// Falsifies an engine's field and shots after its latest shot.
type Falsification = fn(&Mesh, &mut RadiosityField, &mut Vec<Shot>);

/// Returns the imbalance after each of eight shots, with the engine's report falsified by `falsify`.
fn imbalances(engine: &mut dyn Engine, mesh: &Mesh, falsify: Falsification) -> Vec<f64> {
    let mut shots = Vec::new();
    (0..8)
        .map(|_| {
            let patch = select_shooter(&engine.patch_power().unwrap(), 0.0).unwrap();
            shots.push(engine.shoot(patch).unwrap());
            let (mut field, mut reported) = (engine.read_field().unwrap(), shots.clone());
            falsify(mesh, &mut field, &mut reported);
            EnergyBalance::new(mesh, &field, &reported).imbalance
        })
        .collect()
}

fn largest(imbalances: &[f64]) -> f64 {
    imbalances.iter().copied().fold(0.0, f64::max)
}

const UNFALSIFIED: Falsification = |_, _, _| ();

#[test]
fn energy_balance_detects_broken_engine() {
    let falsifications: [(&str, Falsification); 5] = [
        ("the shooter keeps its residual", |mesh, field, shots| {
            let shot = shots[shots.len() - 1];
            let patch = &mesh.patches[shot.patch as usize];
            let radiosity = Vec3::from(shot.power) / patch.shooter.area;
            for r in &mut field.residual[patch.first as usize..][..patch.count as usize] {
                *r += radiosity.extend(0.0);
            }
        }),
        ("one texel takes its light twice", |mesh, field, shots| {
            let shot = shots[shots.len() - 1];
            let radiosity = Vec3::from(shot.power) / mesh.patches[shot.patch as usize].shooter.area;
            let taken = field.irradiance.iter().position(|h| h.w > 0.0).unwrap();
            let irradiance = &mut field.irradiance[taken];
            *irradiance += (radiosity * irradiance.w).extend(0.0);
        }),
        ("a texel's residual is lost", |_, field, _| {
            let held = field.residual.iter().position(|r| r.x > 0.0).unwrap();
            field.residual[held] = Vec4::ZERO;
        }),
        ("ΣF is made up so that nothing is lost", |_, _, shots| {
            for shot in shots {
                shot.form_factor_sum = 1.0 - shot.escaped;
            }
        }),
        ("a shot is not recorded", |_, _, shots| {
            shots.pop();
        }),
    ];
    let mesh = Mesh::uniform(&lit_room(), 8, 2).unwrap();
    let transport = Transport {
        form_factor: FormFactor::Disc,
        ..Transport::default()
    };
    let honest = imbalances(&mut CpuSolver::new(&mesh, &transport), &mesh, UNFALSIFIED);
    assert!(largest(&honest) <= CPU_IMBALANCE, "{honest:?}");
    for (name, falsify) in falsifications {
        let found = imbalances(&mut CpuSolver::new(&mesh, &transport), &mesh, falsify);
        assert!(largest(&found) > CPU_IMBALANCE, "{name}: {found:?}");
    }
    // An engine that ignores ρ: its texels are white, those of the balance are not.
    let mut white = mesh.clone();
    white.texels.iter_mut().for_each(|texel| texel.reflectance = Vec3::ONE);
    let found = imbalances(&mut CpuSolver::new(&white, &transport), &mesh, UNFALSIFIED);
    assert!(largest(&found) > CPU_IMBALANCE, "ρ: {found:?}");
}

#[test]
fn energy_balance_detects_broken_shader() {
    let faults = [
        shader_fault("deposit", "texels[k].reflectance * received", "received"),
        shader_fault("deposit", "residual[k] = vec4f(0.0);", ""),
        shader_fault(
            "deposit",
            "irradiance[k].xyz + received",
            "irradiance[k].xyz + 2.0 * received",
        ),
        shader_fault(
            "deposit",
            "residual[k] += vec4f(reflected, 0.0)",
            "residual[k] = vec4f(reflected, 0.0)",
        ),
        shader_fault("patch_transfer", "* texels[texel].area", ""),
        shader_fault("closure", "lane_sums[0] / shots[slot].area", "lane_sums[0]"),
    ];
    let gpu = Gpu::open(None).unwrap();
    let mesh = Mesh::uniform(&lit_room(), 8, 2).unwrap();
    let transport = Transport {
        visibility: item_buffer(256),
        ..Transport::default()
    };
    let run = |faults: &[ShaderFault]| {
        let mut engine = GpuSolver::with_faults(&gpu, &mesh, &transport, faults).unwrap();
        imbalances(&mut engine, &mesh, UNFALSIFIED)
    };
    let honest = run(&[]);
    assert!(largest(&honest) <= GPU_IMBALANCE, "{honest:?}");
    assert_faults_noticed(faults, |fault| {
        let found = run(&[fault]);
        println!("{fault:?}: {found:?}");
        largest(&found) > GPU_IMBALANCE
    });
}
