//! Break points are figures that a test holds: `breaks.tsv` says, for each case and method of the
//! atlas, the first value at which its error is beyond 2 % and beyond 10 % (of leaks 1e-6 and 1e-4).

use gpu::Gpu;
use oracle::stress::trial::Case;
use oracle::stress::{Study, breaks, cases, gates, run::Run, score};
use std::collections::BTreeSet;
use std::path::Path;

/// Case, method, solver, beyond the first limit, beyond the second; "-": nowhere.
const KNOWN: &str = include_str!("breaks.tsv");

/// Cases in which an item buffer breaks for a reason of its own: a face without a pixel, one that
/// crosses its horizon, a body on its eye. On a software adapter all of them would take half an hour.
const BUFFERS: [&str; 3] = ["vanishing-face", "horizon", "covered-lamp"];

fn studies(gpu: Option<&Gpu>, cases: &[&Case]) -> Vec<Study> {
    let run = Run {
        gpu,
        stop: &|| false,
    };
    let study = |case: &&Case| run.case(case, &mut |_, _| ()).unwrap();
    cases.iter().map(study).collect()
}

fn lines(studies: &[Study], solver: &str) -> Vec<String> {
    let at = |value: Option<f64>| value.map_or("-".to_owned(), |value| value.to_string());
    let line = |study: &Study, b: &breaks::Break| {
        let [first, second] = [b.safe, b.degraded].map(|reach| at(reach.breaks_at));
        let case = study.about.name;
        format!("{case}\t{}\t{solver}\t{first}\t{second}", b.method)
    };
    let all = studies.iter().flat_map(|study| {
        let own = breaks::of(study).into_iter().filter(|b| b.solver == solver);
        own.map(move |b| line(study, &b))
    });
    all.collect()
}

/// What `breaks.tsv` has of these cases on this solver. What was found is left in target/tmp, to be
/// taken over when it is meant.
fn hold(studies: &[Study], solver: &str) {
    let found = lines(studies, solver);
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("breaks-{solver}.tsv"));
    std::fs::write(&file, found.join("\n")).unwrap();
    let of = |line: &str| {
        let parts: Vec<&str> = line.split('\t').collect();
        parts[2] == solver && studies.iter().any(|s| s.about.name == parts[0])
    };
    let known: BTreeSet<String> = KNOWN.lines().filter(|l| of(l)).map(str::to_owned).collect();
    let found: BTreeSet<String> = found.into_iter().collect();
    assert!(!found.is_empty());
    let gone: Vec<_> = known.difference(&found).collect();
    let new: Vec<_> = found.difference(&known).collect();
    assert!(
        gone.is_empty() && new.is_empty(),
        "was {gone:#?}, is {new:#?}, all in {}",
        file.display()
    );
}

#[test]
fn every_method_breaks_where_it_did() {
    let studies = studies(None, &cases::all());
    hold(&studies, "cpu");
    for gate in gates::of(&studies, &score::of(&studies)) {
        assert!(gate.held, "{}: {:#?}", gate.name, gate.broken);
    }
}

#[test]
fn item_buffers_break_where_they_did() {
    let gpu = Gpu::open(None).unwrap();
    let all = cases::all();
    let of = |name| all.iter().copied().find(|c| c.about.name == name).unwrap();
    hold(&studies(Some(&gpu), &BUFFERS.map(of)), "gpu");
}
