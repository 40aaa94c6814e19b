//! The failure atlas: its truths agree with each other, its cases are complete, warnings are counted, break points are
//! found, and failures become verdicts.

use approx::abs_diff_eq;
use common::mesh::Mesh;
use common::scene::Scene;
use glam::DVec3;
use gpu::Gpu;
use oracle::solve::progress::without_progress;
use radiosity::studies::stress::accuracy::error_and_noise;
use radiosity::studies::stress::breaks::{self, SafeRange};
use radiosity::studies::stress::gates;
use radiosity::studies::stress::measure::run_method;
use radiosity::studies::stress::methods::{self, AtlasMethod, MethodKind};
use radiosity::studies::stress::run::{AtlasRun, make_row};
use radiosity::studies::stress::score::{self, WarningCounts};
use radiosity::studies::stress::trial::{Case, MethodSuite, Trial, TrialTruth};
use radiosity::studies::stress::{
    AtlasRow, CaseInfo, CaseStudy, LEAK_MEASURE, RELATIVE_RMS, SolverSide, Verdict, cases, truth,
};

fn case_named(name: &str) -> &'static Case {
    let all = cases::all_cases();
    all.into_iter().find(|c| c.info.name == name).unwrap()
}

fn method_named(suite: MethodSuite, name: &str) -> AtlasMethod {
    let all = methods::methods_of(suite);
    all.into_iter().find(|m| m.name == name).unwrap()
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
        let trial = (case_named(name).build)(value).unwrap();
        let told = truth::single_truth(&trial).unwrap();
        let other = truth::dense_truth(&trial.scene, trial.texels, 1).unwrap();
        let apart = truth_difference(&trial, &told, &other);
        assert!(apart <= tolerance, "{name}: {apart:e}");
        assert!(told.iter().any(|v| *v != DVec3::ZERO), "{name} is dark");
    }
}

#[test]
fn refined_truths_have_converged_on_easy_values() {
    // From twice to three times the resolution the truth changes by less than half of the safe limit.
    let easy = [
        ("open", 0.0),
        ("units", 1.0),
        ("object-on-floor", 0.1),
        ("t-vertices", 2.0),
    ];
    for (name, value) in easy {
        let trial = (case_named(name).build)(value).unwrap();
        let (scene, finer) = match &trial.truth {
            TrialTruth::Matrix(finer) => (&trial.scene, *finer),
            TrialTruth::Alike(scene, finer) => (scene, *finer),
            _ => panic!("{name} has another truth"),
        };
        let mut sides = [finer, finer + 1].map(|f| truth::dense_truth(scene, trial.texels, f).unwrap());
        let all = trial.scene.faces.len() * (trial.texels * trial.texels) as usize;
        sides.iter_mut().for_each(|s| s.resize(all, DVec3::ZERO));
        let apart = truth_difference(&trial, &sides[0], &sides[1]);
        assert!(apart <= 0.01, "{name}: {apart}");
    }
}

/// Names of all cases, in order.
const NEEDED: [&str; 43] = [
    "closeness",
    "shared-edge",
    "grazing",
    "sliver-shooter",
    "sliver-receiver",
    "small-shooter",
    "large-texel",
    "remote",
    "vanishing-face",
    "tessellation",
    "horizon",
    "rim",
    "coplanar",
    "duplicate",
    "intersecting",
    "thin-sheet",
    "back-face",
    "t-vertices",
    "non-planar",
    "degenerate",
    "open",
    "slit",
    "blinds",
    "grating",
    "plates",
    "covered-lamp",
    "door",
    "wall",
    "cracks",
    "white-walls",
    "power",
    "faint-lamp",
    "many-shots",
    "ties",
    "lights",
    "units",
    "translation",
    "object-on-floor",
    "object-sunk",
    "object-in-its-shadow",
    "object-black",
    "object-white",
    "object-at-window",
];

#[test]
fn all_cases_exist_with_wide_sweeps() {
    let all = cases::all_cases();
    let names: Vec<&str> = all.iter().map(|c| c.info.name).collect();
    assert_eq!(names, NEEDED);
    for case in all {
        let name = case.info.name;
        let mut values = case.values.to_vec();
        values.sort_by(f64::total_cmp);
        values.dedup();
        assert!(values.len() >= 5, "{name}: {} values", values.len());
        let trial = (case.build)(case.values[0]).unwrap();
        let methods = methods::methods_of(trial.suite);
        assert!(methods.len() >= 4, "{name}: {} methods", methods.len());
        assert_eq!(methods[0].name, methods::DEFAULT_METHOD, "{name}");
        assert!(trial.judged.iter().all(|k| *k < trial.scene.faces.len()), "{name}");
        // The first and the last value must give different scenes.
        let last = (case.build)(case.values[values.len() - 1]).unwrap();
        assert_ne!(text_of_faces(&trial.scene), text_of_faces(&last.scene), "{name}");
    }
}

fn text_of_faces(scene: &Scene) -> String {
    format!("{:?}", scene.faces)
}

fn made_side(error: f64, warnings: &[&str]) -> SolverSide {
    SolverSide {
        noise: 0.0,
        bias: None,
        estimate: None,
        error: (error.is_finite()).then_some(error),
        verdict: Verdict::Fails,
        warnings: warnings.iter().map(|w| (*w).to_owned()).collect(),
        notes: Vec::new(),
        message: error.is_nan().then(|| "refused: too large".into()),
        seconds: 0.1,
    }
}

/// Makes rows of a case: errors and warnings on the CPU and on the GPU.
fn made_study(measure: &'static str, sides: &[(f64, SolverSide, SolverSide)]) -> CaseStudy {
    let about = CaseInfo {
        name: "made-up",
        parameter: "x",
        breaks: "nothing",
        truth: "none",
        measure,
    };
    let case = Case {
        info: about,
        values: &[],
        build: case_named("power").build,
    };
    let method = method_named(MethodSuite::All, methods::DEFAULT_METHOD);
    let rows = sides
        .iter()
        .map(|(value, cpu, gpu)| make_row(&case, *value, &method, (cpu.clone(), Some(gpu.clone()))));
    CaseStudy {
        info: about,
        rows: rows.collect(),
        specimen: None,
    }
}

#[test]
fn warnings_are_counted_as_caught_missed_and_false() {
    let study = made_study(
        RELATIVE_RMS,
        &[
            (1.0, made_side(0.001, &[]), made_side(0.019, &["a"])),
            (2.0, made_side(0.021, &["a", "a", "b"]), made_side(0.5, &[])),
            (3.0, made_side(f64::NAN, &[]), made_side(0.02, &[])),
        ],
    );
    let score = score::score_warnings(&[study]);
    let expected = WarningCounts {
        caught: 2,
        missed: 1,
        false_alarms: 1,
        quiet: 2,
    };
    assert_eq!(score.default, expected);
    assert_eq!(score.all, expected);
    assert!(abs_diff_eq!(
        score.default.false_alarm_share(),
        1.0 / 6.0,
        epsilon = 1e-15
    ));
    let codes: Vec<_> = score
        .codes
        .iter()
        .map(|c| (c.code.as_str(), c.caught, c.false_alarms))
        .collect();
    assert_eq!(codes, [("a", 1, 1), ("b", 1, 0)]);
}

#[test]
fn break_points_follow_the_order_of_severity() {
    // The method recovers at 4, so that earlier failures do not count.
    let errors = [(1.0, 0.001), (2.0, 0.02), (3.0, 0.05), (4.0, 0.01), (5.0, f64::NAN)];
    let sides: Vec<_> = errors
        .map(|(x, e)| (x, made_side(e, &[]), made_side(0.3, &[])))
        .to_vec();
    let found = breaks::find_breaks(&made_study(RELATIVE_RMS, &sides));
    let reach = |limit, to, breaks_at| SafeRange { limit, to, breaks_at };
    assert_eq!(found[0].safe, reach(0.02, Some(2.0), Some(3.0)));
    assert_eq!(found[0].degraded, reach(0.1, Some(4.0), Some(5.0)));
    assert_eq!(found[1].safe, reach(0.02, None, Some(1.0)));
    let never = breaks::find_breaks(&made_study(
        RELATIVE_RMS,
        &[(1.0, made_side(0.0, &[]), made_side(0.0, &[]))],
    ));
    assert_eq!(never[0].safe, reach(0.02, Some(1.0), None));
}

#[test]
fn row_has_error_and_warning_of_worse_solver() {
    let of = |cpu, gpu| made_study(RELATIVE_RMS, &[(1.0, cpu, gpu)]).rows.remove(0);
    let first: AtlasRow = of(made_side(0.3, &[]), made_side(0.01, &["a"]));
    assert_eq!(
        (first.error, first.warned, first.verdict),
        (Some(0.3), false, Verdict::Fails)
    );
    let second = of(made_side(0.01, &[]), made_side(0.05, &["a"]));
    assert_eq!(
        (second.error, second.warned, second.verdict),
        (Some(0.05), true, Verdict::Degrades)
    );
    let third = of(made_side(0.01, &[]), made_side(f64::NAN, &[]));
    assert_eq!((third.error, third.warned, third.verdict), (None, true, Verdict::Fails));
}

#[test]
fn each_gate_breaks_on_its_violation() {
    let broken = |study: CaseStudy| -> Vec<bool> {
        let studies = [study];
        let score = score::score_warnings(&studies);
        gates::evaluate_gates(&studies, &score)
            .iter()
            .map(|g| !g.held)
            .collect()
    };
    let fine = made_side(0.01, &[]);
    let pair = |a: &SolverSide| made_study(RELATIVE_RMS, &[(1.0, a.clone(), fine.clone())]);
    assert_eq!(broken(pair(&fine)), [false; 4]);
    assert_eq!(broken(pair(&made_side(0.03, &[]))), [false, true, false, false]);
    assert_eq!(broken(pair(&made_side(0.03, &["a"]))), [false; 4]);
    assert_eq!(broken(pair(&made_side(0.01, &["a"]))), [false, false, true, false]);
    // A panic is no refusal: its message has no advice.
    let mut panicked = made_side(f64::NAN, &[]);
    panicked.message = Some("panic: index out of bounds".into());
    assert_eq!(broken(pair(&panicked)), [true, true, false, false]);
    let leak = made_study(LEAK_MEASURE, &[(1.0, made_side(2e-6, &["a"]), made_side(0.0, &[]))]);
    assert_eq!(broken(leak), [false, false, false, true]);
}

#[test]
fn copied_or_incomplete_answers_are_refused() {
    let trial = (case_named("closeness").build)(1.0).unwrap();
    let truth = truth::single_truth(&trial).unwrap();
    let refusal = |answer: &[DVec3]| error_and_noise(&trial, answer, &truth).unwrap_err();
    assert!(refusal(&truth).contains("truth itself"));
    assert!(refusal(&truth[1..]).contains("texels instead of"));
    // A furnace's radiosity is known in advance, so an answer may equal it bit for bit.
    let furnace = (case_named("white-walls").build)(0.9).unwrap();
    let known = truth::single_truth(&furnace).unwrap();
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
    let good = (case_named("closeness").build)(1.0).unwrap();
    let told = truth::single_truth(&good).unwrap();
    // A scene without faces, and a solve that panics.
    let none = Trial::new(Scene::default(), 8, TrialTruth::Direct);
    let fine = method_named(MethodSuite::All, "polygon");
    let refused = run_method(&none, &fine, None, &[], never).unwrap();
    assert!(refused.side.is_warned() && refused.answer.is_none());
    assert!(refused.side.message.unwrap().contains("has no faces"));
    let mad = AtlasMethod {
        name: "mad",
        kind: MethodKind::Shooting(|s| assert_eq!(s.meshing.patches, 0, "planted")),
    };
    let panicked = run_method(&good, &mad, None, &told, never).unwrap().side;
    assert!(panicked.message.as_ref().unwrap().starts_with("panic: "));
    assert!(panicked.is_broken() && !panicked.is_warned());
    assert!(run_method(&good, &fine, None, &told, &|| true).is_none());
}

#[test]
fn case_has_specimen_with_plates() {
    let run = AtlasRun {
        gpu: None,
        stop: &|| false,
    };
    let study = run.run_case(case_named("vanishing-face"), &without_progress()).unwrap();
    let specimen = study.specimen.unwrap();
    assert_eq!(specimen.plates[0].label, "truth");
    assert!(specimen.plates.len() > 4);
    let texels = specimen.plates[0].resolution.iter().product::<u32>() as usize;
    assert!(specimen.plates.iter().all(|p| p.values.len() == texels));
    assert!(Mesh::uniform(&specimen.scene, 1, 1).is_ok());
}

/// More lamps than the sweep has, for one method: all methods would take a minute on a software GPU.
#[test]
fn three_thousand_lamps_are_within_one_percent() {
    let trial = (case_named("lights").build)(3000.0).unwrap();
    let told = truth::single_truth(&trial).unwrap();
    let default = method_named(MethodSuite::All, methods::DEFAULT_METHOD);
    let side = run_method(&trial, &default, None, &told, &|| false).unwrap().side;
    assert!(side.error.unwrap() < 0.01 && !side.is_warned(), "{side:?}");
}

/// Between very white walls the small closure error of links grows with every bounce, and the answer is warned.
#[test]
fn gpu_warns_of_white_walls() {
    let trial = (case_named("white-walls").build)(0.9999).unwrap();
    let told = truth::single_truth(&trial).unwrap();
    let default = method_named(MethodSuite::All, methods::DEFAULT_METHOD);
    let gpu = Gpu::open(None).unwrap();
    let side = run_method(&trial, &default, Some(&gpu), &told, &|| false).unwrap().side;
    let (error, estimate) = (side.error.unwrap(), side.estimate.unwrap());
    assert!(side.is_warned() && estimate > 0.8 * error, "{side:?}");
}
