//! A fixed dozen of the scenes that `stress random` draws, and how that is told.

use oracle::solve::watch::unwatched;
use oracle::study::random::{Faces, Options};
use oracle::study::stress::random::{Asked, Findings, gates};
use oracle::study::stress::run::Run;

/// A second a scene.
const PATHS: u32 = 1 << 20;

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
        assert!(bias.abs() <= error && estimate.is_some());
        // A coarse answer, but no other scene's: those are off by as much as there is.
        assert!(error > 0.0 && error < 0.25, "{}: {error}", found.told);
    }
    let ratios = all.ratios();
    let gates = gates::of(&all, &ratios);
    println!("{ratios:?}");
    for gate in &gates {
        println!("{}: {} {:?}", gate.name, gate.held, gate.broken);
    }
    assert!(gates.iter().all(|gate| gate.held));
}
