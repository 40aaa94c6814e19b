//! Measurements of `chart`: errors, orders of convergence, failures with their reasons, resuming after an interrupt.

use super::bundled::bundled_scene;
use common::scene::{Face, Scene};
use common::settings::{Settings, SolveQuality};
use common::solution::StoredSolution;
use glam::{DVec3, Vec3};
use oracle::solve::dense;
use radiosity::studies::chart::bench::ChartBench;
use radiosity::studies::chart::json::chart_json;
use radiosity::studies::chart::methods::{SolveMethod, SolverKind, base_settings};
use radiosity::studies::chart::page::{render_page, titled_plots};
use radiosity::studies::chart::points::SceneChart;
use radiosity::studies::chart::store::{Measurement, MeasurementContext, MeasurementStore, SolveFigures, hash_scene};
use radiosity::studies::chart::sweeps::{EPSILON_SWEEP, PATCH_SWEEP, Sweep, SweepTruth, TEXEL_SWEEP};
use std::cell::Cell;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

const TEXELS: u32 = 4;

fn empty_folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("study-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// A bench on the CPU, which errs on N×N texels if they are given, and its folder's store.
struct Trial<'a> {
    scene: &'a Scene,
    dir: &'a Path,
    texels: Option<u32>,
    time_limit: f64,
}

impl<'a> Trial<'a> {
    fn new(scene: &'a Scene, dir: &'a Path, texels: Option<u32>) -> Self {
        Self {
            scene,
            dir,
            texels,
            time_limit: 60.0,
        }
    }

    /// Measures what `add` adds to a bench.
    fn measure(
        &self,
        rounds: usize,
        add: impl FnOnce(&mut ChartBench),
        show: &dyn Fn(&str, f64) -> ControlFlow<()>,
    ) -> SceneChart {
        let mut store = MeasurementStore::open(&self.dir.join("store.jsonl")).unwrap();
        let context = MeasurementContext {
            scene: hash_scene(self.scene),
            program: 1,
            texels: self.texels,
            time_limit: self.time_limit,
            adapter: None,
        };
        let mut bench = ChartBench::new(self.scene, None, &mut store, context, self.dir);
        add(&mut bench);
        bench.measure_rounds(rounds, show, &mut |_| Ok(())).unwrap()
    }

    /// Measures one method once.
    fn measure_method(&self, method: &SolveMethod) -> Measurement {
        let add = |bench: &mut ChartBench| bench.add_methods(vec![method.clone()], TEXELS);
        self.measure(1, add, &proceed).points[0].runs[0].clone()
    }
}

fn proceed(_: &str, _: f64) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn stop(_: &str, _: f64) -> ControlFlow<()> {
    ControlFlow::Break(())
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
        let measured = Trial::new(&scene, &dir, texels).measure_method(&draft_method(&scene, "", change));
        assert!(measured.total_seconds() > 0.0 && measured.is_sound());
        measured.result.unwrap()
    };
    let base = figures(Some(TEXELS), |_| ());
    let finer = figures(Some(TEXELS), |s| {
        (s.meshing.patches, s.meshing.samples, s.schedule.epsilon) = (4, 16, 1e-4);
    });
    assert!(finer.error < 0.5 * base.error, "{finer:?} {base:?}");
    assert!(base.imbalance < 1e-3);
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
    for (method, time_limit, reason) in cases {
        let trial = Trial {
            time_limit,
            ..Trial::new(&scene, &dir, Some(TEXELS))
        };
        let measured = trial.measure_method(&method);
        assert!(measured.is_sound());
        let failure = measured.result.unwrap_err();
        assert!(failure.contains(reason), "{failure}");
    }
    // A solve that takes too long stops and does not run on in the background.
    let trial = Trial {
        time_limit: 2e-9,
        ..Trial::new(&scene, &dir, Some(TEXELS))
    };
    let calls = Cell::new(0);
    let count = |phase: &str, _| {
        calls.set(calls.get() + u32::from(phase != "truth"));
        ControlFlow::Continue(())
    };
    let base = draft(|_| ());
    trial.measure(1, |bench| bench.add_methods(vec![base], TEXELS), &count);
    assert!(calls.get() <= 2, "{}", calls.get());
}

#[test]
fn interrupted_rounds_resume_and_failures_are_not_repeated() {
    let (scene, dir) = (bundled_scene("furnace.obj"), empty_folder("rounds"));
    let trial = Trial::new(&scene, &dir, Some(TEXELS));
    let add = |bench: &mut ChartBench| {
        let methods = [
            draft_method(&scene, "base", |_| ()),
            draft_method(&scene, "--max-shots 2", |s| s.schedule.max_shots = 2),
            draft_method(&scene, "--samples 4", |s| s.meshing.samples = 4),
        ];
        bench.add_methods(methods.to_vec(), TEXELS);
    };
    // Interrupted in the second method: the measurement of the first is kept.
    let third = 1.0 / 3.0;
    let in_second = |phase: &str, done| match phase != "truth" && done > third {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    };
    let chart = trial.measure(3, add, &in_second);
    assert_eq!((chart.points.len(), chart.missing), (1, 2));
    // Another process measures only the other methods, and then a second round; the truth is kept, too.
    let first = Cell::new(f64::INFINITY);
    let least = |phase: &str, done: f64| {
        assert!(phase.starts_with("round"), "{phase}");
        first.set(first.get().min(done));
        ControlFlow::Continue(())
    };
    trial.measure(1, add, &least);
    assert!(first.get() >= third, "the first was measured again");
    let mut chart = trial.measure(2, add, &least);
    let runs: Vec<usize> = chart.points.iter().map(|p| p.runs.len()).collect();
    assert_eq!(runs, [2, 1, 2], "a failure is not repeated");
    assert!(chart.points[1].first_result().is_err() && !chart.points[1].on_front);
    assert!(chart.points[0].on_front || chart.points[2].on_front);
    chart.scene = "a <b> & c".into();
    let told = chart_json(std::slice::from_ref(&chart));
    assert_eq!(told["points"].as_array().unwrap().len(), 3);
    assert!(told["points"][1]["error"].is_null());
    assert!(told["points"][1]["failure"].as_str().unwrap().contains("not converged"));
    let page = render_page(std::slice::from_ref(&chart));
    assert!(page.contains("not converged") && page.contains("a &lt;b&gt; &amp; c"));
    let svg = titled_plots(&[chart])[0].1.render_svg().unwrap();
    assert_eq!(svg.matches("<title>").count(), 3);
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
    Scene {
        name: "lamp over floor".into(),
        faces,
        notes: Vec::new(),
    }
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
        let chart = Trial::new(&scene, &dir, None).measure(1, |bench| bench.add_sweep(&sweep), &proceed);
        let order = chart.curves[0].order.unwrap();
        assert!(expected.contains(&order), "{name}: {order} {:?}", chart.points);
        if name == "open" {
            assert!(chart.curves[0].last_order.unwrap() > 1.0);
        }
    }
}

/// A sweep that takes milliseconds.
const SMALL_SWEEP: Sweep = Sweep {
    base: |settings| settings.meshing.texels = 4,
    values: &[1.0, 2.0, 3.0],
    truth: SweepTruth::Finer(4.0),
    ..PATCH_SWEEP
};

#[test]
fn curve_stops_falling_at_the_error_of_another_parameter() {
    // The truth has 4×4 patches; points with one patch a face stop at the error of that patch.
    let (scene, dir) = (lamp_over_floor(true), empty_folder("floor"));
    let trial = Trial::new(&scene, &dir, None);
    trial.measure(1, |bench| bench.add_sweep(&SMALL_SWEEP), &proceed);
    let truths = std::fs::read_dir(&dir).unwrap().map(|entry| entry.unwrap().path());
    let truth = truths.filter(|path| path.is_dir()).collect::<Vec<_>>();
    let stored = StoredSolution::read(&truth[0]).unwrap();
    let sweep = Sweep {
        base: |settings| (settings.meshing.texels, settings.meshing.patches) = (4, 1),
        values: &[0.01, 0.001, 0.0001],
        ..EPSILON_SWEEP
    };
    let chart = trial.measure(
        1,
        |bench| {
            bench.use_given_truth("given", &stored);
            bench.add_sweep(&sweep);
        },
        &proceed,
    );
    let curve = &chart.curves[0];
    assert_eq!(curve.truth, "given");
    assert!(curve.last_order.unwrap().abs() < 0.1, "{curve:?} {:?}", chart.points);
    assert!(chart.points[2].time_and_error()[1] > 0.005, "{:?}", chart.points);
    for (truth, fits) in [(lamp_over_floor(true), true), (lamp_over_floor(false), false)] {
        assert_eq!(ChartBench::check_truth(&truth, &stored).is_ok(), fits);
    }
}

#[test]
fn stored_points_of_a_curve_are_reported_and_not_solved_again() {
    let (scene, dir) = (lamp_over_floor(false), empty_folder("curves"));
    let trial = Trial::new(&scene, &dir, None);
    let add = |bench: &mut ChartBench| bench.add_sweep(&SMALL_SWEEP);
    // Interrupted after two of six points.
    let until = |phase: &str, done| match phase != "truth" && done > 2.0 / 6.0 {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    };
    assert!(trial.measure(1, add, &stop).points.is_empty());
    let chart = trial.measure(1, add, &until);
    assert_eq!((chart.points.len(), chart.missing, chart.curves.len()), (2, 4, 2));
    let page = render_page(std::slice::from_ref(&chart));
    for wanted in ["<svg", "--patches", "polygon", "4 points were not measured"] {
        assert!(page.contains(wanted), "{wanted}");
    }
    assert!(!page.contains("http"), "the page needs the network");
    let measured = chart_json(&[trial.measure(1, add, &proceed)]);
    assert_eq!(measured["points"].as_array().unwrap().len(), 6);
    assert!(measured["points"][0]["error"].as_f64().unwrap() > 0.0);
    // Every solve would be stopped.
    assert_eq!(chart_json(&[trial.measure(1, add, &stop)]), measured);
    // Against another truth, or in another scene, no stored point counts.
    let coarser = Sweep {
        truth: SweepTruth::Finer(3.0),
        ..SMALL_SWEEP
    };
    assert!(
        trial
            .measure(1, |bench| bench.add_sweep(&coarser), &stop)
            .points
            .is_empty()
    );
    let screened = lamp_over_floor(true);
    assert!(
        Trial::new(&screened, &dir, None)
            .measure(1, add, &stop)
            .points
            .is_empty()
    );
}
