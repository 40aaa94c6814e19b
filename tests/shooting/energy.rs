//! The ledger after every shot, on random scenes, CPU and GPU; and that it notices broken engines.

use approx::abs_diff_eq;
use common::energy::Energy;
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::passes::Engine;
use common::settings::{Meshing, Schedule, Settings, Transport, Visibility};
use common::shooting::{Field, Order, Shoot, Shot, select};
use cpu::CpuSolver;
use glam::{Vec3, Vec4};
use gpu::{Fault, Gpu, GpuSolver};
use oracle::judge::exact;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use radiosity_tests::bounds::{U, energy_rounding};
use radiosity_tests::engines::drawn;
use radiosity_tests::random::{Sample, closed, open};
use radiosity_tests::{cases, furnace, lit_room};
use std::ops::ControlFlow;

/// The contract's bounds on the imbalance.
const CPU_IMBALANCE: f64 = 1e-5;
const GPU_IMBALANCE: f64 = 1e-4;

/// Shots per case.
const SHOTS: u32 = 48;

fn settings(sample: &Sample, visibility: Visibility) -> Settings {
    Settings {
        meshing: Meshing {
            cells: sample.cells,
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

/// What a scene and a solver are held to.
#[derive(Clone, Copy)]
struct Rules {
    /// Nothing escapes.
    closed: bool,
    /// The contract's bound on the imbalance.
    imbalance: f64,
}

/// Everything that must hold after any shot.
fn check(mesh: &Mesh, field: &Field, shots: &[Shot], rules: Rules) -> Result<(), TestCaseError> {
    let energy = Energy::new(mesh, field, shots);
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
        // Sums over the channels, the texels and the cells: 2u, 8u and 9u.
        prop_assert!(
            abs_diff_eq!(f64::from(shot.unshot), unshot, epsilon = 19.0 * U * unshot),
            "{shot:?} {unshot}"
        );
        prop_assert!(!rules.closed || shot.escaped == 0.0, "{shot:?}");
    }
    let n = shots.len() as f64;
    for (k, texel) in mesh.texels.iter().enumerate() {
        let [b, r, h] =
            [&field.radiosity, &field.residual, &field.irradiance].map(|v| v[k].truncate());
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

/// Shoots one by one, the most powerful cell first, and checks after each.
fn step(
    engine: &mut dyn Engine,
    mesh: &Mesh,
    settings: &Settings,
    rules: Rules,
) -> Result<Vec<Shot>, TestCaseError> {
    let mut shots = Vec::new();
    check(mesh, &engine.field().unwrap(), &shots, rules)?;
    let threshold =
        settings.schedule.epsilon as f32 * engine.cell_power().unwrap().iter().sum::<f32>();
    while shots.len() < settings.schedule.max_shots as usize
        && let Some(cell) = select(&engine.cell_power().unwrap(), threshold)
    {
        shots.push(engine.shoot(cell).unwrap());
        check(mesh, &engine.field().unwrap(), &shots, rules)?;
    }
    Ok(shots)
}

proptest! {
    #![proptest_config(cases(96))]

    #[test]
    fn closed_rooms_balance(sample in closed()) {
        let mesh = sample.mesh();
        let settings = settings(&sample, Visibility::Rays);
        step(&mut CpuSolver::new(&mesh, &settings.transport), &mesh, &settings, Rules { closed: true, imbalance: CPU_IMBALANCE })?;
    }

    #[test]
    fn open_rooms_balance(sample in open()) {
        let mesh = sample.mesh();
        let settings = settings(&sample, Visibility::Rays);
        step(&mut CpuSolver::new(&mesh, &settings.transport), &mesh, &settings, Rules { closed: false, imbalance: CPU_IMBALANCE })?;
    }
}

/// The share that escapes through a missing wall is Lambert's factor to that wall.
#[test]
fn escaped_is_what_leaves_through_the_opening() {
    // Four standard errors of 1024 stratified directions.
    const BOUND: f64 = 4.0 * 0.003;
    for missing in 0..6 {
        let mut cube = furnace(0.5);
        let wall = cube.faces.remove(missing);
        let mesh = Mesh::uniform(&cube, 4, 2).unwrap();
        let mut engine = CpuSolver::new(&mesh, &Settings::default().transport);
        for cell in 0..mesh.cells.len() as u32 {
            let escaped = f64::from(engine.shoot(cell).unwrap().escaped);
            let shooter = &mesh.cells[cell as usize].shooter;
            let centre = shooter.centre.as_dvec3() * mesh.unit + 0.5;
            let exact = exact::point_to_polygon(centre, shooter.normal.as_dvec3(), wall.outline());
            assert!(
                abs_diff_eq!(escaped, exact, epsilon = BOUND),
                "wall {missing}, cell {cell}: {escaped} is not {exact}"
            );
        }
    }
}

/// Six closed and six open rooms, always the same.
fn dozen() -> Vec<(Sample, bool)> {
    let mut runner = TestRunner::deterministic();
    let mut draw = |closed_room: bool| {
        let strategy = if closed_room {
            closed().boxed()
        } else {
            open().boxed()
        };
        (
            strategy.new_tree(&mut runner).unwrap().current(),
            closed_room,
        )
    };
    (0..12).map(|k| draw(k % 2 == 0)).collect()
}

#[test]
fn gpu_balances_and_chooses_as_the_host_does() {
    let gpu = Gpu::open(None).unwrap();
    for (sample, closed) in dozen() {
        let mesh = sample.mesh();
        let settings = settings(&sample, drawn(256));
        let mut engine = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
        let rules = Rules {
            closed,
            imbalance: GPU_IMBALANCE,
        };
        let stepped = step(&mut engine, &mesh, &settings, rules).unwrap();
        let mut free = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
        let threshold =
            settings.schedule.epsilon as f32 * free.cell_power().unwrap().iter().sum::<f32>();
        let mut shots = Vec::new();
        free.run(Order::Greedy { threshold }, SHOTS, &mut |shot| {
            shots.push(*shot);
            ControlFlow::Continue(())
        })
        .unwrap();
        assert_eq!(shots, stepped);
        assert_eq!(free.field().unwrap(), engine.field().unwrap());
    }
}

/// Changes what an engine says after its latest shot.
type Lie = fn(&Mesh, &mut Field, &mut Vec<Shot>);

/// The imbalance after each of eight shots, told by a liar.
fn imbalances(engine: &mut dyn Engine, mesh: &Mesh, lie: Lie) -> Vec<f64> {
    let mut shots = Vec::new();
    (0..8)
        .map(|_| {
            let cell = select(&engine.cell_power().unwrap(), 0.0).unwrap();
            shots.push(engine.shoot(cell).unwrap());
            let (mut field, mut told) = (engine.field().unwrap(), shots.clone());
            lie(mesh, &mut field, &mut told);
            Energy::new(mesh, &field, &told).imbalance
        })
        .collect()
}

fn largest(imbalances: &[f64]) -> f64 {
    imbalances.iter().copied().fold(0.0, f64::max)
}

const HONEST: Lie = |_, _, _| ();

#[test]
fn the_ledger_notices_a_broken_engine() {
    let lies: [(&str, Lie); 5] = [
        ("the shooter keeps its residual", |mesh, field, shots| {
            let shot = shots[shots.len() - 1];
            let cell = &mesh.cells[shot.cell as usize];
            let radiosity = Vec3::from(shot.power) / cell.shooter.area;
            for r in &mut field.residual[cell.first as usize..][..cell.count as usize] {
                *r += radiosity.extend(0.0);
            }
        }),
        ("one texel takes its light twice", |mesh, field, shots| {
            let shot = shots[shots.len() - 1];
            let radiosity = Vec3::from(shot.power) / mesh.cells[shot.cell as usize].shooter.area;
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
    let honest = imbalances(&mut CpuSolver::new(&mesh, &transport), &mesh, HONEST);
    assert!(largest(&honest) <= CPU_IMBALANCE, "{honest:?}");
    for (name, lie) in lies {
        let found = imbalances(&mut CpuSolver::new(&mesh, &transport), &mesh, lie);
        assert!(largest(&found) > CPU_IMBALANCE, "{name}: {found:?}");
    }
    // An engine that forgets ρ: its texels are white, the ledger's are not.
    let mut white = mesh.clone();
    white
        .texels
        .iter_mut()
        .for_each(|texel| texel.reflectance = Vec3::ONE);
    let found = imbalances(&mut CpuSolver::new(&white, &transport), &mesh, HONEST);
    assert!(largest(&found) > CPU_IMBALANCE, "ρ: {found:?}");
}

#[test]
fn the_ledger_notices_a_broken_shader() {
    let fault = |file, from, to| Fault { file, from, to };
    let faults = [
        fault("deposit", "texels[k].reflectance * received", "received"),
        fault("deposit", "residual[k] = vec4f(0.0);", ""),
        fault(
            "deposit",
            "irradiance[k].xyz + received",
            "irradiance[k].xyz + 2.0 * received",
        ),
        fault(
            "deposit",
            "residual[k] += vec4f(reflected, 0.0)",
            "residual[k] = vec4f(reflected, 0.0)",
        ),
        fault("received", "* texels[texel].area", ""),
        fault(
            "closure",
            "lane_taken[0] / shots[slot].area",
            "lane_taken[0]",
        ),
    ];
    let gpu = Gpu::open(None).unwrap();
    let mesh = Mesh::uniform(&lit_room(), 8, 2).unwrap();
    let transport = Transport {
        visibility: drawn(256),
        ..Transport::default()
    };
    let run = |faults: &[Fault]| {
        let mut engine = GpuSolver::with_faults(&gpu, &mesh, &transport, faults).unwrap();
        imbalances(&mut engine, &mesh, HONEST)
    };
    let honest = run(&[]);
    assert!(largest(&honest) <= GPU_IMBALANCE, "{honest:?}");
    for fault in faults {
        let found = run(&[fault]);
        assert!(largest(&found) > GPU_IMBALANCE, "{fault:?}: {found:?}");
    }
}
