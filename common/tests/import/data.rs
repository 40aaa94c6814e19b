//! Real files outside the repository, in the folder that RADIOSITY_DATA names.

use super::files::{data_folder, enclosed_volume, join_quads};
use common::import::{ImportOptions, load_scene};
use common::scene::{Scene, Shape};
use glam::DVec3;
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

/// Counts quads and triangles.
fn count_quads_and_triangles(scene: &Scene) -> (usize, usize) {
    let quads = scene.faces.iter().filter(|f| f.shape == Shape::Quad).count();
    (quads, scene.faces.len() - quads)
}

/// Name, whether triangles are joined, quads, triangles, and whether the mesh is closed. Triangles are as the data's
/// README counts them, two for a quad.
const KNOWN_MESHES: [(&str, bool, usize, usize, bool); 15] = [
    ("cornell-mcguire/CornellBox-Original.obj", false, 0, 36, false),
    ("cornell-mcguire/CornellBox-Original.glb", false, 0, 36, false),
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
