//! Relighting by rays: the change equals that of the dense solution within the told noise, and where no light of the
//! objects arrives no bit changes.

use common::mesh::Mesh;
use common::scene::{Face, Scene};
use cpu::hierarchy::relight::RoomLight;
use cpu::hierarchy::solver::TexelSolution;
use cpu::ray_cast::relight::relight_by_rays;
use glam::{DVec3, Vec3};
use radiosity_tests::dense::{assemble_dense, solve_matrix};
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::relighting::bottomless_box;
use radiosity_tests::{ball, box_faces, named_scene};
use std::ops::ControlFlow;

const REQUESTED_NOISE: f32 = 0.01;

/// An empty room whose lamp is its ceiling, or 20 cm wide.
fn empty_room(small_lamp: bool) -> Vec<Face> {
    let size = DVec3::new(3.0, 2.0, 4.0);
    let mut faces = box_faces(DVec3::ZERO, size, true, Vec3::ZERO, Vec3::new(0.7, 0.6, 0.5));
    match small_lamp {
        false => faces[1].emission = Vec3::new(5.0, 4.0, 3.0),
        true => {
            let corners = rectangle([1.4, 1.8, 1.9], [0.2, 0.0, 0.0], [0.0, 0.0, 0.2]);
            faces.push(Face::quad("lamp", corners, Vec3::splat(300.0), Vec3::splat(0.5)));
        }
    }
    faces
}

/// B₀ and H₀ of the first `count` faces of `scene` by the dense solution, on the texels of `mesh`.
fn light_of_room(scene: &Scene, count: usize, texels: u32, mesh: &Mesh) -> [Vec<Vec3>; 2] {
    let mut room = scene.clone();
    room.faces.truncate(count);
    let (empty, matrix, _) = assemble_dense(&room, texels);
    let truth = solve_matrix(&empty, &matrix);
    let mut radiosity: Vec<Vec3> = truth.radiosity.iter().map(|b| b.as_vec3()).collect();
    let received = radiosity
        .iter()
        .zip(&empty.texels)
        .map(|(b, t)| (*b - t.emission) / t.reflectance);
    let mut irradiance: Vec<Vec3> = received.collect();
    radiosity.resize(mesh.texels.len(), Vec3::ZERO);
    irradiance.resize(mesh.texels.len(), Vec3::ZERO);
    [radiosity, irradiance]
}

fn relight(
    scene: &Scene,
    mesh: &Mesh,
    [radiosity, irradiance]: &[Vec<Vec3>; 2],
    blocks: Vec<[u32; 2]>,
) -> TexelSolution {
    let known = RoomLight {
        radiosity,
        irradiance,
        open: &vec![1.0; radiosity.len()],
    };
    let mut go_on = |_| ControlFlow::Continue(());
    relight_by_rays(scene, mesh, &known, blocks, REQUESTED_NOISE, &mut go_on).unwrap()
}

fn single_texels(mesh: &Mesh) -> Vec<[u32; 2]> {
    vec![[1; 2]; mesh.texels.len()]
}

/// The told noise is a mean over at least 100 texels of squares of two halves' differences, which bounces make depend on
/// each other: its relative deviation is about a tenth to a fifth.
#[test]
fn told_noise_is_the_error_against_the_dense_solution() {
    let grey = Vec3::splat(0.6);
    let round = ball(DVec3::new(1.4, 0.9, 1.9), 0.5, [8, 16]);
    let lamp = bottomless_box(Vec3::new(0.0, 2.0, 6.0), grey);
    for (name, small_lamp, objects, texels) in [
        ("ball under a ceiling that shines", false, round.clone(), 4),
        ("ball under a small lamp", true, round, 4),
        ("box that shines", false, lamp, 8),
    ] {
        let mut faces = empty_room(small_lamp);
        let count = faces.len();
        faces.extend(objects);
        let scene = named_scene(name, faces);
        let (mut mesh, matrix, _) = assemble_dense(&scene, texels);
        mesh.room_faces = count as u32;
        let truth = solve_matrix(&mesh, &matrix);
        let known = light_of_room(&scene, count, texels, &mesh);
        let found = relight(&scene, &mesh, &known, single_texels(&mesh));
        let (mut off, mut told, mut light, mut changed) = (0.0, 0.0, 0.0, 0.0);
        for (k, texel) in mesh.texels.iter().enumerate() {
            let [area, rho] = [texel.area, texel.reflectance.y].map(f64::from);
            let reflected = truth.radiosity[k].y - f64::from(texel.emission.y);
            let before = f64::from(known[1][k].y);
            off += area * (rho * (before + f64::from(found.irradiance[k].y)) - reflected).powi(2);
            told += area * rho * rho * f64::from(found.noise[k].y).powi(2);
            light += area * reflected * reflected;
            changed += area * (rho * before - reflected).powi(2);
        }
        let [off, told, changed] = [off / light, told / light, changed / light].map(f64::sqrt);
        println!("{name}: {off} off, {told} told, {changed} changed");
        assert!(
            told <= f64::from(REQUESTED_NOISE * (1.0 + REQUESTED_NOISE)),
            "{name}: {told}"
        );
        assert!((0.6..1.6).contains(&(off / told)), "{name}: {off} off, {told} told");
        assert!(changed > 10.0 * told, "{name}: {changed}");
    }
}

/// Blocks as large as the room's faces: each receives its mean.
#[test]
fn blocks_receive_the_mean_of_their_texels() {
    let mut faces = empty_room(false);
    let count = faces.len();
    faces.extend(ball(DVec3::new(1.4, 0.9, 1.9), 0.5, [8, 16]));
    let scene = named_scene("ball under a ceiling that shines", faces);
    let texels = 4;
    let (mut mesh, matrix, _) = assemble_dense(&scene, texels);
    mesh.room_faces = count as u32;
    let truth = solve_matrix(&mesh, &matrix);
    let known = light_of_room(&scene, count, texels, &mesh);
    let found = relight(&scene, &mesh, &known, vec![[texels; 2]; mesh.texels.len()]);
    let of_face = |f: usize, light: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let own = (0..mesh.texels.len()).filter(|k| mesh.texels[*k].face as usize == f);
        own.map(light).collect()
    };
    let (mut off, mut within, mut light) = (0.0, 0.0, 0.0);
    for f in 0..count {
        let rho = f64::from(mesh.texels[f * (texels * texels) as usize].reflectance.y);
        let emission = f64::from(scene.faces[f].emission.y);
        let before = |k: usize| f64::from(known[1][k].y);
        let exact = of_face(f, &|k| truth.radiosity[k].y - emission - rho * before(k));
        let reflected = of_face(f, &|k| truth.radiosity[k].y - emission);
        let own = of_face(f, &|k| rho * f64::from(found.irradiance[k].y));
        let mean = exact.iter().sum::<f64>() / exact.len() as f64;
        off += own.iter().map(|change| (change - mean).powi(2)).sum::<f64>();
        within += exact.iter().map(|change| (change - mean).powi(2)).sum::<f64>();
        light += reflected.iter().map(|b| b * b).sum::<f64>();
    }
    let [off, within] = [off / light, within / light].map(f64::sqrt);
    println!("{off} off, {within} within blocks");
    assert!(off <= f64::from(3.0 * REQUESTED_NOISE), "{off}");
    assert!(within > 10.0 * off, "{within} within blocks, {off} off");
}

#[test]
fn light_of_another_room_keeps_its_bits() {
    let mut faces = empty_room(false);
    let apart = DVec3::new(3.5, 0.0, 0.0);
    let other = empty_room(true).into_iter().map(|face| Face {
        corners: face.corners.map(|c| c + apart),
        ..face
    });
    let near = faces.len();
    faces.extend(other);
    let count = faces.len();
    faces.extend(ball(DVec3::new(1.4, 0.9, 1.9), 0.5, [8, 16]));
    let scene = named_scene("two rooms", faces);
    let (texels, mut mesh) = (4, Mesh::uniform(&scene, 4, 1).unwrap());
    mesh.room_faces = count as u32;
    let found = relight(
        &scene,
        &mesh,
        &light_of_room(&scene, count, texels, &mesh),
        single_texels(&mesh),
    );
    let mut darkened = 0;
    for (texel, change) in mesh.texels.iter().zip(&found.irradiance) {
        let face = texel.face as usize;
        assert!(
            !(near..count).contains(&face) || *change == Vec3::ZERO,
            "{change} on face {face}"
        );
        darkened += u32::from(face < near && change.y < 0.0);
    }
    // All of the floor lies under the ball's view of the ceiling.
    assert!(darkened >= texels * texels, "{darkened}");
}
