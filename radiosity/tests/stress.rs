//! Evaluation of the failure atlas: verdicts, warnings, break points, gates and the page, from made-up results.

use common::mesh::Mesh;
use common::shooting::initial_field;
use radiosity::studies::stress::cases::{ALL_CASES, Case};
use radiosity::studies::stress::methods::{DEFAULT, DENSE};
use radiosity::studies::stress::page::render_page;
use radiosity::studies::stress::random::RANDOM_CASE;
use radiosity::studies::stress::summary::{Atlas, BreakPoint, EstimateRatios, WarningCounts, find_breaks};
use radiosity::studies::stress::{AtlasRow, CaseStudy, ErrorMeasure, SolverSide, Specimen, Verdict, WarningOutcome};

/// A case of two methods.
const MADE_CASE: Case = Case {
    name: "one",
    parameter: "gap, m",
    methods: &[DEFAULT, DENSE],
    ..ALL_CASES[0]
};
const LEAK_CASE: Case = Case {
    measure: ErrorMeasure::Leak,
    ..MADE_CASE
};

/// Makes a result: NaN is a refusal, an empty code no warning.
fn made_side(error: f64, code: &str) -> SolverSide {
    SolverSide {
        error: error.is_finite().then_some(error),
        warnings: (!code.is_empty()).then(|| code.into()).into_iter().collect(),
        message: error.is_nan().then(|| "it does not fit <&>".into()),
        ..SolverSide::default()
    }
}

fn failed_side(message: Option<&str>, error: Option<f64>) -> SolverSide {
    SolverSide {
        message: message.map(str::to_owned),
        error,
        ..SolverSide::default()
    }
}

/// Makes a study of the default method: values, results on the CPU and on the GPU.
fn made_study(case: Case, sides: &[(f64, SolverSide, Option<SolverSide>)]) -> CaseStudy {
    let row = |(value, cpu, gpu): &(f64, SolverSide, Option<SolverSide>)| {
        AtlasRow::new(&case, *value, DEFAULT.name, cpu.clone(), gpu.clone())
    };
    CaseStudy {
        case,
        rows: sides.iter().map(row).collect(),
        specimens: Vec::new(),
    }
}

fn made_atlas(case: Case, sides: impl IntoIterator<Item = SolverSide>) -> Atlas {
    let sides: Vec<_> = sides.into_iter().map(|side| (1.0, side, None)).collect();
    Atlas::new(vec![made_study(case, &sides)], Some("llvmpipe <&>".into()), 12.5)
}

#[test]
fn error_and_warning_give_verdict_and_outcome() {
    use Verdict::{Degrades, Fails, Safe};
    use WarningOutcome::{Caught, FalseAlarm, Missed, Quiet};
    let broken = |message, error| failed_side(message, error);
    for (case, side, expected) in [
        (MADE_CASE, made_side(0.02, ""), (Safe, Quiet, false)),
        (MADE_CASE, made_side(0.021, ""), (Degrades, Missed, false)),
        (MADE_CASE, made_side(0.1, "a"), (Degrades, Caught, false)),
        (MADE_CASE, made_side(0.11, "a"), (Fails, Caught, false)),
        (MADE_CASE, made_side(0.0, "a"), (Safe, FalseAlarm, false)),
        // The warning of a leak case may concern other light.
        (LEAK_CASE, made_side(0.0, "a"), (Safe, Quiet, false)),
        (LEAK_CASE, made_side(2e-6, ""), (Degrades, Missed, false)),
        // A refusal counts as a warning, a panic does not: its message has no advice.
        (MADE_CASE, made_side(f64::NAN, ""), (Fails, Caught, false)),
        (
            MADE_CASE,
            broken(Some("panic: index out of bounds"), None),
            (Fails, Missed, true),
        ),
        (MADE_CASE, broken(None, None), (Fails, Missed, true)),
        (MADE_CASE, broken(None, Some(f64::NAN)), (Fails, Missed, true)),
    ] {
        let row = AtlasRow::new(&case, 1.0, DEFAULT.name, side.clone(), None);
        assert_eq!(
            (row.verdict, row.cpu.outcome, row.cpu.is_broken()),
            expected,
            "{side:?}"
        );
    }
}

#[test]
fn row_has_error_and_warning_of_worse_solver() {
    for (cpu, gpu, expected) in [
        (
            made_side(0.3, ""),
            made_side(0.01, "a"),
            (Some(0.3), false, Verdict::Fails),
        ),
        (
            made_side(0.01, ""),
            made_side(0.05, "a"),
            (Some(0.05), true, Verdict::Degrades),
        ),
        (
            made_side(0.01, ""),
            made_side(f64::NAN, ""),
            (None, true, Verdict::Fails),
        ),
    ] {
        let row = AtlasRow::new(&MADE_CASE, 1.0, DEFAULT.name, cpu, Some(gpu));
        assert_eq!((row.error, row.warned, row.verdict), expected);
    }
}

#[test]
fn warnings_are_counted_as_caught_missed_and_false() {
    let both = |value, cpu, gpu| (value, cpu, Some(gpu));
    let mut study = made_study(
        MADE_CASE,
        &[
            both(1.0, made_side(0.001, ""), made_side(0.019, "a")),
            both(2.0, made_side(0.021, "a"), made_side(0.5, "")),
            both(3.0, made_side(f64::NAN, ""), made_side(0.02, "")),
        ],
    );
    // Another method than the default does not count.
    study
        .rows
        .push(AtlasRow::new(&MADE_CASE, 1.0, DENSE.name, made_side(0.5, ""), None));
    let expected = WarningCounts {
        caught: 2,
        missed: 1,
        false_alarms: 1,
        quiet: 2,
    };
    assert_eq!(Atlas::new(vec![study], None, 1.0).score, expected);
}

#[test]
fn break_points_follow_the_order_of_severity() {
    // The method recovers at 4, so that earlier failures do not count.
    let errors = [(1.0, 0.001), (2.0, 0.02), (3.0, 0.05), (4.0, 0.01), (5.0, f64::NAN)];
    let sides = errors.map(|(value, error)| (value, made_side(error, ""), Some(made_side(0.0, ""))));
    let study = made_study(MADE_CASE, &sides);
    let points = |point: &BreakPoint| [point.degrades_at, point.fails_at];
    let found: Vec<_> = find_breaks(&study).iter().map(points).collect();
    assert_eq!(found, [[Some(3.0), Some(5.0)], [None, None]]);
    assert_eq!(study.swept_values(), [1.0, 2.0, 3.0, 4.0, 5.0]);
}

#[test]
fn ratios_cover_only_errors_above_the_floor() {
    let ratios = |pairs: &[(f64, Option<f64>)]| {
        let side = |(error, estimate): &(f64, Option<f64>)| SolverSide {
            estimate: *estimate,
            ..made_side(*error, "")
        };
        made_atlas(RANDOM_CASE, pairs.iter().map(side)).estimate
    };
    let found = ratios(&[
        (0.01, Some(0.004)),
        (0.01, Some(0.01)),
        (0.02, Some(0.024)),
        (0.01, Some(0.031)),
        (0.01, None),
        (0.002, Some(1.0)),
    ]);
    let expected = EstimateRatios {
        answers: 5,
        unknown: 1,
        median: 1.0,
        below: 0.4,
        above: 0.2,
    };
    assert_eq!(found, Some(expected));
    let even = ratios(&[(0.01, Some(0.01)), (0.01, Some(0.02))]).unwrap();
    assert!(approx::abs_diff_eq!(even.median, 1.5, epsilon = 1e-12));
    assert_eq!(ratios(&[(0.001, Some(0.0))]), None);
}

#[test]
fn each_gate_breaks_on_its_violation() {
    type Answers<'a> = &'a [(f64, f64, &'a str)];
    let broken = |case: Case, answers: Answers| -> Vec<&'static str> {
        let side = |(error, estimate, code): &(f64, f64, &str)| SolverSide {
            estimate: Some(*estimate),
            ..match error.is_nan() {
                true => failed_side(Some("panic: index out of bounds"), None),
                false => made_side(*error, code),
            }
        };
        let gates = made_atlas(case, answers.iter().map(side)).gates.into_iter();
        gates.filter(|gate| !gate.held).map(|gate| gate.name).collect()
    };
    let good = [(0.01, 0.011, ""); 40];
    let (panics, silent) = ("nothing panics", "the default is right to 2 %");
    let cases: [(Case, Answers, &[&str]); 13] = [
        (MADE_CASE, &[], &[]),
        (RANDOM_CASE, &[], &[]),
        (MADE_CASE, &[(0.03, 0.03, "cells")], &[]),
        (MADE_CASE, &[(0.021, 0.021, "")], &[silent]),
        (MADE_CASE, &[(f64::NAN, 0.01, "")], &[panics, silent]),
        (MADE_CASE, &[(0.01, 0.01, "cells"); 3], &["false alarms"]),
        (LEAK_CASE, &[(2e-6, 0.01, "cells")], &["no light through walls"]),
        (RANDOM_CASE, &[(0.01, 0.004, ""), (0.01, 0.031, "")], &[]),
        (RANDOM_CASE, &[(0.021, 0.021, "")], &[silent]),
        (RANDOM_CASE, &[(0.01, 0.02, ""); 41], &["estimate over error"]),
        (RANDOM_CASE, &[(0.01, 0.004, ""); 2], &["estimate below half"]),
        (RANDOM_CASE, &[(0.01, 0.031, ""); 3], &["estimate above three"]),
        (MADE_CASE, &[(0.01, 0.031, ""); 3], &[]),
    ];
    for (case, answers, expected) in cases {
        let is_leak = case.measure == ErrorMeasure::Leak;
        let good = if is_leak { &good[..0] } else { &good[..] };
        let found = broken(case, &[good, answers].concat());
        let is_same = found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| a.starts_with(b));
        assert!(is_same, "{found:?} instead of {expected:?}");
    }
}

#[test]
fn page_has_break_points_charts_pictures_and_results() {
    let mut study = made_study(
        MADE_CASE,
        &[(1.0, made_side(0.001, ""), None), (0.1, made_side(0.05, ""), None)],
    );
    let dense = [(1.0, 0.5, "thin"), (0.1, f64::NAN, "")];
    let dense =
        dense.map(|(value, error, code)| AtlasRow::new(&MADE_CASE, value, DENSE.name, made_side(error, code), None));
    study.rows.extend(dense);
    study.rows.sort_by(|a, b| b.value.total_cmp(&a.value));
    let scene = (MADE_CASE.build)(1.0).unwrap().scene;
    let mesh = Mesh::uniform(&scene, 4, 1).unwrap();
    study.specimens.push(Specimen {
        value: 5e-5,
        error: 0.1,
        field: initial_field(&mesh, "made up"),
        mesh,
        scene,
    });
    let page = render_page(&Atlas::new(vec![study], Some("llvmpipe <&>".into()), 12.5));
    for wanted in [
        "<span class=\"degrades\">◐ CPU at 0.1 ✖1</span>",
        "<span class=\"fails\">● CPU at once</span>",
        "<h2>one</h2>",
        "href=\"#one\"",
        "data:image/png",
        "it does not fit &lt;&amp;&gt;",
        "llvmpipe &lt;&amp;&gt;",
        "<tr class=\"bad\">",
        "at 5e-5 (gap, m)",
        "Not OK",
    ] {
        assert!(page.contains(wanted), "{wanted}");
    }
    assert_eq!(page.matches("class=\"chart\"").count(), 1);
    // Two answers of each method, one of which is a refusal at the end of the axis.
    assert_eq!(page.matches("<g class=\"mark\">").count(), 4);
    assert!(!page.contains("NaN"));
    let own = page.replace("http://www.w3.org/2000/svg", "");
    for outside in ["http://", "https://", "url(", "@import", "<script", "<link"] {
        assert!(!own.contains(outside), "{outside}");
    }
}

#[test]
fn page_of_random_scenes_has_all_results_and_no_chart() {
    let mut study = made_study(
        RANDOM_CASE,
        &[
            (7.0, made_side(0.03, ""), None),
            (8.0, made_side(0.01, ""), Some(made_side(0.05, "cells"))),
        ],
    );
    study.rows[0].scene = Some("scene <7>".into());
    let page = render_page(&Atlas::new(vec![study], None, 1.0));
    assert_eq!(page.matches("<tr class=\"bad\">").count(), 1);
    assert!(page.contains("scene &lt;7&gt;") && page.contains("5\u{202f}% ▲"));
    assert!(!page.contains("class=\"chart\"") && !page.contains("breaks first"));
}

#[test]
fn verdict_is_ok_only_if_all_gates_hold() {
    for (sides, ok) in [
        (vec![made_side(0.01, "")], true),
        (vec![made_side(0.5, "thin")], true),
        (vec![made_side(0.5, "")], false),
        (vec![failed_side(None, Some(f64::NAN))], false),
        (vec![], false),
    ] {
        let page = render_page(&made_atlas(MADE_CASE, sides.clone()));
        assert_eq!(page.contains("<strong>OK</strong>"), ok, "{sides:?}");
        assert_eq!(page.contains("<strong>Not OK</strong>"), !ok, "{sides:?}");
    }
}
