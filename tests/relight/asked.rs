//! Relighting to an error: held to everything solved again, and exactly nothing where nothing changes.

use common::relight::Method;
use common::scene::{Face, Scene};
use cpu::hierarchy::find::Way;
use glam::{DVec3, Vec3, Vec4};
use oracle::judge::diff::pair::Pair;
use oracle::judge::diff::reflected::Reflected;
use oracle::relight::climb::climb;
use oracle::relight::stage::Stage;
use oracle::relight::work::Relighting;
use oracle::solve::solved::Solved;
use oracle::solve::solver::{Asked, Solver};
use oracle::solve::task::Task;
use oracle::solve::watch::unwatched;
use oracle::solve::{Answer, Question, answer};
use oracle::study::random::{self, Faces, Options};
use radiosity_tests::engines::shared_gpu;
use radiosity_tests::relighting::{cube, furnished_room};
use radiosity_tests::{answers, room};

/// What is asked.
const P: f64 = 0.03;

/// The first `count` faces are the room; without a method everything is solved again.
fn relit(scene: &Scene, count: usize, method: Option<Method>, error: f64) -> Answer {
    let mut settings = answers::settings();
    let stage = Stage::new(scene, count, settings.meshing.texels);
    settings.meshing.texels = stage.resolutions[0][0];
    let question = Question {
        task: &Relighting {
            stage: &stage,
            method,
        },
        settings: &settings,
        solver: Solver::Hierarchy(Asked {
            error,
            texels: None,
        }),
    };
    answer(&question, &unwatched()).unwrap()
}

#[test]
fn signed_is_full_within_what_both_tell() {
    for (seed, faces) in [
        (52_001, Faces::Quads),
        (52_002, Faces::Triangles),
        (52_003, Faces::Mixed),
    ] {
        let options = Options {
            faces,
            ..Options::default()
        };
        let body = |face: &Face| face.name.starts_with("body");
        let mut drawn = (seed..).step_by(100).map(|k| random::scene(k, options));
        let (scene, count) = drawn
            .find_map(|drawn| {
                let first = drawn.scene.faces.iter().position(body)?;
                Some((drawn.scene, first))
            })
            .unwrap();
        let [signed, full] =
            [Some(Method::Signed), None].map(|method| relit(&scene, count, method, P));
        let [ours, theirs] = [&signed, &full]
            .map(|answer| Reflected::of(&scene, &answer.solved.mesh, &answer.solved.run.field));
        let apart = Pair::new(&ours, &theirs, None).unwrap().worst().0;
        let told = |answer: &Answer| answer.estimate.as_ref().unwrap().error;
        let (a, b) = (told(&signed), told(&full));
        println!("{}: {apart:.4} apart; {a:.4}, {b:.4} told", scene.name);
        assert!(apart <= a + b, "{}: {apart} > {a} + {b}", scene.name);
        assert!(a.max(b) <= P, "{}: {a} {b}", scene.name);
        // Not the empty room: what the bodies change is more than that.
        let changed = changed(&signed.solved);
        assert!(changed > 3.0 * (a + b), "{}: {changed}", scene.name);
    }
}

/// By the same decisions the same bits, whoever finds the links.
#[test]
fn the_gpu_relights_as_the_cpu_does_by_rays() {
    let (scene, count) = furnished_room(cube(Vec3::ZERO, Vec3::splat(0.5)));
    let settings = answers::settings();
    let stage = Stage::new(&scene, count, settings.meshing.texels);
    let asked = Asked {
        error: 0.1,
        texels: None,
    };
    let task = Relighting {
        stage: &stage,
        method: Some(Method::Signed),
    };
    let linking = Solver::Linking(shared_gpu(), asked);
    let on_gpu = task.once(&settings, linking, &unwatched()).unwrap();
    let by_rays = climb(&stage, false, &settings, asked, Way::Rays, &unwatched()).unwrap();
    assert!(changed(&on_gpu) > 0.01);
    let all = |solved: &Solved| bits(solved.run.field.radiosity.iter().copied());
    assert_eq!(all(&on_gpu), all(&by_rays));
}

/// RMS of B − B₀ over that of B₀, over the room's area.
fn changed(solved: &Solved) -> f64 {
    let before = &solved.relit.as_ref().unwrap().before;
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
    values
        .map(|b| b.truncate().to_array().map(f32::to_bits))
        .collect()
}

/// B and B₀ of the room's texels, bit for bit.
fn of_room(solved: &Solved) -> [Vec<[u32; 3]>; 2] {
    let before = &solved.relit.as_ref().unwrap().before;
    [&solved.run.field.radiosity, before].map(|values| {
        let texels = solved.mesh.texels.iter().zip(values);
        let room = texels.filter(|(texel, _)| !solved.mesh.is_object(texel.face));
        bits(room.map(|(_, value)| *value))
    })
}

#[test]
fn what_no_light_reaches_changes_no_bit() {
    let outside = |low: DVec3| {
        let high = low + DVec3::new(0.4, 0.7, 0.5);
        room(low, high, false, Vec3::ZERO, Vec3::splat(0.5))
    };
    // None at all; one behind a wall, near enough to stand between the balls around two walls.
    for objects in [Vec::new(), outside(DVec3::new(3.05, 0.3, 1.0))] {
        let (scene, count) = furnished_room(objects);
        let answer = relit(&scene, count, Some(Method::Signed), P);
        let [after, before] = of_room(&answer.solved);
        assert!(before.iter().any(|b| *b != [0; 3]));
        assert_eq!(after, before);
        let objects = &answer.solved.mesh;
        let lit = (0..objects.texels.len())
            .filter(|k| objects.is_object(objects.texels[*k].face))
            .any(|k| answer.solved.run.field.radiosity[k] != Vec4::ZERO);
        assert!(!lit, "light passes a wall");
    }
    // The equality is no accident: within the room the same box shows.
    let (scene, count) = furnished_room(cube(Vec3::ZERO, Vec3::splat(0.5)));
    let answer = relit(&scene, count, Some(Method::Signed), P);
    let [after, before] = of_room(&answer.solved);
    assert_ne!(after, before);
}

#[test]
fn a_black_object_only_darkens() {
    let (scene, count) = furnished_room(cube(Vec3::ZERO, Vec3::ZERO));
    let answer = relit(&scene, count, Some(Method::Signed), P);
    let solved = &answer.solved;
    let before = &solved.relit.as_ref().unwrap().before;
    let (mut most, mut brighter) = (0f32, 0f32);
    for (k, texel) in solved.mesh.texels.iter().enumerate() {
        let b = solved.run.field.radiosity[k].truncate();
        if solved.mesh.is_object(texel.face) {
            assert_eq!(b, Vec3::ZERO);
            continue;
        }
        most = most.max(before[k].max_element());
        brighter = brighter.max((b - before[k].truncate()).max_element());
        assert!(b.min_element() >= -1e-6 * most, "{b}");
    }
    // Each of K and K₀ is off by P at most, of the RMS.
    assert!(brighter < 5e-3 * most, "{brighter} of {most}");
}
