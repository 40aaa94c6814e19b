//! The chart measures what it says, keeps what fails, and takes up what is measured.

use super::bundled::bundled;
use common::scene::Scene;
use common::settings::{Quality, Settings};
use oracle::solve::dense;
use oracle::solve::watch::{Watch, unwatched};
use oracle::study::chart::measure::Bench;
use oracle::study::chart::methods::{Method, base};
use oracle::study::chart::store::{Context, Store, content};
use oracle::study::chart::study::{Kept, Point, Study, points, round};
use oracle::study::chart::truth::Truth;
use oracle::study::chart::{Solver, json, page, plot};
use std::cell::Cell;
use std::ops::ControlFlow;
use std::path::PathBuf;

const TEXELS: u32 = 4;

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("speed-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn method(scene: &Scene, options: &str, change: impl Fn(&mut Settings)) -> Method {
    let mut settings = base(scene, Solver::Cpu, Quality::Draft, TEXELS);
    change(&mut settings);
    Method {
        asked: None,
        solver: Solver::Cpu,
        sweep: "test",
        options: options.into(),
        settings,
    }
}

fn truth(scene: &Scene, name: &str) -> Truth {
    Truth::own(scene, TEXELS, &folder(name).join("truth"), &unwatched()).unwrap()
}

fn bench<'a>(scene: &'a Scene, truth: &'a Truth) -> Bench<'a> {
    Bench {
        scene,
        gpu: None,
        truth,
        texels: TEXELS,
        longest: 60.0,
    }
}

#[test]
fn finer_cells_err_less_and_coarse_texels_are_judged_on_those_asked_for() {
    let scene = bundled("cornell_box.obj");
    let truth = truth(&scene, "finer");
    let bench = bench(&scene, &truth);
    let figures = |change: fn(&mut Settings)| {
        let measured = bench
            .measure(&method(&scene, "", change), &unwatched())
            .unwrap();
        assert!(measured.seconds() > 0.0 && measured.is_sound());
        measured.result.unwrap()
    };
    let base = figures(|_| ());
    let finer =
        figures(|s| (s.meshing.cells, s.meshing.samples, s.schedule.epsilon) = (4, 16, 1e-4));
    assert!(finer.error < 0.5 * base.error, "{finer:?} {base:?}");
    assert_eq!(base.error, base.own_error);
    assert!(base.imbalance < 1e-3 && base.unshot <= 0.01 && base.linked > 0);
    // On its own texels it is right to a few per cent; what it does not resolve counts, too.
    let coarse = figures(|s| (s.meshing.texels, s.meshing.cells, s.meshing.samples) = (1, 1, 64));
    assert!(coarse.error > 2.0 * coarse.own_error, "{coarse:?}");
}

#[test]
fn each_failure_has_its_reason() {
    let scene = bundled("furnace.obj");
    let truth = truth(&scene, "failures");
    let bench = bench(&scene, &truth);
    let failure = |bench: &Bench, method: &Method| {
        let measured = bench.measure(method, &unwatched()).unwrap();
        assert!(measured.is_sound());
        measured.result.unwrap_err()
    };
    let stopped = method(&scene, "", |s| s.schedule.max_shots = 2);
    assert!(failure(&bench, &stopped).contains("not converged"));
    let itself = Method {
        solver: Solver::Matrix,
        settings: dense::settings(TEXELS),
        ..method(&scene, "", |_| ())
    };
    assert!(failure(&bench, &itself).contains("bit for bit"));
    let nobody = Method {
        solver: Solver::Gpu,
        ..method(&scene, "", |_| ())
    };
    assert!(failure(&bench, &nobody).contains("no adapter"));
    let huge = method(&scene, "", |s| s.meshing.texels = 8000);
    assert!(failure(&bench, &huge).contains("would fit"));
    let hurried = Bench {
        longest: 1e-9,
        ..bench
    };
    let base = method(&scene, "", |_| ());
    assert!(failure(&hurried, &base).contains("took longer"));
    // It does not go on behind our back.
    let calls = Cell::new(0);
    let count = |_: &str, _| {
        calls.set(calls.get() + 1);
        ControlFlow::Continue(())
    };
    hurried.measure(&base, &Watch::new(&count));
    assert!(calls.get() <= 2, "{}", calls.get());
    let asked = hurried.measure(&base, &Watch::new(&|_, _| ControlFlow::Break(())));
    assert_eq!(asked, None);
}

#[test]
fn a_truth_of_another_scene_is_refused() {
    let truth = truth(&bundled("furnace.obj"), "other");
    assert!(truth.check(&bundled("furnace.obj")).is_ok());
    assert!(truth.check(&bundled("cornell_box.obj")).is_err());
}

fn study(points: Vec<Point>) -> Study {
    Study {
        scene: "a <b> & c".into(),
        faces: 6,
        texels: TEXELS,
        truth: "the matrix".into(),
        adapter: None,
        software: false,
        paper: true,
        points,
        missing: 0,
        peers: Vec::new(),
    }
}

#[test]
fn rounds_go_on_where_they_stopped_and_failures_stay() {
    let scene = bundled("furnace.obj");
    let truth = truth(&scene, "rounds");
    let bench = bench(&scene, &truth);
    let methods = [
        method(&scene, "base", |_| ()),
        method(&scene, "--max-shots 2", |s| s.schedule.max_shots = 2),
        method(&scene, "--samples 4", |s| s.meshing.samples = 4),
    ];
    let context = Context {
        scene: content(&scene),
        truth: truth.id,
        program: 1,
        asked: (TEXELS, 60.0),
        adapter: String::new(),
    };
    let path = folder("rounds").join("chart.partial.jsonl");
    // Interrupted in the second method: the first is kept.
    let mut store = Store::open(&path).unwrap();
    let mut kept = Kept {
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
    let flow = round(&bench, &methods, &mut kept, 0, &Watch::new(&in_second)).unwrap();
    assert!(flow.is_break());
    assert_eq!(points(&bench, &methods, &kept, 3).len(), 1);
    // Another process goes on with the others only, and with a second round.
    let mut store = Store::open(&path).unwrap();
    let mut kept = Kept {
        store: &mut store,
        context: &context,
    };
    let first = Cell::new(f64::INFINITY);
    let least = |_: &str, done: f64| {
        first.set(first.get().min(done));
        ControlFlow::Continue(())
    };
    let watch = Watch::new(&least);
    assert!(
        round(&bench, &methods, &mut kept, 0, &watch)
            .unwrap()
            .is_continue()
    );
    assert!(first.get() >= third, "the first was measured again");
    assert!(
        round(&bench, &methods, &mut kept, 1, &watch)
            .unwrap()
            .is_continue()
    );
    let points = points(&bench, &methods, &kept, 3);
    let runs: Vec<usize> = points.iter().map(|p| p.runs.len()).collect();
    assert_eq!(runs, [2, 1, 2], "a failure is not repeated");
    assert!(points[1].failure().is_some() && !points[1].on_front);
    assert!(points[0].on_front || points[2].on_front);
    let told = json::json(&[study(points.clone())]);
    assert_eq!(told["points"].as_array().unwrap().len(), 3);
    assert!(told["points"][1]["error"].is_null());
    assert!(
        told["points"][1]["failure"]
            .as_str()
            .unwrap()
            .contains("not converged")
    );
    let page = page::html(&[study(points.clone())]);
    assert!(page.contains("not converged") && page.contains("a &lt;b&gt; &amp; c"));
    assert_eq!(
        plot::svg(&study(points))
            .unwrap()
            .matches("<title>")
            .count(),
        3
    );
}
