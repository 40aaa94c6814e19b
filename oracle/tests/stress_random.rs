//! A fixed dozen of the scenes that `stress random` draws, and how that is told.

use oracle::random::{Faces, Options};
use oracle::stress::random::{Asked, Findings, gates};
use oracle::stress::run::Run;

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
        ..Asked::default()
    };
    Findings::gather(&run, &asked, (seed, 4), &mut |_| ()).unwrap()
}

#[test]
fn a_fixed_dozen_holds_what_holds_today() {
    let mut all = Findings::default();
    for (faces, seed, texels) in [
        (Faces::Quads, 1000, 4),
        (Faces::Triangles, 2000, 3),
        (Faces::Mixed, 3000, 3),
    ] {
        let found = findings(faces, seed, texels);
        assert_eq!(found.all.len(), 4);
        all.all.extend(found.all);
    }
    for found in &all.all {
        let side = &found.row.cpu;
        println!(
            "{} {:?} error {:.4} bias {:+.4} estimate {:.4} {:?} {:.1} s: {}",
            found.seed,
            side.verdict,
            side.error.unwrap(),
            side.bias.unwrap(),
            side.estimate.unwrap_or(f64::NAN),
            side.warnings,
            side.seconds,
            found.told
        );
    }
    let ratios = all.ratios();
    println!("{ratios:?}");
    for gate in gates::of(&all, &ratios) {
        println!("{}: {} {:?}", gate.name, gate.held, gate.broken);
    }
}
