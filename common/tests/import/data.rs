//! Real files outside the repository, in the folder that RADIOSITY_DATA names.

use super::files::{Folder, data_folder, join_quads};
use approx::abs_diff_eq;
use common::import::{ImportOptions, load_scene};
use common::scene::{Face, Scene, Shape};
use glam::{DVec3, Vec3};
use std::fs;
use std::path::{Path, PathBuf};

/// Returns the folder of meshes.
fn folder() -> Option<PathBuf> {
    Some(data_folder()?.join("meshes"))
}

fn scene(folder: &Path, name: &str) -> Scene {
    load_scene(&folder.join(name), &ImportOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn load_joined(folder: &Path, name: &str) -> Scene {
    load_scene(&folder.join(name), &join_quads()).unwrap_or_else(|error| panic!("{error}"))
}

fn bounds(scene: &Scene) -> (DVec3, DVec3) {
    let corners = || scene.faces.iter().flat_map(|f| f.outline());
    (
        corners().fold(DVec3::INFINITY, |low, c| low.min(*c)),
        corners().fold(DVec3::NEG_INFINITY, |high, c| high.max(*c)),
    )
}

/// Counts quads and triangles.
fn count_quads_and_triangles(scene: &Scene) -> (usize, usize) {
    let quads = scene.faces.iter().filter(|f| f.shape == Shape::Quad).count();
    (quads, scene.faces.len() - quads)
}

/// Returns the volume of a closed mesh with fronts outwards.
fn enclosed_volume(scene: &Scene) -> f64 {
    let cone = |c: &[DVec3]| c.windows(2).map(|w| c[0].dot(w[0].cross(w[1]))).sum::<f64>() / 6.0;
    scene.faces.iter().map(|f| cone(f.outline())).sum()
}

#[test]
fn mcguire_cornell_box_has_known_bounds_lamp_and_colours() {
    let Some(folder) = folder() else { return };
    let obj = scene(&folder, "cornell-mcguire/CornellBox-Original.obj");
    let glb = scene(&folder, "cornell-mcguire/CornellBox-Original.glb");
    let (quads, triangles) = count_quads_and_triangles(&obj);
    assert_eq!((2 * quads + triangles, glb.faces.len()), (36, 36));
    for scene in [&obj, &glb] {
        let (low, high) = bounds(scene);
        assert!(low.abs_diff_eq(DVec3::new(-1.02, 0.0, -1.04), 1e-6), "{low}");
        assert!(high.abs_diff_eq(DVec3::new(1.0, 1.99, 0.99), 1e-6), "{high}");
        let light: Vec<_> = scene.faces.iter().filter(|f| f.emission != Vec3::ZERO).collect();
        let expected = Vec3::new(17.0, 12.0, 4.0) * std::f32::consts::PI;
        assert!(light.iter().all(|f| f.emission.abs_diff_eq(expected, 1e-4)));
        let area = light.iter().map(|f| f.vector_area()).sum::<DVec3>();
        assert!((area - DVec3::new(0.0, -0.47 * 0.38, 0.0)).length() < 1e-6, "{area}");
    }
    let area = |s: &Scene| s.faces.iter().map(|f| f.area()).sum::<f64>();
    assert!(abs_diff_eq!(area(&obj), area(&glb), epsilon = 1e-5 * area(&obj)));
    let reflectance = |name: &str| obj.faces.iter().find(|f| f.name == name).map(|f| f.reflectance);
    assert_eq!(reflectance("rightWall"), Some(Vec3::new(0.14, 0.45, 0.091)));
    assert_eq!(reflectance("leftWall"), Some(Vec3::new(0.63, 0.065, 0.05)));
}

/// Name, whether triangles are joined, quads, triangles, and whether the mesh is closed. Triangles are as the data's
/// README counts them, two for a quad.
const KNOWN_MESHES: [(&str, bool, usize, usize, bool); 13] = [
    ("../cornell/cornell_measured.obj", false, 15, 2, false),
    ("../truth/cornell.obj", false, 19, 0, false),
    ("bunny_4k.obj", false, 0, 3674, true),
    ("bunny_16k.obj", false, 0, 16000, false),
    ("bunny.glb", false, 0, 5696, true),
    ("teapot.obj", false, 0, 6320, false),
    ("spot.obj", false, 0, 5856, true),
    ("spot_quads.obj", false, 0, 5856, true),
    ("dungeon.obj", false, 0, 10133, false),
    ("dungeon.glb", false, 0, 10133, false),
    ("Box_embedded.gltf", false, 0, 12, true),
    ("Box_embedded.gltf", true, 6, 0, true),
    ("trimesh/BoxInterleaved.glb", true, 6, 0, true),
];

#[test]
fn known_meshes_have_expected_faces_and_orientation() {
    let Some(folder) = folder() else { return };
    for (name, joined, quads, triangles, closed) in KNOWN_MESHES {
        let scene = if joined {
            load_joined(&folder, name)
        } else {
            scene(&folder, name)
        };
        let found = count_quads_and_triangles(&scene);
        assert_eq!(2 * found.0 + found.1, 2 * quads + triangles, "{name}");
        assert!(quads == 0 || found == (quads, triangles), "{name}: {:?}", scene.notes);
        let open = scene.faces.iter().map(|f| f.vector_area()).sum::<DVec3>().length();
        let area = scene.faces.iter().map(|f| f.area()).sum::<f64>();
        assert_eq!(open < 1e-6 * area, closed, "{name}: open by {open} of {area}");
        assert!(!closed || enclosed_volume(&scene) > 0.0, "{name} is inside out");
    }
    // Of 18 quads the left wall and two more of the original box are bent.
    let original = load_joined(&folder, "cornell-mcguire/CornellBox-Original.glb");
    let (quads, triangles) = count_quads_and_triangles(&original);
    assert!(quads >= 15 && 2 * quads + triangles == 36, "{quads}");
}

#[test]
fn non_planar_quads_are_split() {
    let Some(folder) = folder() else { return };
    for (name, input_faces) in [("spot_quads.obj", 2928), ("../cornell/cornell_measured.obj", 16)] {
        let scene = scene(&folder, name);
        let pieces = scene.faces.iter().filter(|f| f.input_face.is_some()).count();
        // One entry for each quad, and one more for each that is split.
        assert_eq!(scene.faces.len() - pieces / 2, input_faces, "{name}");
        for (k, face) in scene.faces.iter().enumerate() {
            let own = face.input_face.is_none_or(|from| from as usize == k);
            assert!(if k < input_faces {
                own
            } else {
                face.input_face.is_some()
            });
        }
    }
}

/// Irregular files with their number of faces, or a part of their error.
const IRREGULAR_FILES: &str = "
trimesh/BoxInterleaved.glb => 12
trimesh/BoxTextured.glb => 12
trimesh/boolean.glb => 3936
trimesh/nested.glb => 36
trimesh/no_indices_3storybuilding.glb => 72
trimesh/wallhole.obj => line 3: the material file 00.mtl cannot be read
trimesh/odd-obj/cubevt.obj => 12
trimesh/odd-obj/empty.obj => has no faces
trimesh/odd-obj/face_in_group_name.obj => has no faces
trimesh/odd-obj/face_in_group_name_mid_file.obj => 2
trimesh/odd-obj/joined_tetrahedra.obj => 8
trimesh/odd-obj/nancolor.obj => 12
trimesh/odd-obj/negative_indices.obj => 6
trimesh/odd-obj/notenoughindices.obj => line 1: the material file surface.mtl cannot be read
trimesh/odd-obj/obj_points.obj => has no faces
trimesh/odd-obj/obj_wireframe.obj => has no faces
trimesh/odd-obj/obj_with_no_face_in_chunk.obj => line 8: material mat-1 is not defined
trimesh/odd-obj/polygonfaces.obj => line 1: the material file surface.mtl cannot be read
trimesh/odd-obj/singlevn.obj => line 1: the material file surface.mtl cannot be read
trimesh/odd-obj/textured_tetrahedron.obj => 4
trimesh/odd-obj/two_objects.obj => 16
odd-gltf/TestScene.gltf => buffer 0: TestScene.bin cannot be read
odd-gltf/box_sparse.glb => 12
odd-gltf/empty_nodes.glb => has no faces
odd-gltf/mode5.gltf => 2786
";

#[test]
fn irregular_files_load_or_fail_as_expected() {
    let Some(folder) = folder() else { return };
    let rows: Vec<_> = IRREGULAR_FILES
        .lines()
        .filter_map(|row| row.split_once(" => "))
        .collect();
    for (name, expected) in &rows {
        let found = load_scene(&folder.join(name), &ImportOptions::default());
        match (found.map(|scene| scene.faces.len()), expected.parse::<usize>()) {
            (Ok(faces), Ok(count)) => assert_eq!(faces, count, "{name}"),
            (Err(error), Err(_)) => assert!(error.to_string().contains(expected), "{name}: {error}"),
            (found, _) => panic!("{name}: {found:?} instead of {expected}"),
        }
    }
    let is_scene = |path: &Path| {
        path.extension()
            .is_some_and(|e| e == "obj" || e == "gltf" || e == "glb")
    };
    let files = |sub: &str| {
        let entries = fs::read_dir(folder.join(sub)).expect("a folder of the data");
        entries.flatten().filter(|e| is_scene(&e.path())).count()
    };
    let count: usize = ["trimesh", "trimesh/odd-obj", "odd-gltf"].map(files).iter().sum();
    assert_eq!(count, rows.len(), "a file is missing from the table");
}

/// Loads two irregular files without their dangling references.
#[test]
fn irregular_files_load_without_material_lines() {
    let Some(folder) = folder() else { return };
    let bare = |name: &str| {
        let text = fs::read_to_string(folder.join(name)).expect(name);
        let kept = text
            .lines()
            .filter(|l| !l.starts_with("mtllib") && !l.starts_with("usemtl"));
        Folder::new()
            .with("a.obj", kept.collect::<Vec<_>>().join("\n"))
            .load("a.obj")
            .unwrap_or_else(|e| panic!("{name}: {e}"))
    };
    assert_eq!(bare("trimesh/odd-obj/notenoughindices.obj").faces.len(), 1);
    // Walls with holes cut into their outlines: 13 faces of 92 corners.
    let walls = bare("trimesh/wallhole.obj");
    assert_eq!(count_quads_and_triangles(&walls), (0, 92 - 2 * 13));
    let pieces = |k: Option<u32>| walls.faces.iter().filter(move |f| f.input_face == k);
    let normal = |k: Option<u32>| pieces(k).map(|f| f.vector_area()).sum::<DVec3>();
    assert!((0..13).map(|k| normal(Some(k))).sum::<DVec3>().length() < 1e-9);
    let forwards = |f: &Face| f.vector_area().dot(normal(f.input_face)) > 0.0;
    assert!(walls.faces.iter().all(forwards), "a piece faces backwards");
}
