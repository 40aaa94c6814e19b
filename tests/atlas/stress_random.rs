//! Fixed scenes of `stress random`, solved and judged.

use oracle::solve::progress::without_progress;
use radiosity::studies::random::FaceShapes;
use radiosity::studies::stress::random::{DrawnScenes, RandomRequest};
use radiosity::studies::stress::run::AtlasRun;
use radiosity::studies::stress::summary::Atlas;

/// All scenes are solved, judged and have an error estimate, and every gate holds.
#[test]
fn twelve_fixed_random_scenes_pass_every_gate() {
    let run = AtlasRun::default();
    let studies = [
        (FaceShapes::Quads, 1000, 6),
        (FaceShapes::Triangles, 2000, 4),
        (FaceShapes::Mixed, 3000, 5),
    ]
    .map(|(faces, seed, texels)| {
        let request = RandomRequest {
            scenes: DrawnScenes::Rooms(faces),
            texels,
            ..RandomRequest::default()
        };
        let study = request.run_scenes(&run, seed, 4, &without_progress()).unwrap();
        assert_eq!((study.rows.len(), study.specimens.len()), (4, 4));
        for (row, seed) in study.rows.iter().zip(seed..) {
            let side = &row.cpu;
            let (error, scene) = (side.error.unwrap(), row.scene.as_ref().unwrap());
            println!("{error:.4}, {:.4?}, {:?}: {scene}", side.estimate, side.warnings);
            assert_eq!(row.value, seed as f64);
            assert!(side.estimate.is_some());
            // The answer of another scene would be off by about 100 %.
            assert!((0.0..0.25).contains(&error), "{error}: {scene}");
        }
        study
    });
    let atlas = Atlas::new(studies.into(), None, 0.0);
    println!("{:?}", atlas.estimate);
    assert!(atlas.gates.iter().all(|gate| gate.held), "{:?}", atlas.gates);
}

/// Bounces of the paths of a mesh's truth: a few seconds.
const FEW_BOUNCES: u32 = 1 << 20;
/// Rooms with a round wall, on which so few paths are precise enough.
const MESH_SEEDS: [u64; 2] = [57, 64];

/// Meshes of about a thousand triangles are solved by rays to the requested error.
#[test]
fn fixed_random_meshes_keep_the_requested_error() {
    let run = AtlasRun::default();
    let request = RandomRequest {
        scenes: DrawnScenes::Meshes,
        error: 0.05,
        max_bounces: FEW_BOUNCES,
        ..RandomRequest::default()
    };
    for seed in MESH_SEEDS {
        let study = request.run_scenes(&run, seed, 1, &without_progress()).unwrap();
        let row = &study.rows[0];
        println!("{seed}: {:?}: {:?}", row.scene, row.cpu);
        let error = row.cpu.error.unwrap();
        // The answer of another scene would be off by about 100 %.
        assert!(error + row.cpu.noise < 0.25, "{seed}: {error} ± {}", row.cpu.noise);
        assert!(!row.exceeds_request(&row.cpu, 1.0), "{seed}: {error}");
    }
}
