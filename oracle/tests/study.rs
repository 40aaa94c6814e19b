//! The study finds the orders that theory has, and what sets a floor.

use common::scene::{Face, Scene};
use common::settings::{Meshing, Settings};
use common::shooting::solve;
use common::solution::{Seconds, Solution, Stored};
use cpu::CpuSolver;
use glam::{DVec3, Vec3};
use oracle::solve::watch::{Watch, unwatched};
use oracle::study::converge::run::Bench;
use oracle::study::converge::sweeps::{CELLS, Curve, EPSILON, Sweep, TEXELS, Truth};
use oracle::study::converge::{MeasuredSweep, Study, json, page};
use std::ops::ControlFlow;

/// A square of side 2·`half` about `centre`, spanned by `x` and `y`, front x × y.
fn square(name: &str, centre: DVec3, x: DVec3, y: DVec3, light: [f32; 2]) -> Face {
    let corners = [-x - y, x - y, x + y, y - x].map(|p| centre + p);
    let [emission, reflectance] = light.map(Vec3::splat);
    Face::quad(name, corners, emission, reflectance)
}

/// A lamp above a floor, and a screen between them if `screened`.
fn scene(screened: bool) -> Scene {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let mut faces = vec![
        square("floor", DVec3::ZERO, z, x, [0.0, 0.5]),
        square("lamp", y * 1.5, x, z, [5.0, 0.3]),
    ];
    if screened {
        let (a, b) = (DVec3::new(0.31, 0.1, 0.23), DVec3::new(-0.2, 0.03, 0.27));
        faces.push(square("screen", y * 0.7, a, b, [0.0, 0.0]));
        faces.push(faces[2].reversed());
    }
    Scene {
        name: "lamp over floor".into(),
        faces,
        notes: Vec::new(),
    }
}

fn measure(scene: &Scene, sweep: &Sweep, truth: Option<&Stored>) -> MeasuredSweep {
    let bench = Bench {
        scene,
        gpu: None,
        truth,
    };
    bench.sweep(sweep, &unwatched()).unwrap().unwrap()
}

const REFINED: Sweep = Sweep {
    truth: Truth::Finer(128.0),
    // The end of the solve must not show beside the texels.
    base: |settings| settings.schedule.epsilon = 1e-6,
    ..TEXELS
};

#[test]
fn without_shadows_the_centres_of_texels_are_second_order() {
    // The mean of a smooth H over a texel is H(centroid) + h²/24 ∇²H + …
    let measured = measure(&scene(false), &REFINED, None);
    let curve = &measured.curves[0];
    let order = curve.order.unwrap();
    // Cells as large as texels, at N = 4, and the truth's own 1/1024 leave some doubt.
    assert!((1.8..2.3).contains(&order), "{order} {:?}", curve.points);
    assert!(curve.converges, "{}", curve.finding);
}

#[test]
fn with_shadows_texels_are_of_order_one_half_at_least() {
    // Of O(1/h²) texels a shadow's edge cuts O(1/h), each off by O(1): the RMS is O(√h).
    let measured = measure(&scene(true), &REFINED, None);
    let order = measured.curves[0].order.unwrap();
    // Where an edge falls among the centres is chance: a tenth either way over four points.
    assert!(
        (0.4..1.2).contains(&order),
        "{order} {:?}",
        measured.curves[0].points
    );
}

#[test]
fn the_error_is_about_linear_in_epsilon() {
    // What is unshot is missing: about ε of the light, and up to 1/(1 − ρ) of it.
    let mut bright = scene(false);
    for face in &mut bright.faces {
        face.reflectance = Vec3::splat(0.9);
        let sides = face.corners;
        face.corners = sides.map(|c| DVec3::new(3.0 * c.x, c.y, 3.0 * c.z));
    }
    let sweep = Sweep {
        values: &[0.1, 0.03, 0.01, 0.003],
        base: |settings| settings.meshing.texels = 8,
        ..EPSILON
    };
    let measured = measure(&bright, &sweep, None);
    let order = measured.curves[0].order.unwrap();
    assert!(
        (0.7..1.3).contains(&order),
        "{order} {:?}",
        measured.curves[0].points
    );
}

#[test]
fn a_floor_is_traced_to_the_parameter_that_sets_it() {
    // The truth has 8×8 cells; points with one cell a face stop at the cells' own error.
    let scene = scene(true);
    let dir = std::env::temp_dir().join(format!("study-{}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    let settings = Settings {
        meshing: Meshing {
            texels: 32,
            cells: 8,
            samples: 64,
        },
        ..Settings::default()
    };
    let mesh = common::cover::sampled(&scene, &settings.meshing).unwrap();
    let mut solver = CpuSolver::new(&mesh, &settings.transport);
    let run = solve(&mut solver, &settings.schedule, &mut |_, _| {
        ControlFlow::Continue(())
    })
    .unwrap();
    let solution = Solution {
        matrix: None,
        relit: None,
        scene: &scene,
        mesh: &mesh,
        solver: "cpu",
        adapter: None,
        settings: &settings,
        run: &run,
        off: None,
        certificate: None,
        error: None,
        warnings: &[],
        notes: &[],
        seconds: Seconds::default(),
    };
    solution.write(&dir).unwrap();
    let truth = Stored::read(&dir).unwrap();
    std::fs::remove_dir_all(&dir).unwrap();
    let sweep = Sweep {
        values: &[8.0, 16.0, 32.0],
        base: |settings| settings.meshing.cells = 1,
        curves: &[Curve {
            label: "128 samples",
            change: |settings| settings.meshing.samples = 128,
        }],
        ..TEXELS
    };
    let measured = measure(&scene, &sweep, Some(&truth));
    let curve = &measured.curves[0];
    assert!(!curve.converges, "{}", curve.finding);
    assert!(
        curve
            .finding
            .contains("set by another parameter: cells 1 → 2"),
        "{}",
        curve.finding
    );
    assert_eq!(curve.order_beside, None);
}

#[test]
fn what_was_finished_before_a_break_is_kept_and_told() {
    let scene = scene(false);
    let bench = Bench {
        scene: &scene,
        gpu: None,
        truth: None,
    };
    let sweep = Sweep {
        base: |settings| settings.meshing.texels = 4,
        values: &[1.0, 2.0, 3.0],
        truth: Truth::Finer(4.0),
        ..CELLS
    };
    let until = |name: &str, _| {
        if name.contains("--cells 3") {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let measured = bench.sweep(&sweep, &Watch::new(&until)).unwrap().unwrap();
    assert_eq!(measured.curves.len(), 1);
    assert_eq!(measured.curves[0].points.len(), 2);
    let study = Study {
        scene: "s".into(),
        faces: 2,
        adapter: "none".into(),
        sweeps: vec![measured],
        item_buffers: Vec::new(),
    };
    let page = page::html(std::slice::from_ref(&study));
    for wanted in ["<svg", "--cells", "polygon"] {
        assert!(page.contains(wanted), "{wanted}");
    }
    assert!(!page.contains("http"), "the page needs the network");
    let json = json(&[study], 1.0);
    let points = &json["scenes"][0]["sweeps"][0]["curves"][0]["points"];
    assert_eq!(points.as_array().unwrap().len(), 2);
    assert!(points[0]["error"].as_f64().unwrap() > 0.0);
    let broken = Watch::new(&|_, _| ControlFlow::Break(()));
    assert!(bench.sweep(&sweep, &broken).unwrap().is_none());
}
