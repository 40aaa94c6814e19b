//! Twelve fixed scenes of `stress random`, solved and judged.

use oracle::solve::progress::without_progress;
use radiosity::studies::random::{FaceShapes, SceneOptions};
use radiosity::studies::stress::random::{RandomFindings, RandomRequest, gates};
use radiosity::studies::stress::run::AtlasRun;

/// Paths per scene, some seconds: fewer would be too noisy to judge the small errors of the answers.
const PATHS: u32 = 1 << 22;

/// Solves four scenes on the CPU and judges them.
fn solve_four_scenes(faces: FaceShapes, seed: u64, texels: u32) -> RandomFindings {
    let run = AtlasRun {
        gpu: None,
        stop: &|| false,
    };
    let asked = RandomRequest {
        options: SceneOptions {
            faces,
            ..SceneOptions::default()
        },
        texels,
        paths: PATHS,
        ..RandomRequest::default()
    };
    RandomFindings::run_scenes(&run, &asked, (seed, 4), &without_progress()).unwrap()
}

/// All scenes are solved, judged and have an error estimate, and every gate holds.
#[test]
fn twelve_fixed_random_scenes_pass_every_gate() {
    let mut all = RandomFindings::default();
    for (faces, seed, texels) in [
        (FaceShapes::Quads, 1000, 6),
        (FaceShapes::Triangles, 2000, 4),
        (FaceShapes::Mixed, 3000, 5),
    ] {
        let found = solve_four_scenes(faces, seed, texels);
        assert_eq!(found.all.len(), 4);
        assert!(!found.worst.is_empty() && found.worst.len() <= 4);
        all.all.extend(found.all);
    }
    for found in &all.all {
        let side = &found.row.cpu;
        let (error, bias, estimate) = (side.error.unwrap(), side.bias.unwrap(), side.estimate);
        println!(
            "{}: error {error:.4}, bias {bias:+.4}, estimate {estimate:.4?}, {:?}, {:.1} s: {}",
            found.seed, side.warnings, side.seconds, found.description
        );
        assert_eq!(found.row.value, found.seed as f64);
        // The bias is of the mean, the error of the rms without the truth's noise: neither bounds the other. A bias of 0
        // would mean that truth and answer are the same data.
        assert!(bias.is_finite() && bias != 0.0 && estimate.is_some());
        // The answer of another scene would be off by about 100 %.
        assert!((0.0..0.25).contains(&error), "{}: {error}", found.description);
    }
    let ratios = all.estimate_ratios();
    let gates = gates::evaluate_gates(&all, &ratios);
    println!("{ratios:?}");
    for gate in &gates {
        println!("{}: {} {:?}", gate.name, gate.held, gate.broken);
    }
    assert!(gates.iter().all(|gate| gate.held));
}
