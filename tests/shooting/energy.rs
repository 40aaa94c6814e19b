//! Energy balance after every shot, on every engine; and its detection of broken engines.

use approx::abs_diff_eq;
use common::energy::EnergyBalance;
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::passes::Engine;
use common::scene::Scene;
use common::settings::{Settings, Transport, Visibility};
use common::shooting::{RadiosityField, Shoot, Shot, select_shooter};
use cpu::CpuSolver;
use glam::{Vec3, Vec4};
use oracle::exact;
use properties::MeshedScene;
use properties::strategies::{closed_room, open_room};
use proptest::prelude::*;
use radiosity_tests::bounds::{U, energy_rounding};
use radiosity_tests::engines::{ENGINE_KINDS, EngineKind, gpu_solver, item_buffer, mesh_scene, settings_of};
use radiosity_tests::shader_faults::assert_faults_noticed;
use radiosity_tests::solutions::{room_with_standing_box, slit_room};
use radiosity_tests::{box_in_room, furnace, halve_quads, lit_room, random_cases};

/// Bounds on the imbalance by the contract.
const CPU_IMBALANCE: f64 = 1e-5;
const GPU_IMBALANCE: f64 = 1e-4;

/// Checks the conditions that hold after any shot; from a closed scene nothing may escape.
fn check_state(
    mesh: &Mesh,
    field: &RadiosityField,
    shots: &[Shot],
    (closed, imbalance): (bool, f64),
) -> Result<(), TestCaseError> {
    let energy = EnergyBalance::new(mesh, field, shots);
    let bound = energy_rounding(&energy, mesh.area_unit(), shots).min(imbalance);
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
        prop_assert!(!closed || shot.escaped == 0.0, "{shot:?}");
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
fn shoot_with_checks(kind: &EngineKind, mesh: &Mesh, settings: &Settings, closed: bool) -> Result<(), TestCaseError> {
    let mut engine = kind.fresh_engine(mesh, settings, &[]);
    let rules = (closed, if kind.on_gpu { GPU_IMBALANCE } else { CPU_IMBALANCE });
    let mut shots = Vec::new();
    check_state(mesh, &engine.read_field().unwrap(), &shots, rules)?;
    let threshold = settings.schedule.epsilon as f32 * engine.patch_power().unwrap().iter().sum::<f32>();
    while shots.len() < settings.schedule.max_shots as usize
        && let Some(patch) = select_shooter(&engine.patch_power().unwrap(), threshold)
    {
        shots.push(engine.shoot(patch).unwrap());
        check_state(mesh, &engine.read_field().unwrap(), &shots, rules)?;
    }
    Ok(())
}

fn shoot_in_random_room(
    kind: &EngineKind,
    (room, form_factor): &(MeshedScene, FormFactor),
    closed: bool,
) -> Result<(), TestCaseError> {
    let mut settings = Settings::default();
    settings.transport.form_factor = *form_factor;
    settings.schedule.max_shots = 48;
    shoot_with_checks(kind, &room.mesh()?, &settings, closed)
}

fn any_form_factor() -> impl Strategy<Value = FormFactor> {
    prop::sample::select(&[FormFactor::Paper, FormFactor::Disc, FormFactor::Polygon][..])
}

proptest! {
    #![proptest_config(random_cases(96))]

    #[test]
    fn energy_balances_in_closed_rooms(sample in (closed_room(), any_form_factor())) {
        shoot_in_random_room(&ENGINE_KINDS[0], &sample, true)?;
    }

    #[test]
    fn energy_balances_in_open_rooms(sample in (open_room(), any_form_factor())) {
        shoot_in_random_room(&ENGINE_KINDS[0], &sample, false)?;
    }
}

proptest! {
    #![proptest_config(random_cases(6))]

    #[test]
    fn energy_balances_on_the_gpu(
        closed in (closed_room(), any_form_factor()),
        open in (open_room(), any_form_factor()),
    ) {
        for kind in ENGINE_KINDS.iter().filter(|kind| kind.on_gpu) {
            shoot_in_random_room(kind, &closed, true)?;
            shoot_in_random_room(kind, &open, false)?;
        }
    }
}

/// Makes the lit room without two of its walls.
fn room_without_two_walls() -> Scene {
    let mut scene = lit_room();
    scene.name = "an open room".into();
    scene.faces.drain(3..5);
    scene
}

/// Whole faces like the paper, parts of faces, and many points of each.
#[test]
fn energy_balances_on_every_engine() {
    for scene in [
        halve_quads(&furnace(0.5)),
        box_in_room(),
        room_with_standing_box(),
        slit_room(),
        room_without_two_walls(),
    ] {
        for [patches, samples] in [[1, 1], [2, 1], [2, 4]] {
            let mut settings = settings_of([6, patches, samples], Visibility::Rays, 1e-3);
            settings.schedule.max_shots = 12;
            let mesh = mesh_scene(&scene, &settings);
            for kind in ENGINE_KINDS {
                let closed = scene.name != "an open room";
                let checked = shoot_with_checks(&kind, &mesh, &settings, closed);
                let name = format!("{}, {patches} patches, {samples} samples, {}", scene.name, kind.name);
                checked.unwrap_or_else(|fault| panic!("{name}: {fault}"));
            }
        }
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
    let mesh = Mesh::uniform(&lit_room(), 8, 2).unwrap();
    let transport = Settings::default().with_visibility(item_buffer(256)).transport;
    assert_faults_noticed("energy", |faults| {
        let found = imbalances(&mut gpu_solver(&mesh, &transport, faults), &mesh, UNFALSIFIED);
        let noticed = largest(&found) > GPU_IMBALANCE;
        Vec::from_iter(noticed.then(|| format!("imbalance {found:?}")))
    });
}
