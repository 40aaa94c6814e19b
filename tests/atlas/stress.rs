//! The failure atlas: its truths agree with each other, its cases are complete, warnings are counted, break points are
//! found, and failures become verdicts.

use common::mesh::Mesh;
use common::scene::Scene;
use glam::DVec3;
use gpu::Gpu;
use oracle::solve::progress::without_progress;
use radiosity::studies::stress::accuracy::error_and_noise;
use radiosity::studies::stress::cases::{CASES, Case};
use radiosity::studies::stress::methods::{AtlasMethod, DEFAULT, MethodSolver, POLYGON};
use radiosity::studies::stress::run::{AtlasRun, run_method};
use radiosity::studies::stress::summary::{Atlas, BreakPoint, CodeCount, WarningCounts, find_breaks};
use radiosity::studies::stress::trial::{Trial, TrialTruth};
use radiosity::studies::stress::truth::{TruthCache, dense_truth};
use radiosity::studies::stress::{AtlasRow, CaseStudy, ErrorMeasure, SolverSide, Verdict};

fn trial_of(name: &str, value: f64) -> (Trial, Vec<DVec3>) {
    let case = CASES.iter().find(|case| case.name == name).unwrap();
    let trial = (case.build)(value).unwrap();
    let truth = TruthCache::default().truth_of(&trial).unwrap();
    (trial, truth)
}

/// Returns the error of one truth against another, on the faces that the case judges.
fn truth_difference(trial: &Trial, a: &[DVec3], b: &[DVec3]) -> f64 {
    error_and_noise(trial, a, b).unwrap().0
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
        let apart = truth_difference(&trial, &truth, &other);
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
        let apart = truth_difference(&trial, &truth, &finer);
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
    let names: Vec<&str> = CASES.iter().map(|case| case.name).collect();
    assert_eq!(names, NEEDED.split(' ').collect::<Vec<_>>());
    for case in CASES {
        let name = case.name;
        let mut values = case.values.to_vec();
        values.sort_by(f64::total_cmp);
        values.dedup();
        assert!(values.len() >= 5, "{name}: {} values", values.len());
        assert!(case.methods.len() >= 4, "{name}: {} methods", case.methods.len());
        assert_eq!(case.methods[0].name, DEFAULT.name, "{name}");
        let [first, last] = [0, case.values.len() - 1].map(|k| (case.build)(case.values[k]).unwrap());
        assert!(first.judged.end <= first.scene.faces.len(), "{name}");
        assert_eq!(first.measure(), case.measure, "{name}");
        let [a, b] = [&first, &last].map(|trial| format!("{:?}", trial.scene.faces));
        assert_ne!(a, b, "{name} has one scene for all values");
    }
}

/// Makes a result: NaN is a refusal.
fn made_side(error: f64, warnings: &[&str]) -> SolverSide {
    SolverSide {
        error: error.is_finite().then_some(error),
        warnings: warnings.iter().map(|w| (*w).to_owned()).collect(),
        message: error.is_nan().then(|| "refused: too large".into()),
        ..SolverSide::default()
    }
}

/// Makes rows of a case: results on the CPU and on the GPU.
fn made_study(measure: ErrorMeasure, sides: &[(f64, SolverSide, SolverSide)]) -> CaseStudy {
    let case = Case { measure, ..CASES[0] };
    let rows = sides
        .iter()
        .map(|(value, cpu, gpu)| AtlasRow::new(&case, *value, DEFAULT.name, cpu.clone(), Some(gpu.clone())));
    CaseStudy {
        case,
        rows: rows.collect(),
        specimens: Vec::new(),
    }
}

#[test]
fn warnings_are_counted_as_caught_missed_and_false() {
    let study = made_study(
        ErrorMeasure::RelativeRms,
        &[
            (1.0, made_side(0.001, &[]), made_side(0.019, &["a"])),
            (2.0, made_side(0.021, &["a", "a", "b"]), made_side(0.5, &[])),
            (3.0, made_side(f64::NAN, &[]), made_side(0.02, &[])),
        ],
    );
    let score = Atlas::new(vec![study], None, 1.0).score;
    let expected = WarningCounts {
        caught: 2,
        missed: 1,
        false_alarms: 1,
        quiet: 2,
    };
    assert_eq!([score.default, score.all], [expected; 2]);
    assert_eq!(score.default.false_alarm_share(), 1.0 / 6.0);
    let code = |code: &str, caught, false_alarms| CodeCount {
        code: code.into(),
        caught,
        false_alarms,
    };
    assert_eq!(score.codes, [code("(refused)", 1, 0), code("a", 1, 1), code("b", 1, 0)]);
}

#[test]
fn break_points_follow_the_order_of_severity() {
    // The method recovers at 4, so that earlier failures do not count.
    let errors = [(1.0, 0.001), (2.0, 0.02), (3.0, 0.05), (4.0, 0.01), (5.0, f64::NAN)];
    let sides = errors.map(|(x, e)| (x, made_side(e, &[]), made_side(0.0, &[])));
    let found = find_breaks(&made_study(ErrorMeasure::RelativeRms, &sides));
    let points = |point: &BreakPoint| [point.degrades_at, point.fails_at];
    assert_eq!(points(&found[0]), [Some(3.0), Some(5.0)]);
    assert_eq!(points(&found[1]), [None, None]);
}

#[test]
fn row_has_error_and_warning_of_worse_solver() {
    let fine = || made_side(0.01, &[]);
    for (cpu, gpu, expected) in [
        (
            made_side(0.3, &[]),
            made_side(0.01, &["a"]),
            (Some(0.3), false, Verdict::Fails),
        ),
        (fine(), made_side(0.05, &["a"]), (Some(0.05), true, Verdict::Degrades)),
        (fine(), made_side(f64::NAN, &[]), (None, true, Verdict::Fails)),
    ] {
        let row = made_study(ErrorMeasure::RelativeRms, &[(1.0, cpu, gpu)]).rows.remove(0);
        assert_eq!((row.error, row.warned, row.verdict), expected);
    }
}

#[test]
fn each_gate_breaks_on_its_violation() {
    let broken = |measure, side: SolverSide| -> Vec<bool> {
        let study = made_study(measure, &[(1.0, side, made_side(0.0, &[]))]);
        let gates = Atlas::new(vec![study], None, 1.0).gates;
        gates.iter().map(|gate| !gate.held).collect()
    };
    // A panic is no refusal: its message has no advice.
    let panicked = SolverSide {
        message: Some("panic: index out of bounds".into()),
        ..made_side(f64::NAN, &[])
    };
    for (side, expected) in [
        (made_side(0.01, &[]), [false; 4]),
        (made_side(0.03, &[]), [false, true, false, false]),
        (made_side(0.03, &["a"]), [false; 4]),
        (made_side(0.01, &["a"]), [false, false, true, false]),
        (panicked, [true, true, false, false]),
    ] {
        assert_eq!(broken(ErrorMeasure::RelativeRms, side), expected);
    }
    let leak = made_side(2e-6, &["a"]);
    assert_eq!(broken(ErrorMeasure::Leak, leak), [false, false, false, true]);
}

#[test]
fn copied_or_incomplete_answers_are_refused() {
    let (trial, truth) = trial_of("closeness", 1.0);
    let refusal = |answer: &[DVec3]| error_and_noise(&trial, answer, &truth).unwrap_err();
    assert!(refusal(&truth).contains("truth itself"));
    assert!(refusal(&truth[1..]).contains("texels instead of"));
    // A furnace's radiosity is known in advance, so an answer may equal it bit for bit.
    let (furnace, known) = trial_of("white-walls", 0.9);
    assert_eq!(error_and_noise(&furnace, &known, &known), Ok((0.0, 0.0)));
    let mut broken = truth.clone();
    broken[3].y = f64::NAN;
    assert!(refusal(&broken).contains("not finite"));
    let black = vec![DVec3::ZERO; truth.len()];
    assert_eq!(error_and_noise(&trial, &black, &truth), Ok((1.0, 0.0)));
}

#[test]
fn refusals_and_panics_become_verdicts() {
    let never = &|| false;
    let (good, truth) = trial_of("closeness", 1.0);
    // A scene without faces, and a solve that panics.
    let none = Trial::new(Scene::default(), 8, TrialTruth::Direct(0..0));
    let (refused, answer) = run_method(&none, &POLYGON, None, &[], never).unwrap();
    assert!(refused.is_warned() && answer.is_none());
    assert!(refused.message.unwrap().contains("has no faces"));
    let mad = AtlasMethod {
        solver: MethodSolver::Shooting,
        change: |s| assert_eq!(s.meshing.patches, 0, "planted"),
        ..DEFAULT
    };
    let panicked = run_method(&good, &mad, None, &truth, never).unwrap().0;
    assert!(panicked.message.as_ref().unwrap().starts_with("panic: "));
    assert!(panicked.is_broken() && !panicked.is_warned());
    assert!(run_method(&good, &POLYGON, None, &truth, &|| true).is_none());
}

#[test]
fn case_has_specimen_with_plates() {
    let run = AtlasRun {
        gpu: None,
        stop: &|| false,
    };
    let case = CASES.iter().find(|case| case.name == "vanishing-face").unwrap();
    let specimen = run.run_case(case, &without_progress()).unwrap().specimens.remove(0);
    assert_eq!(specimen.plates[0].label, "truth");
    assert!(specimen.plates.len() > 4);
    let texels = specimen.texels.pow(2) as usize;
    assert!(specimen.plates.iter().all(|p| p.values.len() == texels));
    assert!(Mesh::uniform(&specimen.scene, 1, 1).is_ok());
}

/// More lamps than the sweep has, for one method: all methods would take a minute on a software GPU.
#[test]
fn three_thousand_lamps_are_within_one_percent() {
    let (trial, truth) = trial_of("lights", 3000.0);
    let side = run_method(&trial, &DEFAULT, None, &truth, &|| false).unwrap().0;
    assert!(side.error.unwrap() < 0.01 && !side.is_warned(), "{side:?}");
}

/// Between very white walls the small closure error of links grows with every bounce, and the answer is warned.
#[test]
fn gpu_warns_of_white_walls() {
    let (trial, truth) = trial_of("white-walls", 0.9999);
    let gpu = Gpu::open(None).unwrap();
    let side = run_method(&trial, &DEFAULT, Some(&gpu), &truth, &|| false).unwrap().0;
    let (error, estimate) = (side.error.unwrap(), side.estimate.unwrap());
    assert!(side.is_warned() && estimate > 0.8 * error, "{side:?}");
}
