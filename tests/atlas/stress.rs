//! The failure atlas: its truths agree with each other, its cases are complete, and failures become verdicts.

use common::scene::Scene;
use glam::DVec3;
use gpu::Gpu;
use oracle::solve::progress::without_progress;
use radiosity::studies::stress::ErrorMeasure;
use radiosity::studies::stress::cases::ALL_CASES;
use radiosity::studies::stress::methods::{AtlasMethod, DEFAULT, MethodSolver, POLYGON};
use radiosity::studies::stress::run::AtlasRun;
use radiosity::studies::stress::trial::{Trial, TrialTruth, TruthCache, dense_truth};

fn trial_of(name: &str, value: f64) -> (Trial, Vec<DVec3>) {
    let case = ALL_CASES.iter().find(|case| case.name == name).unwrap();
    let trial = (case.build)(value).unwrap();
    let truth = TruthCache::default().truth_of(&trial).unwrap();
    (trial, truth)
}

#[test]
fn exact_truths_agree_with_dense_solver_on_easy_values() {
    // Exact Lambert means against the dense solver's form factors differ by quadrature and rounding only. With shadows
    // both clip or sample edges, to a few thousandths.
    let exact = [
        ("closeness", 1.0, 1e-6),
        ("shared-edge", 90.0, 1e-6),
        ("grazing", 0.1, 1e-6),
        ("sliver-shooter", 10.0, 1e-4),
        ("small-shooter", 0.3, 1e-4),
        ("vanishing-face", 0.1, 1e-4),
        ("tessellation", 3.0, 1e-4),
        ("horizon", 0.3, 1e-3),
        ("rim", 0.1, 1e-4),
        ("remote", 10.0, 1e-4),
        ("thin-sheet", 0.1, 1e-4),
        ("non-planar", 0.1, 1e-4),
        ("coplanar", 0.1, 1e-3),
        ("back-face", 0.1, 1e-3),
        ("intersecting", 2.0, 5e-3),
        ("degenerate", 0.1, 1e-3),
        ("slit", 0.3, 1e-3),
        ("blinds", 4.0, 5e-3),
        ("grating", 0.1, 5e-3),
        ("plates", 0.3, 5e-3),
        ("covered-lamp", 0.5, 5e-3),
        ("door", 0.3, 1e-3),
        ("white-walls", 0.9, 1e-3),
        ("power", 1e3, 1e-4),
        ("faint-lamp", 1e-3, 1e-4),
        ("lights", 10.0, 1e-4),
    ];
    for (name, value, tolerance) in exact {
        let (trial, truth) = trial_of(name, value);
        let other = dense_truth(&trial.scene, trial.texels, 1).unwrap();
        let (apart, _) = trial.error_and_noise(&truth, &other).unwrap();
        assert!(apart <= tolerance, "{name}: {apart:e}");
        assert!(truth.iter().any(|v| *v != DVec3::ZERO), "{name} is dark");
    }
}

#[test]
fn refined_truths_have_converged_on_easy_values() {
    // From twice to three times the resolution the truth changes by less than half of the safe limit.
    for (name, value) in [
        ("open", 0.0),
        ("units", 1.0),
        ("object-on-floor", 0.1),
        ("t-vertices", 2.0),
    ] {
        let (trial, truth) = trial_of(name, value);
        let TrialTruth::Dense(scene) = &trial.truth else {
            panic!("{name} has another truth");
        };
        let mut finer = dense_truth(scene, trial.texels, 3).unwrap();
        finer.resize(truth.len(), DVec3::ZERO);
        let (apart, _) = trial.error_and_noise(&truth, &finer).unwrap();
        assert!(apart <= 0.01, "{name}: {apart}");
    }
}

/// Names of all cases, in order.
const NEEDED: &str = "closeness shared-edge grazing sliver-shooter sliver-receiver small-shooter large-texel remote \
    vanishing-face tessellation horizon rim coplanar duplicate intersecting thin-sheet back-face t-vertices non-planar \
    degenerate open slit blinds grating plates covered-lamp door wall cracks white-walls power faint-lamp many-shots ties \
    lights units translation object-on-floor object-sunk object-in-its-shadow object-black object-white object-at-window";

#[test]
fn all_cases_exist_with_wide_sweeps() {
    let names: Vec<&str> = ALL_CASES.iter().map(|case| case.name).collect();
    assert_eq!(names, NEEDED.split(' ').collect::<Vec<_>>());
    for case in ALL_CASES {
        let name = case.name;
        let mut values = case.values.to_vec();
        values.sort_by(f64::total_cmp);
        values.dedup();
        assert!(values.len() >= 5, "{name}: {} values", values.len());
        assert!(case.methods.len() >= 4, "{name}: {} methods", case.methods.len());
        assert_eq!(case.methods[0].name, DEFAULT.name, "{name}");
        let [first, last] = [0, case.values.len() - 1].map(|k| (case.build)(case.values[k]).unwrap());
        assert!(first.judged.end <= first.scene.faces.len(), "{name}");
        let is_dark = matches!(first.truth, TrialTruth::Dark);
        assert_eq!(is_dark, case.measure == ErrorMeasure::Leak, "{name}");
        let [a, b] = [&first, &last].map(|trial| format!("{:?}", trial.scene.faces));
        assert_ne!(a, b, "{name} has one scene for all values");
    }
}

#[test]
fn copied_or_incomplete_answers_are_refused() {
    let (trial, truth) = trial_of("closeness", 1.0);
    let refusal = |answer: &[DVec3]| trial.error_and_noise(answer, &truth).unwrap_err();
    assert!(refusal(&truth).contains("truth itself"));
    assert!(refusal(&truth[1..]).contains("texels instead of"));
    // A furnace's radiosity is known in advance, so an answer may equal it bit for bit.
    let (furnace, known) = trial_of("white-walls", 0.9);
    assert_eq!(furnace.error_and_noise(&known, &known), Ok((0.0, 0.0)));
    let mut broken = truth.clone();
    broken[3].y = f64::NAN;
    assert!(refusal(&broken).contains("not finite"));
    let black = vec![DVec3::ZERO; truth.len()];
    assert_eq!(trial.error_and_noise(&black, &truth), Ok((1.0, 0.0)));
}

#[test]
fn refusals_and_panics_become_verdicts() {
    let run = AtlasRun::default();
    let (good, truth) = trial_of("closeness", 1.0);
    // A scene without faces, and a solve that panics.
    let none = Trial::new(Scene::default(), 8, TrialTruth::Direct(0..0));
    let (refused, answer) = run.run_method(&none, &POLYGON, None, &[]).unwrap();
    assert!(refused.is_warned() && answer.is_none());
    assert!(refused.message.unwrap().contains("has no faces"));
    let mad = AtlasMethod {
        solver: MethodSolver::Shooting,
        change: |s| assert_eq!(s.meshing.patches, 0, "planted"),
        ..DEFAULT
    };
    let panicked = run.run_method(&good, &mad, None, &truth).unwrap().0;
    assert!(panicked.message.as_ref().unwrap().starts_with("panic: "));
    assert!(panicked.is_broken() && !panicked.is_warned());
    let stopped = AtlasRun { stop: &|| true, ..run };
    assert!(stopped.run_method(&good, &POLYGON, None, &truth).is_none());
}

/// The scene shown is the easiest, and its solution belongs to it.
#[test]
fn case_shows_its_easiest_scene() {
    let run = AtlasRun::default();
    let case = ALL_CASES.iter().find(|case| case.name == "vanishing-face").unwrap();
    let study = run.run_case(case, &without_progress()).unwrap();
    let [specimen] = &study.specimens[..] else {
        panic!("{} specimens", study.specimens.len());
    };
    assert_eq!(
        (specimen.value, Some(specimen.error)),
        (case.values[0], study.rows[0].error)
    );
    let faces = (case.build)(specimen.value).unwrap().scene.faces;
    assert_eq!(format!("{:?}", specimen.scene.faces), format!("{faces:?}"));
    assert_eq!(specimen.field.irradiance.len(), specimen.mesh.texels.len());
}

/// More lamps than the sweep has, for one method: all methods would take a minute on a software GPU.
#[test]
fn three_thousand_lamps_are_within_one_percent() {
    let (trial, truth) = trial_of("lights", 3000.0);
    let side = AtlasRun::default()
        .run_method(&trial, &DEFAULT, None, &truth)
        .unwrap()
        .0;
    assert!(side.error.unwrap() < 0.01 && !side.is_warned(), "{side:?}");
}

/// Between very white walls the small closure error of links grows with every bounce, and the answer is warned.
#[test]
fn gpu_warns_of_white_walls() {
    let (trial, truth) = trial_of("white-walls", 0.9999);
    let gpu = Gpu::open(None).unwrap();
    let side = AtlasRun::default()
        .run_method(&trial, &DEFAULT, Some(&gpu), &truth)
        .unwrap()
        .0;
    let (error, estimate) = (side.error.unwrap(), side.estimate.unwrap());
    assert!(side.is_warned() && estimate > 0.8 * error, "{side:?}");
}
