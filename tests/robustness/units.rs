//! Units from a millionth to a million and places far from the origin, on every solver, in memory and through files.

use common::import::{ImportOptions, load_scene};
use common::precision::find_shape_losses;
use common::scene::Scene;
use common::shooting::replay_log;
use glam::{DVec3, Vec4};
use radiosity_tests::bounds::U;
use radiosity_tests::dense::{assemble_dense, solve_matrix};
use radiosity_tests::engines::{both_engines, engine_settings, mesh_of, shoot_on_cpu};
use radiosity_tests::lit_room;
use radiosity_tests::radiance_files::empty_folder;
use std::f32::consts::PI;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Scene units per unit of `lit_room`, and its distance from the origin in multiples of its size.
const PLACES: [(f64, f64); 7] = [
    (1e-6, 0.0),
    (0.3, 0.1),
    (1000.0, 0.0),
    (1e6, 0.0),
    (1.0, 1e3),
    (1e-6, 1e5),
    (1e6, 1e7),
];

/// The longest side of `lit_room`.
const SIZE: f64 = 4.0;

/// Bound of relative differences. Each texel and corner of the mesh moves by √3·u, which near an edge (half a texel,
/// h = ⅙ of 1/4, away) changes F by √3·u/(h/2) of itself, here 100u, and B by that at each of a handful of reflections.
/// At 1e7 lengths the precision of f64 is 1e−9 of a length, 2 % of u.
const BOUND: f64 = 1000.0 * U;

fn room_moved_and_scaled(scale: f64, lengths: f64) -> Scene {
    let mut scene = lit_room();
    let shift = DVec3::new(1.0, -0.37, 0.61) * lengths * SIZE;
    for face in &mut scene.faces {
        face.corners = face.corners.map(|p| (p + shift) * scale);
    }
    scene
}

/// Returns the largest relative difference of B in the first channel.
fn largest_difference(a: &[Vec4], b: &[Vec4]) -> f64 {
    assert_eq!(a.len(), b.len());
    let pairs = a.iter().zip(b);
    pairs
        .map(|(a, b)| f64::from((a.x - b.x).abs() / b.x))
        .fold(0.0, f64::max)
}

#[test]
fn units_and_places_keep_radiosity_of_dense_solver() {
    let solve = |scene: &Scene| -> Vec<f64> {
        let (mesh, matrix, _) = assemble_dense(scene, 3);
        solve_matrix(&mesh, &matrix).radiosity.iter().map(|b| b.x).collect()
    };
    let expected = solve(&lit_room());
    for (scale, lengths) in PLACES {
        let pairs = solve(&room_moved_and_scaled(scale, lengths));
        let pairs = pairs.iter().zip(&expected);
        let worst = pairs.map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
        // The same bound for f64, plus the rounding of coordinates so far away.
        let bound = 100.0 * f64::EPSILON * (10.0 + lengths);
        assert!(worst < bound, "{scale:e}, {lengths:e}: {worst:e}");
    }
}

fn write_obj(folder: &Path, scene: &Scene) -> PathBuf {
    let (mut text, mut materials) = (String::from("mtllib scene.mtl\n"), String::new());
    for (k, face) in scene.faces.iter().enumerate() {
        let (rho, light) = (face.reflectance, face.emission / PI);
        writeln!(materials, "newmtl m{k}\nKd {} {} {}", rho.x, rho.y, rho.z).unwrap();
        writeln!(materials, "Ke {} {} {}", light.x, light.y, light.z).unwrap();
        for p in face.outline() {
            writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
        }
        writeln!(text, "usemtl m{k}\nf -4 -3 -2 -1").unwrap();
    }
    std::fs::write(folder.join("scene.mtl"), materials).unwrap();
    std::fs::write(folder.join("scene.obj"), text).unwrap();
    folder.join("scene.obj")
}

fn read_scene(path: &Path) -> Scene {
    load_scene(path, &ImportOptions::default()).unwrap()
}

#[test]
fn files_in_any_unit_and_place_give_same_radiosity_of_both_engines() {
    let folder = empty_folder("units");
    let run = shoot_on_cpu(&mesh_of(&lit_room()), &engine_settings());
    for (scale, lengths) in PLACES {
        let scene = read_scene(&write_obj(&folder, &room_moved_and_scaled(scale, lengths)));
        let mesh = mesh_of(&scene);
        assert_eq!(mesh.unit.log2().fract(), 0.0, "the unit is a power of two");
        let found = both_engines(&mesh, &engine_settings().transport).map(|mut engine| {
            let replayed = replay_log(&mut *engine, &run.shooter_log()).unwrap();
            largest_difference(&replayed.field.radiosity, &run.field.radiosity)
        });
        assert!(
            found.iter().all(|off| *off < BOUND),
            "{scale:e}, {lengths:e}: {found:?}"
        );
        assert_eq!(find_shape_losses(&scene, &mesh, 0.02), [], "{scale:e}, {lengths:e}");
    }
}

/// A text file rounded to six digits, a thousand units away.
#[test]
fn digits_lost_in_a_file_are_reported() {
    let folder = empty_folder("lost");
    let text = "v 1000.12 0 0\nv 1000.13 0 0\nv 1000.13 1.23457 0\nv 1000.12 1.23456 0\nv 1000.12 0 4.56789\nf 1 2 3 4\nf 1 4 5\n";
    std::fs::write(folder.join("scene.obj"), text).unwrap();
    let scene = read_scene(&folder.join("scene.obj"));
    let told = find_shape_losses(&scene, &mesh_of(&scene), 0.02);
    assert_eq!(told.iter().map(|loss| loss.face).collect::<Vec<_>>(), [0]);
    assert!(told[0].file_part > 0.9 * told[0].error);
}
