//! A fixed dozen of the scenes that `stress random` draws, and how that is told.

use oracle::solve::watch::unwatched;
use oracle::study::random::{Faces, Options};
use oracle::study::stress::random::{Asked, Findings, gates};
use oracle::study::stress::run::Run;

/// Some seconds a scene: the answers are so near to the truth that less would not tell how near.
const PATHS: u32 = 1 << 22;

/// The CPU's answers on four scenes.
fn findings(faces: Faces, seed: u64, texels: u32) -> Findings {
    let run = Run {
        gpu: None,
        stop: &|| false,
    };
    let asked = Asked {
        options: Options {
            faces,
            ..Options::default()
        },
        texels,
        paths: PATHS,
        ..Asked::default()
    };
    Findings::gather(&run, &asked, (seed, 4), &unwatched()).unwrap()
}

/// Solved, judged and asked for their own error, all of them: every gate holds.
#[test]
fn a_fixed_dozen_drawn_at_random_is_answered() {
    let mut all = Findings::default();
    for (faces, seed, texels) in [
        (Faces::Quads, 1000, 6),
        (Faces::Triangles, 2000, 4),
        (Faces::Mixed, 3000, 5),
    ] {
        let found = findings(faces, seed, texels);
        assert_eq!(found.all.len(), 4);
        assert!(!found.worst.is_empty() && found.worst.len() <= 4);
        all.all.extend(found.all);
    }
    for found in &all.all {
        let side = &found.row.cpu;
        let (error, bias, estimate) = (side.error.unwrap(), side.bias.unwrap(), side.estimate);
        println!(
            "{}: error {error:.4}, bias {bias:+.4}, estimate {estimate:.4?}, {:?}, {:.1} s: {}",
            found.seed, side.warnings, side.seconds, found.told
        );
        assert_eq!(found.row.value, found.seed as f64);
        // Of the mean, the error is of the rms, less the truth's noise: neither bounds the other. No two
        // answers to a scene have the same mean.
        assert!(bias.is_finite() && bias != 0.0 && estimate.is_some());
        // No other scene's answer: those are off by as much as there is.
        assert!((0.0..0.25).contains(&error), "{}: {error}", found.told);
    }
    let ratios = all.ratios();
    let gates = gates::of(&all, &ratios);
    println!("{ratios:?}");
    for gate in &gates {
        println!("{}: {} {:?}", gate.name, gate.held, gate.broken);
    }
    assert!(gates.iter().all(|gate| gate.held));
}
