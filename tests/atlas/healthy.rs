//! The verdict of `compare` on random scenes: healthy solvers agree. PROPTEST_CASES sets the number of scenes.

use common::scene::Scene;
use common::settings::{Iteration, Settings, Visibility};
use oracle::compare::comparison::Comparison;
use oracle::compare::hierarchical::compare_hierarchical;
use oracle::solve::progress::without_progress;
use oracle::solve::solver::ErrorTarget;
use radiosity::studies::random::FaceShapes;
use radiosity_tests::engines::{item_buffer, settings_of, shared_gpu};
use radiosity_tests::random_cases;
use radiosity_tests::shader_faults::{compare_with_faults, failing_criteria, paper_settings};
use radiosity_tests::solutions::drawn_scene;
use std::collections::BTreeMap;

/// Draws scenes: quads, triangles and both in turn.
fn random_scenes(count: u32) -> impl Iterator<Item = Scene> {
    (1..=u64::from(count)).map(|seed| {
        let faces = match seed % 4 {
            0 => FaceShapes::Quads,
            1 | 3 => FaceShapes::Triangles,
            _ => FaceShapes::Mixed,
        };
        drawn_scene(seed, faces)
    })
}

/// Returns coarse settings of a solve by conjugate gradients.
fn pass_settings(visibility: Visibility) -> Settings {
    let mut settings = settings_of([4, 2, 2], visibility, 1e-3);
    settings.schedule.iteration = Iteration::Cg;
    settings
}

/// Compares by single shots like the paper's with coarse pixels, so that many pairs mismatch, by passes with pixels and
/// with rays, and to an error.
fn compare_all_ways(scene: &Scene) -> [Comparison; 4] {
    let shooting = [
        paper_settings(item_buffer(256), 8, 0.01, 400),
        pass_settings(item_buffer(128)),
        pass_settings(Visibility::Rays),
    ];
    let [paper, pixels, rays] = shooting.map(|settings| compare_with_faults(scene, settings, &[]).unwrap());
    let target = ErrorTarget {
        error: 0.1,
        texels: None,
    };
    let settings = pass_settings(Visibility::Rays);
    let on_gpu = (shared_gpu(), &[][..]);
    let to_error = compare_hierarchical(scene, target, &settings, on_gpu, &without_progress()).unwrap();
    [paper, pixels, rays, to_error]
}

#[test]
fn solvers_agree_on_random_scenes() {
    let mut red = Vec::new();
    let mut nearest: BTreeMap<String, (f64, String)> = BTreeMap::new();
    for scene in random_scenes(random_cases(4).cases) {
        for (way, c) in compare_all_ways(&scene).into_iter().enumerate() {
            let failing = failing_criteria(&c);
            println!(
                "{}, way {way}: {} of {} mismatched, {} unexplained {:?}, failing {failing:?}",
                scene.name, c.pairs.mismatched, c.pairs.facing, c.pairs.unexplained, c.pairs.examples,
            );
            for criterion in c.criteria.iter().filter(|criterion| criterion.bound > 0.0) {
                let ratio = criterion.value / criterion.bound;
                let most = nearest.entry(criterion.name.clone()).or_default();
                if ratio > most.0 {
                    *most = (ratio, format!("{}, way {way}", scene.name));
                }
            }
            if !c.solvers_agree() {
                red.push(format!("{}, way {way}: {failing:?}", scene.name));
            }
        }
    }
    println!("nearest approaches, as shares of the bounds: {nearest:#?}");
    assert!(red.is_empty(), "{red:#?}");
}
