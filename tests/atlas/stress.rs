//! The atlas measures what it says: its truths agree with one another, it is complete, it counts and
//! finds break points, and what goes wrong is a verdict.

use approx::abs_diff_eq;
use common::mesh::Mesh;
use common::scene::Scene;
use glam::DVec3;
use gpu::Gpu;
use oracle::solve::watch::unwatched;
use oracle::study::stress::breaks::{self, Reach};
use oracle::study::stress::gates;
use oracle::study::stress::judge::error;
use oracle::study::stress::measure::try_on;
use oracle::study::stress::methods::{self, Method, Way};
use oracle::study::stress::run::{Run, row};
use oracle::study::stress::score::{self, Counts};
use oracle::study::stress::trial::{Case, Suite, Trial, Truth};
use oracle::study::stress::{About, LEAK, RELATIVE, Row, Side, Study, Verdict, cases, truth};

fn case(name: &str) -> &'static Case {
    let all = cases::all();
    all.into_iter().find(|c| c.about.name == name).unwrap()
}

fn named(suite: Suite, name: &str) -> Method {
    let all = methods::of(suite);
    all.into_iter().find(|m| m.name == name).unwrap()
}

/// The error of one way of knowing against another, on what the case judges.
fn apart(trial: &Trial, a: &[DVec3], b: &[DVec3]) -> f64 {
    error(trial, a, b).unwrap().0
}

#[test]
fn truths_agree_with_the_matrix_where_nothing_is_hard() {
    // Lambert's exact means against the matrix's own form factors: quadrature and rounding only.
    // With shadows both cut or sample edges, to a few thousandths.
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
        let trial = (case(name).build)(value).unwrap();
        let told = truth::of(&trial).unwrap();
        let other = truth::matrix(&trial.scene, trial.texels, 1).unwrap();
        let apart = apart(&trial, &told, &other);
        assert!(apart <= tolerance, "{name}: {apart:e}");
        assert!(told.iter().any(|v| *v != DVec3::ZERO), "{name} is dark");
    }
}

#[test]
fn finer_truths_have_settled_where_nothing_is_hard() {
    // Three times as fine moves what is twice as fine by less than half of what is called safe.
    let easy = [
        ("open", 0.0),
        ("units", 1.0),
        ("object-on-floor", 0.1),
        ("t-vertices", 2.0),
    ];
    for (name, value) in easy {
        let trial = (case(name).build)(value).unwrap();
        let (scene, finer) = match &trial.truth {
            Truth::Matrix(finer) => (&trial.scene, *finer),
            Truth::Alike(scene, finer) => (scene, *finer),
            _ => panic!("{name} has another truth"),
        };
        let mut sides = [finer, finer + 1].map(|f| truth::matrix(scene, trial.texels, f).unwrap());
        let all = trial.scene.faces.len() * (trial.texels * trial.texels) as usize;
        sides.iter_mut().for_each(|s| s.resize(all, DVec3::ZERO));
        let apart = apart(&trial, &sides[0], &sides[1]);
        assert!(apart <= 0.01, "{name}: {apart}");
    }
}

/// What the atlas must have, by the words of its list.
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
fn every_case_is_there_and_wide_enough() {
    let all = cases::all();
    let names: Vec<&str> = all.iter().map(|c| c.about.name).collect();
    assert_eq!(names, NEEDED);
    for case in all {
        let name = case.about.name;
        let mut values = case.values.to_vec();
        values.sort_by(f64::total_cmp);
        values.dedup();
        assert!(values.len() >= 5, "{name}: {} values", values.len());
        let trial = (case.build)(case.values[0]).unwrap();
        let methods = methods::of(trial.suite);
        assert!(methods.len() >= 4, "{name}: {} methods", methods.len());
        assert_eq!(methods[0].name, methods::DEFAULT, "{name}");
        assert!(
            trial.judged.iter().all(|k| *k < trial.scene.faces.len()),
            "{name}"
        );
        // A sweep that is no sweep would make the same scene again.
        let last = (case.build)(case.values[values.len() - 1]).unwrap();
        assert_ne!(digest(&trial.scene), digest(&last.scene), "{name}");
    }
}

fn digest(scene: &Scene) -> String {
    format!("{:?}", scene.faces)
}

fn side(error: f64, warnings: &[&str]) -> Side {
    Side {
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

/// Rows of a case made by hand: errors and warnings on the CPU and on the GPU.
fn study(measure: &'static str, sides: &[(f64, Side, Side)]) -> Study {
    let about = About {
        name: "made-up",
        parameter: "x",
        breaks: "nothing",
        truth: "none",
        measure,
    };
    let case = Case {
        about,
        values: &[],
        build: case("power").build,
    };
    let method = named(Suite::All, methods::DEFAULT);
    let rows = sides
        .iter()
        .map(|(value, cpu, gpu)| row(&case, *value, &method, (cpu.clone(), Some(gpu.clone()))));
    Study {
        about,
        rows: rows.collect(),
        specimen: None,
    }
}

#[test]
fn warnings_are_counted_as_caught_missed_and_false() {
    let study = study(
        RELATIVE,
        &[
            (1.0, side(0.001, &[]), side(0.019, &["a"])),
            (2.0, side(0.021, &["a", "a", "b"]), side(0.5, &[])),
            (3.0, side(f64::NAN, &[]), side(0.02, &[])),
        ],
    );
    let score = score::of(&[study]);
    let expected = Counts {
        caught: 2,
        missed: 1,
        false_alarms: 1,
        quiet: 2,
    };
    assert_eq!(score.default, expected);
    assert_eq!(score.all, expected);
    assert!(abs_diff_eq!(
        score.default.false_share(),
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
    // It recovers at 4: what was passed before does not count.
    let errors = [
        (1.0, 0.001),
        (2.0, 0.02),
        (3.0, 0.05),
        (4.0, 0.01),
        (5.0, f64::NAN),
    ];
    let sides: Vec<_> = errors
        .map(|(x, e)| (x, side(e, &[]), side(0.3, &[])))
        .to_vec();
    let found = breaks::of(&study(RELATIVE, &sides));
    let reach = |limit, to, breaks_at| Reach {
        limit,
        to,
        breaks_at,
    };
    assert_eq!(found[0].safe, reach(0.02, Some(2.0), Some(3.0)));
    assert_eq!(found[0].degraded, reach(0.1, Some(4.0), Some(5.0)));
    assert_eq!(found[1].safe, reach(0.02, None, Some(1.0)));
    let never = breaks::of(&study(RELATIVE, &[(1.0, side(0.0, &[]), side(0.0, &[]))]));
    assert_eq!(never[0].safe, reach(0.02, Some(1.0), None));
}

#[test]
fn the_worse_side_speaks_for_a_row() {
    let of = |cpu, gpu| study(RELATIVE, &[(1.0, cpu, gpu)]).rows.remove(0);
    let first: Row = of(side(0.3, &[]), side(0.01, &["a"]));
    assert_eq!(
        (first.error, first.warned, first.verdict),
        (Some(0.3), false, Verdict::Fails)
    );
    let second = of(side(0.01, &[]), side(0.05, &["a"]));
    assert_eq!(
        (second.error, second.warned, second.verdict),
        (Some(0.05), true, Verdict::Degrades)
    );
    let third = of(side(0.01, &[]), side(f64::NAN, &[]));
    assert_eq!(
        (third.error, third.warned, third.verdict),
        (None, true, Verdict::Fails)
    );
}

#[test]
fn gates_name_what_breaks_them() {
    let broken = |study: Study| -> Vec<bool> {
        let studies = [study];
        let score = score::of(&studies);
        gates::of(&studies, &score)
            .iter()
            .map(|g| !g.held)
            .collect()
    };
    let fine = side(0.01, &[]);
    let pair = |a: &Side| study(RELATIVE, &[(1.0, a.clone(), fine.clone())]);
    assert_eq!(broken(pair(&fine)), [false; 4]);
    assert_eq!(broken(pair(&side(0.03, &[]))), [false, true, false, false]);
    assert_eq!(broken(pair(&side(0.03, &["a"]))), [false; 4]);
    assert_eq!(
        broken(pair(&side(0.01, &["a"]))),
        [false, false, true, false]
    );
    // A panic is no refusal: nobody is told what to do.
    let mut panicked = side(f64::NAN, &[]);
    panicked.message = Some("panic: index out of bounds".into());
    assert_eq!(broken(pair(&panicked)), [true, true, false, false]);
    let leak = study(LEAK, &[(1.0, side(2e-6, &["a"]), side(0.0, &[]))]);
    assert_eq!(broken(leak), [false, false, false, true]);
}

#[test]
fn an_answer_that_says_nothing_is_no_success() {
    let trial = (case("closeness").build)(1.0).unwrap();
    let truth = truth::of(&trial).unwrap();
    let refusal = |answer: &[DVec3]| error(&trial, answer, &truth).unwrap_err();
    assert!(refusal(&truth).contains("truth itself"));
    assert!(refusal(&truth[1..]).contains("texels instead of"));
    // A furnace's radiosity is known beforehand: it may be met to the bit.
    let furnace = (case("white-walls").build)(0.9).unwrap();
    let known = truth::of(&furnace).unwrap();
    assert_eq!(error(&furnace, &known, &known), Ok((0.0, 0.0)));
    let mut broken = truth.clone();
    broken[3].y = f64::NAN;
    assert!(refusal(&broken).contains("not finite"));
    let black = vec![DVec3::ZERO; truth.len()];
    assert_eq!(error(&trial, &black, &truth), Ok((1.0, 0.0)));
}

#[test]
fn what_goes_wrong_is_a_verdict() {
    let never = &|| false;
    let good = (case("closeness").build)(1.0).unwrap();
    let told = truth::of(&good).unwrap();
    // A scene without faces, and a solve that panics on its way.
    let none = Trial::new(Scene::default(), 8, Truth::Direct);
    let fine = named(Suite::All, "polygon");
    let refused = try_on(&none, &fine, None, &[], never).unwrap();
    assert!(refused.side.warned() && refused.answer.is_none());
    assert!(refused.side.message.unwrap().contains("has no faces"));
    let mad = Method {
        name: "mad",
        way: Way::Given(|s| assert_eq!(s.meshing.cells, 0, "planted")),
    };
    let panicked = try_on(&good, &mad, None, &told, never).unwrap().side;
    assert!(panicked.message.as_ref().unwrap().starts_with("panic: "));
    assert!(panicked.broke() && !panicked.warned());
    assert!(try_on(&good, &fine, None, &told, &|| true).is_none());
}

#[test]
fn a_case_has_a_specimen() {
    let run = Run {
        gpu: None,
        stop: &|| false,
    };
    let study = run.case(case("vanishing-face"), &unwatched()).unwrap();
    let specimen = study.specimen.unwrap();
    assert_eq!(specimen.plates[0].label, "truth");
    assert!(specimen.plates.len() > 4);
    let texels = specimen.plates[0].resolution.iter().product::<u32>() as usize;
    assert!(specimen.plates.iter().all(|p| p.values.len() == texels));
    assert!(Mesh::uniform(&specimen.scene, 1, 1).is_ok());
}

/// More than the sweep has, where every method would take a minute on a software GPU.
#[test]
fn thousands_of_lamps_are_no_trouble() {
    let trial = (case("lights").build)(3000.0).unwrap();
    let told = truth::of(&trial).unwrap();
    let default = named(Suite::All, methods::DEFAULT);
    let side = try_on(&trial, &default, None, &told, &|| false)
        .unwrap()
        .side;
    assert!(side.error.unwrap() < 0.01 && !side.warned(), "{side:?}");
}

/// Where walls are that white, the little that links by rays make up grows with every bounce: the answer says so.
#[test]
fn white_walls_are_not_trusted_on_the_gpu() {
    let trial = (case("white-walls").build)(0.9999).unwrap();
    let told = truth::of(&trial).unwrap();
    let default = named(Suite::All, methods::DEFAULT);
    let gpu = Gpu::open(None).unwrap();
    let side = try_on(&trial, &default, Some(&gpu), &told, &|| false)
        .unwrap()
        .side;
    let (error, estimate) = (side.error.unwrap(), side.estimate.unwrap());
    assert!(side.warned() && estimate > 0.8 * error, "{side:?}");
}
