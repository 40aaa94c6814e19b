//! A body of many faces in a room is lit correctly, whichever face blocked a ray before.

use common::import::{ImportOptions, load_scene};
use common::mesh::Mesh;
use common::rays::{LineOfSight, NO_FACE, Rays};
use common::scene::Scene;
use cpu::ray_cast::residual::gather_residual_by_rays;
use cpu::ray_cast::solve_by_rays;
use glam::{DVec3, Vec3};
use radiosity_tests::radiance_files::data_folder;
use radiosity_tests::solutions::{dense_truth_on, error_against, solve_to_error};
use radiosity_tests::{ball, lit_room};
use std::cell::Cell;
use std::ops::ControlFlow;

/// A lit room with a ball of 4·`rings`·(`rings` − 1) triangles.
fn room_with_ball(rings: u32) -> Scene {
    let mut scene = lit_room();
    scene.faces.truncate(6);
    let body = ball(DVec3::new(1.4, 0.9, 1.9), 0.6, [rings, 2 * rings]);
    scene.faces.extend(body);
    scene.name = format!("a ball of {} faces", 4 * rings * (rings - 1));
    scene
}

#[test]
fn last_blocker_does_not_change_visibility() {
    let mut scene = room_with_ball(6);
    scene.faces[4..6]
        .iter_mut()
        .for_each(|face| face.reflectance = Vec3::ZERO);
    let mut mesh = Mesh::uniform(&scene, 1, 1).unwrap();
    // As in a relight: rays may pass through objects, the faces beyond the room's.
    mesh.room_faces = 66;
    let rays = Rays::new(&mesh);
    let centre = |f: u32| mesh.patches[f as usize].shooter.centre;
    let (mut blocked, mut ended) = (0, 0);
    for (f, g) in (0..126).flat_map(|f| (f + 1..126).map(move |g| (f, g))) {
        let ends = [f, g];
        for through in [false, true] {
            let sight = rays.find_sight(centre(f), centre(g), ends, through);
            blocked += u32::from(sight == LineOfSight::Blocked);
            for other in [NO_FACE, f, g, (7 * f + g) % 126, (f + 5 * g) % 126] {
                let last = Cell::new(other);
                let found = rays.find_sight_after(centre(f), centre(g), ends, through, &last);
                assert_eq!(found, sight, "{f} to {g} past {other}");
                ended += u32::from(last.get() != other);
            }
        }
    }
    assert!(blocked > 500 && ended > 1000, "{blocked} {ended}");
}

#[test]
fn body_of_many_faces_matches_dense_solution() {
    let scene = room_with_ball(6);
    let requested = 0.02;
    let answer = solve_to_error(&scene, requested, 4);
    let off = error_against(&scene, &answer, &dense_truth_on(&scene, 4));
    assert!(off <= requested, "{off}");
}

/// A solve by rays, judged by rays that are drawn anew: its noise shows, since the judging rays have noise of their own.
#[test]
fn noise_of_a_solve_shows_in_its_residual_by_rays() {
    let scene = room_with_ball(9);
    let mut mesh = Mesh::uniform(&scene, 2, 1).unwrap();
    let mut go_on = |_| ControlFlow::Continue(());
    let noise = 0.03;
    let solved = solve_by_rays(&scene, &mut mesh, noise, &mut go_on).unwrap();
    let texels = mesh.texels.iter().zip(&solved.irradiance);
    let reflected: Vec<Vec3> = texels.map(|(texel, h)| texel.reflectance * *h).collect();
    let judged = gather_residual_by_rays(&scene, &mesh, &reflected, noise, &mut go_on).unwrap();
    let (mut off, mut told) = ([0.0; 2], [0.0; 2]);
    for (k, texel) in mesh.texels.iter().enumerate() {
        let once = judged.irradiance[k];
        for (n, found) in [once, once + judged.later[k]].into_iter().enumerate() {
            let rho = texel.reflectance.y;
            off[n] += texel.area * (rho * (found - solved.irradiance[k]).y).powi(2);
            told[n] += texel.area * rho * rho * (judged.variance[n][k] + solved.noise[k] * solved.noise[k]).y;
        }
    }
    // Of 1200 texels both are within a tenth; light of two bounces is common to neighbours.
    for (off, told) in off.into_iter().zip(told) {
        assert!((0.6..1.6).contains(&(off / told)), "{off} off, {told} told");
    }
}

/// A hundred lamps among 10 133 faces: the noise of means over four requested texels falls less than that of the texels.
#[test]
fn means_over_requested_texels_have_the_noise_that_is_aimed_at() {
    let Some(data) = data_folder() else { return };
    let mut scene = load_scene(&data.join("meshes/dungeon.obj"), &ImportOptions::default()).unwrap();
    for (k, face) in scene.faces.iter_mut().enumerate() {
        face.reflectance = Vec3::splat(0.6);
        face.emission = Vec3::splat(if k % 100 == 0 { 30.0 } else { 0.0 });
    }
    let requested = 0.03;
    let estimate = solve_to_error(&scene, requested, 2).estimate.unwrap();
    assert!(estimate.error <= requested, "{}", estimate.error);
}
