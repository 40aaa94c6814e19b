//! Break points and errors of the atlas are unchanged: `breaks.tsv` has, for each case and method, the first value at
//! which the error exceeds 2 % and 10 % (1e-6 and 1e-4 for leaks), and the error at each value.

use approx::relative_eq;
use gpu::Gpu;
use oracle::solve::progress::without_progress;
use oracle::solve::solver::SolverKind;
use radiosity::studies::stress::CaseStudy;
use radiosity::studies::stress::cases::{ALL_CASES, Case};
use radiosity::studies::stress::run::AtlasRun;
use radiosity::studies::stress::summary::{Atlas, BreakPoint, find_breaks};
use std::path::Path;

/// Case, method, solver, beyond the first limit, beyond the second ("-": nowhere), the errors ("-": none).
const KNOWN: &str = include_str!("breaks.tsv");

/// Relative tolerance of errors, which are written with three digits.
const DIGITS: f64 = 0.01;
/// Absolute tolerance of errors: rounding of a solve in f32 (`tests/robustness/units.rs`), far below the smallest limit
/// except that of leaks.
const ROUNDING: f64 = 1e-6;

/// Cases in which item buffers break for reasons of their own: a face without a pixel, one that crosses the horizon, an
/// object at the eye. All cases would take half an hour on a software adapter.
const BUFFERS: [&str; 3] = ["vanishing-face", "horizon", "covered-lamp"];

/// Runs cases without estimates of shooting, which no gate judges.
fn run_cases<'a>(gpu: Option<&Gpu>, cases: impl IntoIterator<Item = &'a Case>) -> Vec<CaseStudy> {
    let run = AtlasRun {
        gpu,
        estimates_shooting: false,
        ..AtlasRun::default()
    };
    let study = |case: &Case| run.run_case(case, &without_progress()).unwrap();
    cases.into_iter().map(study).collect()
}

fn break_lines(studies: &[CaseStudy], solver: SolverKind) -> Vec<String> {
    let line = |study: &CaseStudy, point: &BreakPoint| {
        let at = |value: Option<f64>| value.map_or("-".to_owned(), |value| value.to_string());
        let errors = study.sides_of(point.method, solver).map(|(_, side)| side.error);
        let errors: Vec<String> = errors
            .map(|error| error.map_or("-".into(), |error| format!("{error:.2e}")))
            .collect();
        let name = solver.name().to_lowercase();
        [
            study.case.name,
            point.method,
            &name,
            &at(point.degrades_at),
            &at(point.fails_at),
            &errors.join(" "),
        ]
        .join("\t")
    };
    let all = studies.iter().flat_map(|study| {
        let own = find_breaks(study).into_iter().filter(|point| point.solver == solver);
        own.map(move |point| line(study, &point))
    });
    all.collect()
}

/// Returns true if two lines are equal within the tolerances of errors.
fn is_same_line(known: &str, found: &str) -> bool {
    let [(head, errors), (other_head, others)] = [known, found].map(|line| line.rsplit_once('\t').unwrap());
    let like = |(a, b): (&str, &str)| match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => relative_eq!(a, b, epsilon = ROUNDING, max_relative = DIGITS),
        _ => a == b,
    };
    head == other_head
        && errors.split(' ').count() == others.split(' ').count()
        && errors.split(' ').zip(others.split(' ')).all(like)
}

#[test]
fn lines_with_other_errors_differ() {
    let line = "case\tdefault\tcpu\t1\t-\t1.00e-3 2.50e-2 -";
    assert!(is_same_line(line, &line.replace("2.50", "2.51")));
    for (from, to) in [("2.50", "2.60"), ("\t1\t", "\t2\t"), (" -", " 1.00e-3"), (" -", "")] {
        assert!(!is_same_line(line, &line.replacen(from, to, 1)), "{from} {to}");
    }
}

/// Asserts that the lines of these cases on this solver are those of `breaks.tsv`. All lines found are written to a file,
/// to replace `breaks.tsv` after an intended change.
fn assert_unchanged(studies: &[CaseStudy], solver: SolverKind) {
    let found = break_lines(studies, solver);
    let name = solver.name().to_lowercase();
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("breaks-{name}.tsv"));
    std::fs::write(&file, found.join("\n")).unwrap();
    let is_of_studies = |line: &&str| {
        let parts: Vec<&str> = line.split('\t').collect();
        parts[2] == name && studies.iter().any(|study| study.case.name == parts[0])
    };
    let known: Vec<&str> = KNOWN.lines().filter(is_of_studies).collect();
    assert!(!found.is_empty());
    let lacks = |lines: &[&str], line: &str| !lines.iter().any(|other| is_same_line(other, line));
    let found: Vec<&str> = found.iter().map(String::as_str).collect();
    let gone: Vec<_> = known.iter().filter(|line| lacks(&found, line)).collect();
    let new: Vec<_> = found.iter().filter(|line| lacks(&known, line)).collect();
    let is_same = gone.is_empty() && new.is_empty();
    assert!(is_same, "was {gone:#?}, is {new:#?}, all in {}", file.display());
}

#[test]
fn break_points_of_cpu_methods_are_unchanged() {
    let studies = run_cases(None, ALL_CASES);
    assert_unchanged(&studies, SolverKind::Cpu);
    for gate in Atlas::new(studies, None, 0.0).gates {
        assert!(gate.held, "{}: {:#?}", gate.name, gate.broken);
    }
}

#[test]
fn break_points_of_item_buffers_are_unchanged() {
    let gpu = Gpu::open(None).unwrap();
    let cases = ALL_CASES.iter().filter(|case| BUFFERS.contains(&case.name));
    assert_unchanged(&run_cases(Some(&gpu), cases), SolverKind::Gpu);
}
