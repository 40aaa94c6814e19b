//! Twelve fixed scenes of `stress random`, solved and judged.

use oracle::solve::progress::without_progress;
use radiosity::studies::random::FaceShapes;
use radiosity::studies::stress::random::RandomRequest;
use radiosity::studies::stress::run::AtlasRun;
use radiosity::studies::stress::summary::Atlas;

/// All scenes are solved, judged and have an error estimate, and every gate holds.
#[test]
fn twelve_fixed_random_scenes_pass_every_gate() {
    let run = AtlasRun {
        gpu: None,
        stop: &|| false,
    };
    let studies = [
        (FaceShapes::Quads, 1000, 6),
        (FaceShapes::Triangles, 2000, 4),
        (FaceShapes::Mixed, 3000, 5),
    ]
    .map(|(faces, seed, texels)| {
        let request = RandomRequest { faces, texels };
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
