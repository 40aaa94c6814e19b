//! Adaptive relighting, compared with a full solve; unchanged texels keep their bits.

use common::relight::RelightMethod;
use common::scene::{Face, Scene};
use common::settings::Settings;
use cpu::hierarchy::linker::LinkMethod;
use cpu::hierarchy::solver::open_shares;
use glam::{DVec3, Vec3, Vec4};
use oracle::relight::adaptive::relight_adaptively;
use oracle::relight::stage::RelightStage;
use oracle::relight::task::RelightTask;
use oracle::solve::progress::without_progress;
use oracle::solve::solved::Solved;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::task::SolveTask;
use oracle::solve::{SolveAnswer, SolveRequest, solve_request};
use radiosity_tests::engines::shared_gpu;
use radiosity_tests::relighting::{bottomless_box, relative_error};
use radiosity_tests::solutions::{self, FACE_SHAPES, drawn_scene, error_against};
use radiosity_tests::{box_faces, lit_room};

/// Requested error.
const REQUESTED_ERROR: f64 = 0.03;

fn solve_settings() -> Settings {
    let mut settings = solutions::solve_settings();
    settings.meshing.texels = 4;
    settings
}

/// Makes the lit room with `objects`; returns the number of faces of the room, its box included.
fn furnished_room(objects: Vec<Face>) -> (Scene, usize) {
    let mut scene = lit_room();
    let count = scene.faces.len();
    scene.faces.extend(objects);
    (scene, count)
}

/// The first `count` faces are the room; without a method everything is solved again.
fn relit(scene: &Scene, count: usize, method: Option<RelightMethod>, error: f64) -> SolveAnswer {
    relit_on_texels(scene, count, method, ErrorTarget { error, texels: None })
}

/// Does the same on the texels of `target`.
fn relit_on_texels(scene: &Scene, count: usize, method: Option<RelightMethod>, target: ErrorTarget) -> SolveAnswer {
    let mut settings = solve_settings();
    let stage = RelightStage::new(scene, count, settings.meshing.texels);
    settings.meshing.texels = stage.resolutions[0][0];
    let question = SolveRequest {
        task: &RelightTask {
            stage: &stage,
            method,
            trace: None,
        },
        settings: &settings,
        solver: SolverChoice::Hierarchy(target),
    };
    solve_request(&question, &without_progress()).unwrap()
}

#[test]
fn signed_equals_full_within_both_estimates() {
    let body = |face: &Face| face.name.starts_with("body");
    for (k, faces) in FACE_SHAPES.into_iter().enumerate() {
        let mut drawn = (52_001 + k as u64..).step_by(100).map(|seed| drawn_scene(seed, faces));
        let scene = drawn.find(|scene| scene.faces.iter().any(body)).unwrap();
        let count = scene.faces.iter().position(body).unwrap();
        let [signed, full] =
            [Some(RelightMethod::Signed), None].map(|method| relit(&scene, count, method, REQUESTED_ERROR));
        let truth = (full.solved.mesh.clone(), full.solved.run.field.clone());
        let apart = error_against(&scene, &signed, &truth);
        let estimate = |answer: &SolveAnswer| answer.estimate.as_ref().unwrap().error;
        let (a, b) = (estimate(&signed), estimate(&full));
        println!("{}: difference {apart:.4}; estimates {a:.4}, {b:.4}", scene.name);
        assert!(apart <= a + b, "{}: {apart} > {a} + {b}", scene.name);
        assert!(a.max(b) <= REQUESTED_ERROR, "{}: {a} {b}", scene.name);
        // The bodies change much more than the estimates, so the comparison is not one of empty rooms.
        let changed = changed(&signed.solved);
        assert!(changed > 3.0 * (a + b), "{}: {changed}", scene.name);
    }
}

/// A result on other texels than the solver's has none.
#[test]
fn open_shares_are_those_of_the_result() {
    let (scene, count) = furnished_room(bottomless_box(Vec3::ZERO, Vec3::splat(0.5)));
    let solved = relit(&scene, count, Some(RelightMethod::Signed), 0.05).solved;
    let requested = ErrorTarget {
        error: 0.05,
        texels: Some(3),
    };
    let averaged = relit_on_texels(&scene, count, Some(RelightMethod::Signed), requested).solved;
    assert_eq!(averaged.open, None);
    let found = open_shares(&scene, &solved.mesh);
    assert!(found.iter().any(|open| *open < 0.5));
    assert_eq!(solved.open, Some(found));
}

/// Both linkers make the same decisions, and give the same bits where the adapter does not fuse multiplications and
/// additions. Where it does, rounding may turn a decision, and either solution is off by what is asked at most.
#[test]
fn gpu_links_relight_like_cpu_rays() {
    let (scene, count) = furnished_room(bottomless_box(Vec3::ZERO, Vec3::splat(0.5)));
    let settings = solve_settings();
    let stage = RelightStage::new(&scene, count, settings.meshing.texels);
    let asked = ErrorTarget {
        error: 0.1,
        texels: None,
    };
    let task = RelightTask {
        stage: &stage,
        method: Some(RelightMethod::Signed),
        trace: None,
    };
    let linking = SolverChoice::GpuHierarchy(shared_gpu(), asked);
    let on_gpu = task.solve_once(&settings, linking, &without_progress()).unwrap();
    let by_rays = relight_adaptively(&stage, false, &settings, asked, LinkMethod::Rays, &without_progress()).unwrap();
    assert!(changed(&on_gpu) > 0.01);
    let all = |solved: &Solved| bits(solved.run.field.radiosity.iter().copied());
    if shared_gpu().line.software {
        assert_eq!(all(&on_gpu), all(&by_rays));
    }
    let apart = relative_error(&on_gpu.mesh, &on_gpu.run.field, &by_rays.run.field);
    assert!(apart <= 2.0 * asked.error, "{apart}");
}

/// RMS of B − B₀ over that of B₀, over the room's area.
fn changed(solved: &Solved) -> f64 {
    let before = &solved.relight.as_ref().unwrap().before;
    let (mut change, mut all) = (0.0, 0.0);
    for (k, texel) in solved.mesh.texels.iter().enumerate() {
        if solved.mesh.is_object(texel.face) {
            continue;
        }
        let reflected = (before[k].truncate() - texel.emission).length_squared();
        let moved = (solved.run.field.radiosity[k] - before[k]).length_squared();
        change += f64::from(moved * texel.area);
        all += f64::from(reflected * texel.area);
    }
    (change / all).sqrt()
}

fn bits(values: impl Iterator<Item = Vec4>) -> Vec<[u32; 3]> {
    values.map(|b| b.truncate().to_array().map(f32::to_bits)).collect()
}

/// B and B₀ of the room's texels, bit for bit.
fn of_room(solved: &Solved) -> [Vec<[u32; 3]>; 2] {
    let before = &solved.relight.as_ref().unwrap().before;
    [&solved.run.field.radiosity, before].map(|values| {
        let texels = solved.mesh.texels.iter().zip(values);
        let room = texels.filter(|(texel, _)| !solved.mesh.is_object(texel.face));
        bits(room.map(|(_, value)| *value))
    })
}

#[test]
fn unlit_objects_change_no_bit_of_the_room() {
    let outside = |low: DVec3| {
        let high = low + DVec3::new(0.4, 0.7, 0.5);
        box_faces(low, high, false, Vec3::ZERO, Vec3::splat(0.5))
    };
    // No object; and one behind a wall, close enough to lie between the bounding balls of two walls.
    for objects in [Vec::new(), outside(DVec3::new(3.05, 0.3, 1.0))] {
        let (scene, count) = furnished_room(objects);
        let answer = relit(&scene, count, Some(RelightMethod::Signed), REQUESTED_ERROR);
        let [after, before] = of_room(&answer.solved);
        assert!(before.iter().any(|b| *b != [0; 3]));
        assert_eq!(after, before);
        let objects = &answer.solved.mesh;
        let lit = (0..objects.texels.len())
            .filter(|k| objects.is_object(objects.texels[*k].face))
            .any(|k| answer.solved.run.field.radiosity[k] != Vec4::ZERO);
        assert!(!lit, "light passes a wall");
    }
    // Inside the room the same box does change the light.
    let (scene, count) = furnished_room(bottomless_box(Vec3::ZERO, Vec3::splat(0.5)));
    let answer = relit(&scene, count, Some(RelightMethod::Signed), REQUESTED_ERROR);
    let [after, before] = of_room(&answer.solved);
    assert_ne!(after, before);
}

#[test]
fn black_object_only_darkens() {
    let (scene, count) = furnished_room(bottomless_box(Vec3::ZERO, Vec3::ZERO));
    let answer = relit(&scene, count, Some(RelightMethod::Signed), REQUESTED_ERROR);
    let solved = &answer.solved;
    let before = &solved.relight.as_ref().unwrap().before;
    let (mut largest, mut brighter) = (0f32, 0f32);
    for (k, texel) in solved.mesh.texels.iter().enumerate() {
        let b = solved.run.field.radiosity[k].truncate();
        if solved.mesh.is_object(texel.face) {
            assert_eq!(b, Vec3::ZERO);
            continue;
        }
        largest = largest.max(before[k].max_element());
        brighter = brighter.max((b - before[k].truncate()).max_element());
        assert!(b.min_element() >= -1e-6 * largest, "{b}");
    }
    // K and K₀ each have an error of at most the requested one, relative to the RMS.
    assert!(brighter < 5e-3 * largest, "{brighter} of {largest}");
}
