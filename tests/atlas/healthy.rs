//! The verdict of `compare` on random scenes: agreement of healthy solvers, disagreement with planted faults.

use common::form_factor::FormFactor;
use common::scene::Scene;
use common::settings::{Iteration, Settings, SolveQuality, Visibility};
use oracle::compare::comparison::Comparison;
use oracle::compare::presets::{PresetSelection, compare_presets};
use oracle::solve::progress::without_progress;
use oracle::solve::solver::{DEFAULT_ERROR, ErrorTarget};
use radiosity::studies::random::FaceShapes;
use radiosity_tests::bundled_scene;
use radiosity_tests::engines::{item_buffer, settings_of, shared_gpu};
use radiosity_tests::shader_faults::{compare_with_faults, failing_criteria, paper_settings, planted_faults};
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

/// Returns settings like the paper's with coarse pixels, so that many pairs mismatch.
fn coarse_paper_settings() -> Settings {
    paper_settings(item_buffer(256), 8, 0.01, 400)
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
            coarse_paper_settings(),
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

#[test]
fn planted_faults_are_caught_on_random_scenes() {
    let (mut asked, mut missed) = (0, Vec::new());
    for scene in random_scenes(1..=2) {
        for (fault, _) in planted_faults("compare") {
            // A fault that the host refuses counts as caught.
            let c = compare_with_faults(&scene, coarse_paper_settings(), &[fault]).ok();
            asked += 1;
            if c.is_some_and(|c| c.solvers_agree()) {
                missed.push(format!("{}: {fault:?}", scene.name));
            }
        }
    }
    println!("{} of {asked} missed: {missed:#?}", missed.len());
    assert!(20 * missed.len() <= asked, "{missed:#?}");
}

/// Without options `compare` judges the defaults of `solve` and the paper's settings, each with its error.
#[test]
fn default_and_paper_preset_are_judged_with_their_errors() {
    let scene = bundled_scene("facing_plates.obj");
    let normal = Settings::with_quality(SolveQuality::Normal).with_visibility(item_buffer(256));
    let mut paper = normal;
    paper.meshing = settings_of([8, 1, 1], Visibility::Rays, 1.0).meshing;
    paper.transport.form_factor = FormFactor::Disc;
    paper.schedule.iteration = Iteration::Southwell;
    let asked = ErrorTarget {
        error: DEFAULT_ERROR,
        texels: Some(8),
    };
    let ways = PresetSelection::PaperAndDefault { paper, target: asked };
    let judged = compare_presets(&scene, &ways, shared_gpu(), &[], &without_progress()).unwrap();
    assert!(judged.all_agree());
    let error = |c: &Comparison| c.truth_error.map(|e| e.expect("a truth"));
    let as_solved = error(judged.solve_default.as_ref().expect("both ways"));
    let paper = error(&judged.first);
    // Whole faces are inaccurate between plates as near as these: the solvers agree, and the error is reported.
    assert!(paper.iter().all(|e| *e > 0.02), "{paper:?}");
    assert!(as_solved.iter().all(|e| *e < 0.02), "{as_solved:?}");
}
