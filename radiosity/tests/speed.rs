//! Measurements of `chart`: errors, failures with their reasons, and resuming after an interrupt.

use super::bundled::bundled_scene;
use common::scene::Scene;
use common::settings::{Settings, SolveQuality};
use oracle::solve::dense;
use oracle::solve::progress::{ProgressMonitor, without_progress};
use radiosity::studies::chart::measure::MeasurementSetup;
use radiosity::studies::chart::methods::{SolveMethod, base_settings};
use radiosity::studies::chart::points::{ChartPoint, KeyedStore, SceneChart, collect_points, run_round};
use radiosity::studies::chart::store::{MeasurementContext, MeasurementStore, hash_scene};
use radiosity::studies::chart::truth::ChartTruth;
use radiosity::studies::chart::{SolverKind, json, page, plot};
use std::cell::Cell;
use std::ops::ControlFlow;
use std::path::PathBuf;

const TEXELS: u32 = 4;

fn empty_folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("speed-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn draft_method(scene: &Scene, options: &str, change: impl Fn(&mut Settings)) -> SolveMethod {
    let mut settings = base_settings(scene, SolverKind::Cpu, SolveQuality::Draft, TEXELS);
    change(&mut settings);
    SolveMethod {
        target_error: None,
        solver: SolverKind::Cpu,
        sweep: "test",
        options: options.into(),
        settings,
    }
}

fn own_truth(scene: &Scene, name: &str) -> ChartTruth {
    ChartTruth::solve_truth(scene, TEXELS, &empty_folder(name).join("truth"), &without_progress()).unwrap()
}

fn cpu_bench<'a>(scene: &'a Scene, truth: &'a ChartTruth) -> MeasurementSetup<'a> {
    MeasurementSetup {
        scene,
        gpu: None,
        truth,
        texels: TEXELS,
        time_limit: 60.0,
    }
}

#[test]
fn finer_patches_err_less_and_coarse_texels_are_judged_on_fine_ones() {
    let scene = bundled_scene("cornell_box.obj");
    let truth = own_truth(&scene, "finer");
    let bench = cpu_bench(&scene, &truth);
    let figures = |change: fn(&mut Settings)| {
        let measured = bench
            .measure_method(&draft_method(&scene, "", change), &without_progress())
            .unwrap();
        assert!(measured.total_seconds() > 0.0 && measured.is_sound());
        measured.result.unwrap()
    };
    let base = figures(|_| ());
    let finer = figures(|s| (s.meshing.patches, s.meshing.samples, s.schedule.epsilon) = (4, 16, 1e-4));
    assert!(finer.error < 0.5 * base.error, "{finer:?} {base:?}");
    assert_eq!(base.error, base.own_error);
    assert!(base.imbalance < 1e-3 && base.unshot <= 0.01 && base.linked > 0);
    // On its own texels it is accurate to a few per cent; detail that its texels do not resolve counts as error, too.
    let coarse = figures(|s| (s.meshing.texels, s.meshing.patches, s.meshing.samples) = (1, 1, 64));
    assert!(coarse.error > 2.0 * coarse.own_error, "{coarse:?}");
}

#[test]
fn failed_measurements_have_a_reason() {
    let scene = bundled_scene("furnace.obj");
    let truth = own_truth(&scene, "failures");
    let bench = cpu_bench(&scene, &truth);
    let failure = |bench: &MeasurementSetup, method: &SolveMethod| {
        let measured = bench.measure_method(method, &without_progress()).unwrap();
        assert!(measured.is_sound());
        measured.result.unwrap_err()
    };
    let stopped = draft_method(&scene, "", |s| s.schedule.max_shots = 2);
    assert!(failure(&bench, &stopped).contains("not converged"));
    let itself = SolveMethod {
        solver: SolverKind::Matrix,
        settings: dense::dense_settings(TEXELS),
        ..draft_method(&scene, "", |_| ())
    };
    assert!(failure(&bench, &itself).contains("bit for bit"));
    let nobody = SolveMethod {
        solver: SolverKind::Gpu,
        ..draft_method(&scene, "", |_| ())
    };
    assert!(failure(&bench, &nobody).contains("no adapter"));
    let huge = draft_method(&scene, "", |s| s.meshing.texels = 8000);
    assert!(failure(&bench, &huge).contains("would fit"));
    let hurried = MeasurementSetup {
        time_limit: 1e-9,
        ..bench
    };
    let base = draft_method(&scene, "", |_| ());
    assert!(failure(&hurried, &base).contains("took longer"));
    // The solve stops and does not run on in the background.
    let calls = Cell::new(0);
    let count = |_: &str, _| {
        calls.set(calls.get() + 1);
        ControlFlow::Continue(())
    };
    hurried.measure_method(&base, &ProgressMonitor::new(&count));
    assert!(calls.get() <= 2, "{}", calls.get());
    let asked = hurried.measure_method(&base, &ProgressMonitor::new(&|_, _| ControlFlow::Break(())));
    assert_eq!(asked, None);
}

#[test]
fn truth_of_another_scene_is_refused() {
    let truth = own_truth(&bundled_scene("furnace.obj"), "other");
    assert!(truth.check_scene(&bundled_scene("furnace.obj")).is_ok());
    assert!(truth.check_scene(&bundled_scene("cornell_box.obj")).is_err());
}

fn study_of(points: Vec<ChartPoint>) -> SceneChart {
    SceneChart {
        scene: "a <b> & c".into(),
        faces: 6,
        texels: TEXELS,
        truth: "the matrix".into(),
        adapter: None,
        software: false,
        is_paper_room: true,
        points,
        missing: 0,
        peers: Vec::new(),
    }
}

#[test]
fn interrupted_rounds_resume_and_failures_are_not_repeated() {
    let scene = bundled_scene("furnace.obj");
    let truth = own_truth(&scene, "rounds");
    let bench = cpu_bench(&scene, &truth);
    let methods = [
        draft_method(&scene, "base", |_| ()),
        draft_method(&scene, "--max-shots 2", |s| s.schedule.max_shots = 2),
        draft_method(&scene, "--samples 4", |s| s.meshing.samples = 4),
    ];
    let context = MeasurementContext {
        scene: hash_scene(&scene),
        truth: truth.id,
        program: 1,
        texels_and_limit: (TEXELS, 60.0),
        adapter: String::new(),
    };
    let path = empty_folder("rounds").join("chart.partial.jsonl");
    // Interrupted in the second method: the measurement of the first is kept.
    let mut store = MeasurementStore::open(&path).unwrap();
    let mut kept = KeyedStore {
        store: &mut store,
        context: &context,
    };
    let third = 1.0 / methods.len() as f64;
    let in_second = |_: &str, done| {
        if done > third {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let flow = run_round(&bench, &methods, &mut kept, 0, &ProgressMonitor::new(&in_second)).unwrap();
    assert!(flow.is_break());
    assert_eq!(collect_points(&bench, &methods, &kept, 3).len(), 1);
    // Another process measures only the other methods, and then a second round.
    let mut store = MeasurementStore::open(&path).unwrap();
    let mut kept = KeyedStore {
        store: &mut store,
        context: &context,
    };
    let first = Cell::new(f64::INFINITY);
    let least = |_: &str, done: f64| {
        first.set(first.get().min(done));
        ControlFlow::Continue(())
    };
    let watch = ProgressMonitor::new(&least);
    assert!(run_round(&bench, &methods, &mut kept, 0, &watch).unwrap().is_continue());
    assert!(first.get() >= third, "the first was measured again");
    assert!(run_round(&bench, &methods, &mut kept, 1, &watch).unwrap().is_continue());
    let points = collect_points(&bench, &methods, &kept, 3);
    let runs: Vec<usize> = points.iter().map(|p| p.runs.len()).collect();
    assert_eq!(runs, [2, 1, 2], "a failure is not repeated");
    assert!(points[1].first_failure().is_some() && !points[1].on_front);
    assert!(points[0].on_front || points[2].on_front);
    let told = json::chart_json(&[study_of(points.clone())]);
    assert_eq!(told["points"].as_array().unwrap().len(), 3);
    assert!(told["points"][1]["error"].is_null());
    assert!(told["points"][1]["failure"].as_str().unwrap().contains("not converged"));
    let page = page::render_page(&[study_of(points.clone())]);
    assert!(page.contains("not converged") && page.contains("a &lt;b&gt; &amp; c"));
    assert_eq!(
        plot::draw_scene(&study_of(points)).unwrap().matches("<title>").count(),
        3
    );
}
