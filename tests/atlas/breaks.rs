//! Break points and errors of the atlas are unchanged: `breaks.tsv` has, for each case and method, the first value at
//! which the error exceeds 2 % and 10 % (1e-6 and 1e-4 for leaks), and the error at each value.

use approx::relative_eq;
use gpu::Gpu;
use oracle::solve::progress::without_progress;
use radiosity::studies::stress::trial::Case;
use radiosity::studies::stress::{CaseStudy, breaks, cases, gates, run::AtlasRun, score};
use std::path::{Path, PathBuf};

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

fn run_cases(gpu: Option<&Gpu>, cases: &[&Case]) -> Vec<CaseStudy> {
    let run = AtlasRun { gpu, stop: &|| false };
    let study = |case: &&Case| run.run_case(case, &without_progress()).unwrap();
    cases.iter().map(study).collect()
}

fn break_lines(studies: &[CaseStudy], solver: &str) -> Vec<String> {
    let at = |value: Option<f64>| value.map_or("-".to_owned(), |value| value.to_string());
    let line = |study: &CaseStudy, b: &breaks::BreakPoint| {
        let [first, second] = [b.safe, b.degraded].map(|reach| at(reach.breaks_at));
        let case = study.info.name;
        let errors: Vec<String> = error_texts(study, b);
        let errors = errors.join(" ");
        format!("{case}\t{}\t{solver}\t{first}\t{second}\t{errors}", b.method)
    };
    let all = studies.iter().flat_map(|study| {
        let own = breaks::find_breaks(study)
            .into_iter()
            .filter(|b| b.solver.json_name() == solver);
        own.map(move |b| line(study, &b))
    });
    all.collect()
}

/// Formats the errors of a method, value by value.
fn error_texts(study: &CaseStudy, b: &breaks::BreakPoint) -> Vec<String> {
    let rows = study.rows.iter().filter(|row| row.method == b.method);
    rows.filter_map(|row| b.solver.side_of(row))
        .map(|side| side.error.map_or("-".into(), |error| format!("{error:.2e}")))
        .collect()
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

/// Returns the file into which the lines found are written, to replace `breaks.tsv` after an intended change.
fn output_file(solver: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("breaks-{solver}.tsv"))
}

/// Asserts that the lines of these cases on this solver are those of `breaks.tsv`.
fn assert_unchanged(studies: &[CaseStudy], solver: &str) {
    let found = break_lines(studies, solver);
    let file = output_file(solver);
    let of = |line: &str| {
        let parts: Vec<&str> = line.split('\t').collect();
        parts[2] == solver && studies.iter().any(|s| s.info.name == parts[0])
    };
    let known: Vec<&str> = KNOWN.lines().filter(|l| of(l)).collect();
    assert!(!found.is_empty());
    let lacks = |lines: &[&str], line: &str| !lines.iter().any(|other| is_same_line(other, line));
    let found: Vec<&str> = found.iter().map(String::as_str).collect();
    let gone: Vec<_> = known.iter().filter(|line| lacks(&found, line)).collect();
    let new: Vec<_> = found.iter().filter(|line| lacks(&known, line)).collect();
    assert!(
        gone.is_empty() && new.is_empty(),
        "was {gone:#?}, is {new:#?}, all in {}",
        file.display()
    );
}

#[test]
fn break_points_of_cpu_methods_are_unchanged() {
    let studies = run_cases(None, &cases::all_cases());
    std::fs::write(output_file("cpu"), break_lines(&studies, "cpu").join("\n")).unwrap();
    let score = score::score_warnings(&studies);
    for gate in gates::evaluate_gates(&studies, &score) {
        assert!(gate.held, "{}: {:#?}", gate.name, gate.broken);
    }
    assert_unchanged(&studies, "cpu");
}

#[test]
fn break_points_of_item_buffers_are_unchanged() {
    let gpu = Gpu::open(None).unwrap();
    let all = cases::all_cases();
    let of = |name| all.iter().copied().find(|c| c.info.name == name).unwrap();
    let studies = run_cases(Some(&gpu), &BUFFERS.map(of));
    std::fs::write(output_file("gpu"), break_lines(&studies, "gpu").join("\n")).unwrap();
    assert_unchanged(&studies, "gpu");
}
