//! The verdict of `compare` on random scenes: agreement of healthy solvers, disagreement with planted faults.
//!
//! VERDICT_SCENES and VERDICT_SEED select other scenes than the default ones.

use common::form_factor::FormFactor;
use common::import::{ImportOptions, load_scene};
use common::settings::{
    ItemBufferProjection, Iteration, Meshing, Raster, Schedule, Settings, SolveQuality, Transport, Visibility,
};
use gpu::Gpu;
use oracle::compare::comparison::Comparison;
use oracle::compare::presets::{PresetSelection, compare_presets};
use oracle::solve::progress::without_progress;
use oracle::solve::solver::{DEFAULT_ERROR, ErrorTarget};
use radiosity::studies::random::{FaceShapes, RandomScene, SceneOptions, draw_scene};
use radiosity_tests::shader_faults::{
    DEPOSIT_FAULTS, FORM_FACTOR_FAULTS, ITEM_BUFFER_FAULTS, NamedFault, compare_with_faults, failing_criteria,
    paper_settings, shader_fault,
};

fn environment_number(name: &str, default: u64) -> u64 {
    let asked = std::env::var(name).ok();
    asked.map_or(default, |text| text.parse().expect("a number"))
}

/// Draws the scenes of a run: quads, triangles and both in turn.
fn random_scenes(default: u64) -> impl Iterator<Item = RandomScene> {
    let first = environment_number("VERDICT_SEED", 1);
    (first..first + environment_number("VERDICT_SCENES", default)).map(|seed| {
        let faces = match seed % 4 {
            0 => FaceShapes::Quads,
            1 | 3 => FaceShapes::Triangles,
            _ => FaceShapes::Mixed,
        };
        draw_scene(
            seed,
            SceneOptions {
                faces,
                ..SceneOptions::default()
            },
        )
    })
}

fn open_gpu() -> Gpu {
    Gpu::open(None).expect("the tests need an adapter: see scripts/driver.sh")
}

fn stereographic_buffer(size: u32) -> Visibility {
    Visibility::with_item_buffer(ItemBufferProjection::Stereographic(Raster::Pixel), size)
}

/// Returns settings like the paper's with coarse pixels, so that many pairs mismatch.
fn coarse_paper_settings() -> Settings {
    paper_settings(stereographic_buffer(256), 8, 0.01, 400)
}

/// Returns coarse settings of a solve by conjugate gradients.
fn pass_settings(visibility: Visibility) -> Settings {
    Settings {
        meshing: Meshing {
            texels: 4,
            patches: 2,
            samples: 2,
        },
        transport: Transport {
            visibility,
            ..Transport::default()
        },
        schedule: Schedule {
            iteration: Iteration::Cg,
            ..Schedule::default()
        },
        ..Settings::default()
    }
}

/// Returns the largest ratio of a gate's value to its bound, and the gate's name.
fn nearest_gate(comparison: &Comparison) -> (f64, String) {
    let of = |g: &oracle::compare::comparison::Criterion| (g.value / g.bound, g.name.clone());
    let ratios = comparison.criteria.iter().filter(|g| g.bound > 0.0).map(of);
    ratios.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
}

#[test]
fn solvers_agree_on_random_scenes() {
    let gpu = open_gpu();
    let mut red = Vec::new();
    for drawn in random_scenes(4) {
        let ways = [
            coarse_paper_settings(),
            pass_settings(stereographic_buffer(128)),
            pass_settings(Visibility::Rays),
        ];
        for settings in ways {
            let c = compare_with_faults(&drawn.scene, settings, &gpu, &[]).unwrap();
            let share = c.pairs.mismatched as f64 / c.pairs.facing.max(1) as f64;
            println!(
                "{} {} faces, {:?}: mismatched {:.2} %, {} unexplained {:?}, lockstep {:.3} %, nearest {:?}",
                c.scene.name,
                c.scene.faces.len(),
                c.gpu_settings.transport.visibility,
                100.0 * share,
                c.pairs.unexplained,
                c.pairs.examples,
                100.0 * c.lockstep_difference.relative_rms,
                nearest_gate(&c),
            );
            if !c.solvers_agree() {
                red.push(format!(
                    "{} {:?}: {:?}",
                    c.scene.name,
                    c.gpu_settings,
                    failing_criteria(&c)
                ));
            }
        }
    }
    assert!(red.is_empty(), "{red:#?}");
}

/// Returns one fault of each kind, among those that affect any scene with light.
fn faults() -> impl Iterator<Item = NamedFault> {
    let select = NamedFault {
        name: "the patch of least power",
        fault: shader_fault("select", "if power > best {", "if power < best {"),
    };
    let shared = [&FORM_FACTOR_FAULTS[..], &DEPOSIT_FAULTS, &ITEM_BUFFER_FAULTS];
    shared.concat().into_iter().chain([select])
}

#[test]
fn planted_faults_are_caught_on_random_scenes() {
    let gpu = open_gpu();
    let (mut asked, mut missed) = (0, Vec::new());
    for drawn in random_scenes(2) {
        for NamedFault { name, fault } in faults() {
            // A fault that the host refuses counts as caught.
            let c = compare_with_faults(&drawn.scene, coarse_paper_settings(), &gpu, &[fault]).ok();
            asked += 1;
            if c.is_some_and(|c| c.solvers_agree()) {
                missed.push(format!("{}: {name}", drawn.scene.name));
            }
        }
    }
    println!("{} of {asked} missed: {missed:#?}", missed.len());
    assert!(20 * missed.len() <= asked, "{missed:#?}");
}

/// Without options `compare` judges the defaults of `solve` and the paper's settings, each with its error.
#[test]
fn default_and_paper_preset_are_judged_with_their_errors() {
    let file = std::env::var("VERDICT_FILE")
        .unwrap_or_else(|_| concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/facing_plates.obj").into());
    let texels = environment_number("VERDICT_TEXELS", 8) as u32;
    let scene = load_scene(file.as_ref(), &ImportOptions::default()).unwrap();
    let pixels = environment_number("VERDICT_PIXELS", 256) as u32;
    let normal = Settings::with_quality(SolveQuality::Normal).with_visibility(stereographic_buffer(pixels));
    let paper = Settings {
        meshing: Meshing {
            texels,
            patches: 1,
            samples: 1,
        },
        transport: Transport {
            form_factor: FormFactor::Disc,
            ..normal.transport
        },
        schedule: Schedule {
            iteration: Iteration::Southwell,
            ..normal.schedule
        },
        ..normal
    };
    let asked = ErrorTarget {
        error: DEFAULT_ERROR,
        texels: Some(texels),
    };
    let ways = PresetSelection::PaperAndDefault { paper, target: asked };
    let judged = compare_presets(&scene, &ways, &open_gpu(), &[], &without_progress()).unwrap();
    for c in judged.iter_comparisons() {
        println!(
            "{} {:?} {:?} {:?} {:?}",
            c.preset.name(),
            failing_criteria(c),
            c.truth_error,
            c.truth,
            c.seconds
        );
        println!("{:?} {:?}", c.findings, c.notes);
    }
    assert!(judged.all_agree());
    let error = |c: &Comparison| c.truth_error.map(|e| e.expect("a truth"));
    let as_solved = error(judged.solve_default.as_ref().expect("both ways"));
    let paper = error(&judged.first);
    // Whole faces are inaccurate between plates as near as these: the solvers agree, and the error is reported.
    assert!(paper.iter().all(|e| *e > 0.02), "{paper:?}");
    assert!(as_solved.iter().all(|e| *e < 0.02), "{as_solved:?}");
    if let Some(out) = std::env::var_os("VERDICT_OUT") {
        let page = radiosity::report::comparison::render_report(std::slice::from_ref(&judged), &[]);
        std::fs::write(std::path::Path::new(&out).join("report.html"), page).unwrap();
        let json = radiosity::report::comparison::report_json(std::slice::from_ref(&judged)).to_string();
        std::fs::write(std::path::Path::new(&out).join("report.json"), json).unwrap();
    }
}
