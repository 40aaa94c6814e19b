//! Break points and errors are figures that a test holds: `breaks.tsv` says, for each case and method of
//! the atlas, the first value at which its error is beyond 2 % and beyond 10 % (of leaks 1e-6 and 1e-4),
//! and the error at each value.

use approx::relative_eq;
use gpu::Gpu;
use oracle::solve::watch::unwatched;
use oracle::study::stress::trial::Case;
use oracle::study::stress::{Study, breaks, cases, gates, run::Run, score};
use std::path::{Path, PathBuf};

/// Case, method, solver, beyond the first limit, beyond the second ("-": nowhere), the errors ("-": none).
const KNOWN: &str = include_str!("breaks.tsv");

/// Errors may differ by this share of themselves: they are written with three digits.
const DIGITS: f64 = 0.01;
/// And by this: what f32 leaves of a solve (`tests/robustness/units.rs`), far below the least limit but that of
/// leaks, which are 0 or not.
const ROUNDING: f64 = 1e-6;

/// Cases in which an item buffer breaks for a reason of its own: a face without a pixel, one that
/// crosses its horizon, a body on its eye. On a software adapter all of them would take half an hour.
const BUFFERS: [&str; 3] = ["vanishing-face", "horizon", "covered-lamp"];

fn studies(gpu: Option<&Gpu>, cases: &[&Case]) -> Vec<Study> {
    let run = Run {
        gpu,
        stop: &|| false,
    };
    let study = |case: &&Case| run.case(case, &unwatched()).unwrap();
    cases.iter().map(study).collect()
}

fn lines(studies: &[Study], solver: &str) -> Vec<String> {
    let at = |value: Option<f64>| value.map_or("-".to_owned(), |value| value.to_string());
    let line = |study: &Study, b: &breaks::Break| {
        let [first, second] = [b.safe, b.degraded].map(|reach| at(reach.breaks_at));
        let case = study.about.name;
        let errors: Vec<String> = errors(study, b);
        let errors = errors.join(" ");
        format!(
            "{case}\t{}\t{solver}\t{first}\t{second}\t{errors}",
            b.method
        )
    };
    let all = studies.iter().flat_map(|study| {
        let own = breaks::of(study)
            .into_iter()
            .filter(|b| b.solver.solver() == solver);
        own.map(move |b| line(study, &b))
    });
    all.collect()
}

/// The errors of a method, value after value.
fn errors(study: &Study, b: &breaks::Break) -> Vec<String> {
    let rows = study.rows.iter().filter(|row| row.method == b.method);
    rows.filter_map(|row| b.solver.of(row))
        .map(|side| {
            side.error
                .map_or("-".into(), |error| format!("{error:.2e}"))
        })
        .collect()
}

/// Whether two lines say the same, but for the last digit of an error.
fn same(known: &str, found: &str) -> bool {
    let [(head, errors), (other_head, others)] =
        [known, found].map(|line| line.rsplit_once('\t').unwrap());
    let like = |(a, b): (&str, &str)| match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => relative_eq!(a, b, epsilon = ROUNDING, max_relative = DIGITS),
        _ => a == b,
    };
    head == other_head
        && errors.split(' ').count() == others.split(' ').count()
        && errors.split(' ').zip(others.split(' ')).all(like)
}

#[test]
fn a_line_is_held_to_its_errors() {
    let line = "case\tdefault\tcpu\t1\t-\t1.00e-3 2.50e-2 -";
    assert!(same(line, &line.replace("2.50", "2.51")));
    for (from, to) in [
        ("2.50", "2.60"),
        ("\t1\t", "\t2\t"),
        (" -", " 1.00e-3"),
        (" -", ""),
    ] {
        assert!(!same(line, &line.replacen(from, to, 1)), "{from} {to}");
    }
}

/// What was found is left here, to be taken over when it is meant.
fn file(solver: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("breaks-{solver}.tsv"))
}

/// What `breaks.tsv` has of these cases on this solver.
fn hold(studies: &[Study], solver: &str) {
    let found = lines(studies, solver);
    let file = file(solver);
    let of = |line: &str| {
        let parts: Vec<&str> = line.split('\t').collect();
        parts[2] == solver && studies.iter().any(|s| s.about.name == parts[0])
    };
    let known: Vec<&str> = KNOWN.lines().filter(|l| of(l)).collect();
    assert!(!found.is_empty());
    let lacks = |lines: &[&str], line: &str| !lines.iter().any(|other| same(other, line));
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
fn every_method_breaks_where_it_did() {
    let studies = studies(None, &cases::all());
    std::fs::write(file("cpu"), lines(&studies, "cpu").join("\n")).unwrap();
    let score = score::of(&studies);
    for gate in gates::of(&studies, &score) {
        assert!(gate.held, "{}: {:#?}", gate.name, gate.broken);
    }
    hold(&studies, "cpu");
}

#[test]
fn item_buffers_break_where_they_did() {
    let gpu = Gpu::open(None).unwrap();
    let all = cases::all();
    let of = |name| all.iter().copied().find(|c| c.about.name == name).unwrap();
    let studies = studies(Some(&gpu), &BUFFERS.map(of));
    std::fs::write(file("gpu"), lines(&studies, "gpu").join("\n")).unwrap();
    hold(&studies, "gpu");
}
