//! Measurements of `chart`: errors, orders of convergence, failures with their reasons, resuming after an interrupt.

use common::scene::{Face, Scene};
use common::settings::{Settings, SolveQuality};
use glam::{DVec3, Vec3};
use gpu::Gpu;
use oracle::solve::dense;
use oracle::solve::solver::SolverKind;
use radiosity::studies::chart::bench::ChartBench;
use radiosity::studies::chart::methods::{SolveMethod, base_settings};
use radiosity::studies::chart::page::render_page;
use radiosity::studies::chart::points::{ChartPoint, MeasuredSet, SceneChart};
use radiosity::studies::chart::store::{Measurement, MeasurementStore, SolveFigures};
use radiosity::studies::chart::sweeps::{EPSILON_SWEEP, MethodSet, Sweep, SweepTruth, TEXEL_SWEEP};
use radiosity_tests::radiance_files::empty_folder;
use radiosity_tests::{bundled_scene, named_scene};
use std::cell::Cell;
use std::collections::HashSet;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

const TEXELS: u32 = 4;

/// Makes a bench on the CPU, which measures errors on N×N texels if they are given.
fn cpu_bench<'a>(scene: &'a Scene, dir: &'a Path, texels: Option<u32>) -> ChartBench<'a> {
    ChartBench {
        scene,
        gpu: None,
        dir,
        program: 1,
        texels,
        time_limit: 60.0,
        repeats: 1,
    }
}

/// Measures a set with the store in the folder of the bench.
fn measure_set(bench: &ChartBench, set: &MethodSet, show: &dyn Fn(&str, f64) -> ControlFlow<()>) -> MeasuredSet {
    let mut store = MeasurementStore::open(&bench.dir.join("store.json")).unwrap();
    bench.measure_set(set, &mut store, show).unwrap()
}

fn set_of(methods: Vec<SolveMethod>) -> MethodSet {
    MethodSet {
        sweep: None,
        truth: SolveMethod::new(SolverKind::Dense, "the dense solver", dense::dense_settings(TEXELS)),
        methods,
    }
}

fn measure_method(bench: &ChartBench, method: SolveMethod) -> Measurement {
    measure_set(bench, &set_of(vec![method]), &proceed)
        .points
        .remove(0)
        .measurement
}

fn proceed(_: &str, _: f64) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn stop(_: &str, _: f64) -> ControlFlow<()> {
    ControlFlow::Break(())
}

/// Stops once this share of the methods is measured.
fn stop_after(share: f64) -> impl Fn(&str, f64) -> ControlFlow<()> {
    move |phase, done| match phase != "truth" && done > share {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    }
}

fn draft_method(scene: &Scene, options: &str, change: impl Fn(&mut Settings)) -> SolveMethod {
    let mut settings = base_settings(scene, SolverKind::Cpu, SolveQuality::Draft, TEXELS);
    change(&mut settings);
    SolveMethod::new(SolverKind::Cpu, options, settings)
}

#[test]
fn finer_patches_err_less_and_coarse_texels_are_judged_on_fine_ones() {
    let (scene, dir) = (bundled_scene("cornell_box.obj"), empty_folder("finer"));
    let figures = |texels, change: fn(&mut Settings)| -> SolveFigures {
        let measured = measure_method(&cpu_bench(&scene, &dir, texels), draft_method(&scene, "", change));
        assert!(measured.seconds > 0.0);
        measured.result.unwrap()
    };
    let base = figures(Some(TEXELS), |_| ());
    let finer = figures(Some(TEXELS), |s| {
        (s.meshing.patches, s.meshing.samples, s.schedule.epsilon) = (4, 16, 1e-4);
    });
    assert!(finer.error < 0.5 * base.error, "{finer:?} {base:?}");
    // On its own texels it is accurate to a few per cent; detail that its texels do not resolve counts as error, too.
    let coarse: fn(&mut Settings) = |s| (s.meshing.texels, s.meshing.patches, s.meshing.samples) = (1, 1, 64);
    let [fine_error, own_error] = [Some(TEXELS), None].map(|texels| figures(texels, coarse).error);
    assert!(fine_error > 2.0 * own_error, "{fine_error} {own_error}");
}

#[test]
fn failed_measurements_have_a_reason() {
    let (scene, dir) = (bundled_scene("furnace.obj"), empty_folder("failures"));
    let draft = |change: fn(&mut Settings)| draft_method(&scene, "", change);
    let nobody = SolveMethod {
        solver: SolverKind::Gpu,
        ..draft(|_| ())
    };
    let itself = SolveMethod::new(SolverKind::Dense, "", dense::dense_settings(TEXELS));
    let cases = [
        (draft(|s| s.schedule.max_shots = 2), 60.0, "not converged"),
        (itself, 60.0, "bit for bit"),
        (nobody, 60.0, "no adapter"),
        (draft(|s| s.meshing.texels = 8000), 60.0, "would fit"),
        (draft(|_| ()), 1e-9, "took longer"),
    ];
    let bench = cpu_bench(&scene, &dir, Some(TEXELS));
    for (method, time_limit, reason) in cases {
        let measured = measure_method(&ChartBench { time_limit, ..bench }, method);
        let failure = measured.result.unwrap_err();
        assert!(failure.contains(reason), "{failure}");
    }
    // A solve that takes too long stops and does not run on in the background.
    let calls = Cell::new(0);
    let count = |phase: &str, _| {
        calls.set(calls.get() + u32::from(phase != "truth"));
        ControlFlow::Continue(())
    };
    let hurried = ChartBench {
        time_limit: 2e-9,
        ..bench
    };
    measure_set(&hurried, &set_of(vec![draft(|_| ())]), &count);
    assert!((1..=2).contains(&calls.get()), "{}", calls.get());
}

#[test]
fn interrupted_chart_resumes_and_failures_are_not_repeated() {
    let (scene, dir) = (bundled_scene("furnace.obj"), empty_folder("rounds"));
    let bench = ChartBench {
        repeats: 2,
        ..cpu_bench(&scene, &dir, Some(TEXELS))
    };
    let methods = [
        draft_method(&scene, "base", |_| ()),
        draft_method(&scene, "--max-shots 2", |s| s.schedule.max_shots = 2),
        draft_method(&scene, "--samples 4", |s| s.meshing.samples = 4),
    ];
    let set = set_of(methods.into());
    // Interrupted in the second method: the measurement of the first is kept.
    let third = 1.0 / 3.0;
    let begun = measure_set(&bench, &set, &stop_after(third));
    assert_eq!((begun.points.len(), begun.missing), (1, 2));
    // Another process measures only the other methods; the truth is kept, too.
    let first = Cell::new(f64::INFINITY);
    let least = |phase: &str, done: f64| {
        assert_ne!(phase, "truth");
        first.set(first.get().min(done));
        ControlFlow::Continue(())
    };
    let measured = measure_set(&bench, &set, &least);
    assert!(first.get() >= third, "the first was measured again");
    assert_eq!(
        measured.points[0],
        ChartPoint {
            on_front: measured.points[0].on_front,
            ..begun.points[0].clone()
        }
    );
    // Every solve would be stopped: the failure is not repeated.
    assert_eq!(measure_set(&bench, &set, &stop).points, measured.points);
    assert!(measured.points[1].solve_figures().is_none() && !measured.points[1].on_front);
    assert!(measured.points[0].on_front || measured.points[2].on_front);
    let page = render_page(&[SceneChart {
        scene: "a <b> & c".into(),
        sets: vec![measured],
        ..SceneChart::default()
    }]);
    assert!(page.contains("not converged") && page.contains("a &lt;b&gt; &amp; c"));
}

#[test]
fn every_condition_of_a_measurement_changes_its_key() {
    let (scene, other, dir) = (lamp_over_floor(false), lamp_over_floor(true), PathBuf::new());
    let gpu = Gpu::open(None).unwrap();
    let bench = cpu_bench(&scene, &dir, Some(16));
    let method = SolveMethod::new(SolverKind::Gpu, "", Settings::default());
    let with = |change: fn(&mut SolveMethod)| {
        let mut changed = method.clone();
        change(&mut changed);
        changed
    };
    let on_cpu = with(|method| method.solver = SolverKind::Cpu);
    let on_gpu = ChartBench {
        gpu: Some(&gpu),
        ..bench
    };
    let keys = [
        bench.measurement_key(&method, "a"),
        bench.measurement_key(&method, "b"),
        on_gpu.measurement_key(&method, "a"),
        ChartBench { scene: &other, ..bench }.measurement_key(&method, "a"),
        ChartBench { program: 9, ..bench }.measurement_key(&method, "a"),
        ChartBench {
            texels: Some(8),
            ..bench
        }
        .measurement_key(&method, "a"),
        ChartBench {
            time_limit: 30.0,
            ..bench
        }
        .measurement_key(&method, "a"),
        ChartBench { repeats: 3, ..bench }.measurement_key(&method, "a"),
        bench.measurement_key(&on_cpu, "a"),
        bench.measurement_key(&with(|method| method.settings.meshing.samples = 5), "a"),
        bench.measurement_key(&with(|method| method.target_error = Some(0.01)), "a"),
    ];
    assert_eq!(keys.iter().collect::<HashSet<_>>().len(), keys.len());
    // The GPU's name is no part of a CPU key, and words are of none.
    assert_eq!(on_gpu.measurement_key(&on_cpu, "a"), keys[8]);
    assert_eq!(
        bench.measurement_key(&with(|method| method.options = "words".into()), "a"),
        keys[0]
    );
}

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
    named_scene("lamp over floor", faces)
}

#[test]
fn errors_converge_at_the_orders_of_theory() {
    let texels = Sweep {
        truth: SweepTruth::Finer(128.0),
        // The unshot power must be negligible beside the error of the texels.
        base: |settings| settings.schedule.epsilon = 1e-6,
        curves: &TEXEL_SWEEP.curves[..1],
        ..TEXEL_SWEEP
    };
    let epsilon = Sweep {
        values: &[0.1, 0.03, 0.01, 0.003],
        base: |settings| settings.meshing.texels = 8,
        ..EPSILON_SWEEP
    };
    let mut bright = lamp_over_floor(false);
    for face in &mut bright.faces {
        face.reflectance = Vec3::splat(0.9);
        face.corners = face.corners.map(|c| DVec3::new(3.0 * c.x, c.y, 3.0 * c.z));
    }
    let cases = [
        // The mean of a smooth H over a texel is H(centroid) + h²/24 ∇²H + …; patches as large as texels at N = 4, and
        // the truth's own error of 1/1024, blur the order.
        ("open", lamp_over_floor(false), texels, 1.8..2.3),
        // A shadow's edge crosses O(1/h) of O(1/h²) texels, each with an error of O(1): the RMS is O(√h). The position of
        // the edge among the centres is random: a tenth either way over four points.
        ("screened", lamp_over_floor(true), texels, 0.4..1.2),
        // The unshot power is missing: about ε of the light, and up to 1/(1 − ρ) times that.
        ("bright", bright, epsilon, 0.7..1.3),
    ];
    for (name, scene, sweep, expected) in cases {
        let dir = empty_folder(name);
        let measured = measure_set(&cpu_bench(&scene, &dir, None), &sweep.method_set(false), &proceed);
        let order = measured.curve_order(&measured.points).unwrap();
        assert!(expected.contains(&order), "{name}: {order} {:?}", measured.points);
        if name == "open" {
            assert!(measured.curve_order(&measured.points[2..]).unwrap() > 1.0);
        }
    }
}

#[test]
fn curve_stops_falling_at_the_error_of_another_parameter() {
    // The truth has 4×4 patches; points with one patch a face stop at the error of that patch.
    let (scene, dir) = (lamp_over_floor(true), empty_folder("floor"));
    let sweep = Sweep {
        base: |settings| (settings.meshing.texels, settings.meshing.patches) = (4, 1),
        values: &[0.01, 0.001, 0.0001],
        truth: SweepTruth::Limit("fine", |settings| settings.meshing.patches = 4),
        ..EPSILON_SWEEP
    };
    let set = measure_set(&cpu_bench(&scene, &dir, None), &sweep.method_set(false), &proceed);
    assert_eq!(set.truth, "fine");
    let order = set.curve_order(&set.points[1..]).unwrap();
    assert!(order.abs() < 0.1, "{order} {:?}", set.points);
    assert!(set.points[2].time_and_error()[1] > 0.005, "{:?}", set.points);
}
