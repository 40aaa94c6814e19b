//! The verdict of `compare` on random scenes: healthy solvers agree.

use common::scene::Scene;
use common::settings::{Iteration, Settings, Visibility};
use oracle::compare::comparison::Comparison;
use radiosity::studies::random::FaceShapes;
use radiosity_tests::engines::{item_buffer, settings_of};
use radiosity_tests::shader_faults::{compare_with_faults, failing_criteria, paper_settings};
use radiosity_tests::solutions::drawn_scene;
use std::ops::RangeInclusive;

/// Draws scenes: quads, triangles and both in turn.
fn random_scenes(seeds: RangeInclusive<u64>) -> impl Iterator<Item = Scene> {
    seeds.map(|seed| {
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

/// Returns the largest ratio of a criterion's value to its bound, and its name.
fn nearest_criterion(comparison: &Comparison) -> (f64, String) {
    let criteria = comparison.criteria.iter().filter(|c| c.bound > 0.0);
    let ratios = criteria.map(|c| (c.value / c.bound, c.name.clone()));
    ratios.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
}

#[test]
fn solvers_agree_on_random_scenes() {
    let mut red = Vec::new();
    for scene in random_scenes(1..=4) {
        let ways = [
            // Like the paper's, with coarse pixels, so that many pairs mismatch.
            paper_settings(item_buffer(256), 8, 0.01, 400),
            pass_settings(item_buffer(128)),
            pass_settings(Visibility::Rays),
        ];
        for settings in ways {
            let c = compare_with_faults(&scene, settings, &[]).unwrap();
            println!(
                "{} {:?}: {} of {} mismatched, {} unexplained {:?}, nearest {:?}",
                c.scene.name,
                c.gpu_settings.transport.visibility,
                c.pairs.mismatched,
                c.pairs.facing,
                c.pairs.unexplained,
                c.pairs.examples,
                nearest_criterion(&c),
            );
            if !c.solvers_agree() {
                let failing = failing_criteria(&c);
                red.push(format!("{} {:?}: {failing:?}", c.scene.name, c.gpu_settings));
            }
        }
    }
    assert!(red.is_empty(), "{red:#?}");
}
