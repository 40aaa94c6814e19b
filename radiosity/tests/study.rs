//! The study of convergence: theoretical orders, and the parameter that sets an error floor.

use common::scene::{Face, Scene};
use common::settings::{Meshing, Settings};
use common::shooting::shoot_until_converged;
use common::solution::{PhaseSeconds, Solution};
use cpu::CpuSolver;
use glam::{DVec3, Vec3};
use oracle::solve::progress::{ProgressMonitor, without_progress};
use radiosity::studies::chart::store::MeasurementStore;
use radiosity::studies::chart::truth::ChartTruth;
use radiosity::studies::chart::vary::measure::SweepSetup;
use radiosity::studies::chart::vary::sweeps::{EPSILON_SWEEP, PATCH_SWEEP, Sweep, SweepCurve, SweepTruth, TEXEL_SWEEP};
use radiosity::studies::chart::vary::{ConvergenceStudy, MeasuredSweep, convergence_json, page};
use serde_json::to_value;
use std::ops::ControlFlow;

/// Makes a parallelogram about `centre`, spanned by 2`x` and 2`y`, front x × y.
fn square_face(name: &str, centre: DVec3, x: DVec3, y: DVec3, light: [f32; 2]) -> Face {
    let corners = [-x - y, x - y, x + y, y - x].map(|p| centre + p);
    let [emission, reflectance] = light.map(Vec3::splat);
    Face::quad(name, corners, emission, reflectance)
}

/// Makes a lamp above a floor, and a screen between them if `screened`.
fn lamp_over_floor(screened: bool) -> Scene {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let mut faces = vec![
        square_face("floor", DVec3::ZERO, z, x, [0.0, 0.5]),
        square_face("lamp", y * 1.5, x, z, [5.0, 0.3]),
    ];
    if screened {
        let (a, b) = (DVec3::new(0.31, 0.1, 0.23), DVec3::new(-0.2, 0.03, 0.27));
        faces.push(square_face("screen", y * 0.7, a, b, [0.0, 0.0]));
        faces.push(faces[2].reversed());
    }
    Scene {
        name: "lamp over floor".into(),
        faces,
        notes: Vec::new(),
    }
}

fn empty_store(name: &str) -> MeasurementStore {
    let name = format!("study-{}-{name}.jsonl", std::process::id());
    let path = std::env::temp_dir().join(name);
    let _ = std::fs::remove_file(&path);
    MeasurementStore::open(&path).unwrap()
}

fn measure_sweep((name, scene): (&str, &Scene), sweep: &Sweep, truth: Option<&ChartTruth>) -> MeasuredSweep {
    let mut store = empty_store(name);
    let mut setup = SweepSetup::new(scene, None, truth, &mut store);
    let measured = setup.measure_sweep(sweep, &without_progress()).unwrap();
    measured.unwrap()
}

const REFINED: Sweep = Sweep {
    truth: SweepTruth::Finer(128.0),
    // The unshot power must be negligible beside the error of the texels.
    base: |settings| settings.schedule.epsilon = 1e-6,
    ..TEXEL_SWEEP
};

#[test]
fn texel_centres_without_shadows_converge_at_second_order() {
    // The mean of a smooth H over a texel is H(centroid) + h²/24 ∇²H + …
    let measured = measure_sweep(("open", &lamp_over_floor(false)), &REFINED, None);
    let curve = &measured.curves[0];
    let order = curve.order.unwrap();
    // Patches as large as texels at N = 4, and the truth's own error of 1/1024, blur the order.
    assert!((1.8..2.3).contains(&order), "{order} {:?}", curve.points);
    assert!(curve.converges, "{}", curve.finding);
}

#[test]
fn texels_with_shadows_converge_at_order_one_half_at_least() {
    // A shadow's edge crosses O(1/h) of O(1/h²) texels, each with an error of O(1): the RMS is O(√h).
    let measured = measure_sweep(("screened", &lamp_over_floor(true)), &REFINED, None);
    let order = measured.curves[0].order.unwrap();
    // The position of the edge among the centres is random: a tenth either way over four points.
    assert!((0.4..1.2).contains(&order), "{order} {:?}", measured.curves[0].points);
}

#[test]
fn error_is_about_linear_in_epsilon() {
    // The unshot power is missing: about ε of the light, and up to 1/(1 − ρ) times that.
    let mut bright = lamp_over_floor(false);
    for face in &mut bright.faces {
        face.reflectance = Vec3::splat(0.9);
        let sides = face.corners;
        face.corners = sides.map(|c| DVec3::new(3.0 * c.x, c.y, 3.0 * c.z));
    }
    let sweep = Sweep {
        values: &[0.1, 0.03, 0.01, 0.003],
        base: |settings| settings.meshing.texels = 8,
        ..EPSILON_SWEEP
    };
    let measured = measure_sweep(("bright", &bright), &sweep, None);
    let order = measured.curves[0].order.unwrap();
    assert!((0.7..1.3).contains(&order), "{order} {:?}", measured.curves[0].points);
}

#[test]
fn error_floor_is_traced_to_its_parameter() {
    // The truth has 8×8 patches; points with one patch a face stop at the error of that patch.
    let scene = lamp_over_floor(true);
    let dir = std::env::temp_dir().join(format!("study-{}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    let settings = Settings {
        meshing: Meshing {
            texels: 32,
            patches: 8,
            samples: 64,
        },
        ..Settings::default()
    };
    let mesh = common::cover::sampled_mesh(&scene, &settings.meshing).unwrap();
    let mut solver = CpuSolver::new(&mesh, &settings.transport);
    let run = shoot_until_converged(&mut solver, &settings.schedule, &mut |_, _| ControlFlow::Continue(())).unwrap();
    let solution = Solution {
        matrix: None,
        relit: None,
        scene: &scene,
        mesh: &mesh,
        solver: "cpu",
        adapter: None,
        settings: &settings,
        run: &run,
        texel_error: None,
        certificate: None,
        error: None,
        warnings: &[],
        notes: &[],
        seconds: PhaseSeconds::default(),
    };
    solution.write(&dir).unwrap();
    let truth = ChartTruth::read_result(&dir, "fine".into()).unwrap();
    std::fs::remove_dir_all(&dir).unwrap();
    let sweep = Sweep {
        values: &[8.0, 16.0, 32.0],
        base: |settings| settings.meshing.patches = 1,
        curves: &[SweepCurve {
            label: "128 samples",
            change: |settings| settings.meshing.samples = 128,
        }],
        ..TEXEL_SWEEP
    };
    let measured = measure_sweep(("floor", &scene), &sweep, Some(&truth));
    let curve = &measured.curves[0];
    assert!(!curve.converges, "{}", curve.finding);
    assert!(
        curve.finding.contains("set by another parameter: patches 1 → 2"),
        "{}",
        curve.finding
    );
    assert_eq!(curve.order_beside, None);
}

/// A sweep that takes milliseconds.
const SMALL_SWEEP: Sweep = Sweep {
    base: |settings| settings.meshing.texels = 4,
    values: &[1.0, 2.0, 3.0],
    truth: SweepTruth::Finer(4.0),
    ..PATCH_SWEEP
};

#[test]
fn points_measured_before_interrupt_are_reported() {
    let scene = lamp_over_floor(false);
    let mut store = empty_store("interrupted");
    let mut setup = SweepSetup::new(&scene, None, None, &mut store);
    let until = |name: &str, _| {
        if name.contains("--patches 3") {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let measured = setup
        .measure_sweep(&SMALL_SWEEP, &ProgressMonitor::new(&until))
        .unwrap()
        .unwrap();
    assert_eq!(measured.curves.len(), 1);
    assert_eq!(measured.curves[0].points.len(), 2);
    let study = ConvergenceStudy {
        scene: "s".into(),
        faces: 2,
        adapter: "none".into(),
        sweeps: vec![measured],
        item_buffers: Vec::new(),
    };
    let page = page::render_page(std::slice::from_ref(&study));
    for wanted in ["<svg", "--patches", "polygon"] {
        assert!(page.contains(wanted), "{wanted}");
    }
    assert!(!page.contains("http"), "the page needs the network");
    let json = convergence_json(&[study], 1.0);
    let points = &json["scenes"][0]["sweeps"][0]["curves"][0]["points"];
    assert_eq!(points.as_array().unwrap().len(), 2);
    assert!(points[0]["error"].as_f64().unwrap() > 0.0);
    let mut store = empty_store("broken");
    let mut setup = SweepSetup::new(&scene, None, None, &mut store);
    let broken = ProgressMonitor::new(&|_, _| ControlFlow::Break(()));
    assert!(setup.measure_sweep(&SMALL_SWEEP, &broken).unwrap().is_none());
}

#[test]
fn stored_points_are_not_solved_again() {
    let scene = lamp_over_floor(false);
    let mut store = empty_store("stored");
    let mut setup = SweepSetup::new(&scene, None, None, &mut store);
    let measured = setup.measure_sweep(&SMALL_SWEEP, &without_progress()).unwrap().unwrap();
    // A monitor that stops every solve.
    let broken = ProgressMonitor::new(&|_, _| ControlFlow::Break(()));
    let stored = setup.measure_sweep(&SMALL_SWEEP, &broken).unwrap().unwrap();
    assert_eq!(to_value(&stored).unwrap(), to_value(&measured).unwrap());
    // Against another truth, or in another scene, no stored point counts.
    let coarser = Sweep {
        truth: SweepTruth::Finer(3.0),
        ..SMALL_SWEEP
    };
    assert!(setup.measure_sweep(&coarser, &broken).unwrap().is_none());
    let screened = lamp_over_floor(true);
    let mut setup = SweepSetup::new(&screened, None, None, &mut store);
    assert!(setup.measure_sweep(&SMALL_SWEEP, &broken).unwrap().is_none());
}
