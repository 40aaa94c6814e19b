//! Bundled scenes: each has its stated faces. The bundled radiance map is a panorama.

use crate::import::files::{data_folder, enclosed_volume};
use approx::abs_diff_eq;
use common::capture::{MapProjection, Panorama, RepairCounts};
use common::import::{ImportOptions, load_scene};
use common::scene::{Face, Scene, Shape};
use glam::{DVec3, Vec3};
use std::path::{Path, PathBuf};

/// Triangles of the furnished room.
const ROOM_FACES: usize = 313;
/// Checksum of the radiance map.
const STUDIO_CRC32: u32 = 0x5e8f_5e54;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes")
}

fn scene(name: &str) -> Scene {
    scene_at(&folder().join(name))
}

fn scene_at(path: &Path) -> Scene {
    load_scene(path, &ImportOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn vector_area<'a>(faces: impl IntoIterator<Item = &'a Face>) -> DVec3 {
    faces.into_iter().map(Face::vector_area).sum()
}

/// Returns whether `centre` lies in front of the face.
fn faces_inwards(face: &Face, centre: DVec3) -> bool {
    face.vector_area().dot(centre - face.corners[0]) > 0.0
}

/// A front that is turned over changes the sum of the vector areas or the volume.
#[test]
fn scenes_have_expected_faces_areas_and_fronts() {
    // Name, quads, triangles, area, least area of a face, volume (of the cone from the origin if open), and whether the
    // scene is closed.
    let (lamp, blocks, plates) = (0.0045, 0.027 + 0.054, -1.0 / 3.0);
    let expected = [
        ("paper_room", 156, 0, 6.0 + 0.24, 0.015, lamp - 1.0, true),
        (
            "paper_room_objects",
            168,
            0,
            6.0 + 0.24 + 0.9 + 0.54,
            0.015,
            lamp + blocks - 1.0,
            true,
        ),
        ("furnace", 6, 0, 6.0, 1.0, -1.0, true),
        ("facing_plates", 2, 0, 2.0, 1.0, plates, true),
        ("perpendicular_plates", 2, 0, 2.0, 1.0, 0.0, false),
        ("occluded_plates", 8, 0, 2.54, 0.01, plates + 0.005, true),
        ("slivers", 5, 6, 6.0, 5e-4, -1.0, true),
    ];
    for (name, quads, triangles, area, least, volume, closed) in expected {
        let scene = scene(&format!("{name}.obj"));
        let found = scene.faces.iter().filter(|f| f.shape == Shape::Quad).count();
        assert_eq!((found, scene.faces.len() - found), (quads, triangles), "{name}");
        assert_eq!(scene.notes, [""; 0], "{name}");
        let areas = || scene.faces.iter().map(Face::area);
        let sums = [
            areas().sum(),
            areas().fold(f64::INFINITY, f64::min),
            enclosed_volume(&scene),
        ];
        let near = (0..3).all(|k| abs_diff_eq!(sums[k], [area, least, volume][k], epsilon = 1e-5));
        assert!(near, "{name}: {sums:?} instead of {area}, {least} and {volume}");
        assert_eq!(vector_area(&scene.faces).length() < 1e-9, closed, "{name}");
        let emitted: Vec3 = scene.faces.iter().map(|f| f.emission * f.area() as f32).sum();
        assert!(emitted.min_element() > 0.0, "{name} is dark");
    }
    for face in scene("furnace.obj").faces {
        assert_eq!((face.emission, face.reflectance), (Vec3::ONE, Vec3::splat(0.5)));
    }
}

#[test]
fn blocks_do_not_touch_and_lamp_shines_downwards() {
    let scene = scene("paper_room_objects.obj");
    let corners = |name: &'static str| {
        let block = scene.faces.iter().filter(move |f| f.name == name);
        block.flat_map(|f| f.corners)
    };
    // A vertical plane between the two: x + z = 1.01.
    assert!(corners("tall_block").all(|c| c.x + c.z < 1.0) && corners("short_block").all(|c| c.x + c.z > 1.02));
    assert!(corners("tall_block").chain(corners("short_block")).all(|c| c.y > 0.009));
    let alone: Vec<_> = self::scene("paper_objects.obj")
        .faces
        .iter()
        .map(|f| f.corners)
        .collect();
    let blocks = scene.faces.iter().filter(|f| f.name.ends_with("_block"));
    assert_eq!(alone, blocks.map(|f| f.corners).collect::<Vec<_>>());
    assert_eq!(alone.len(), 12);
    let mut all = scene.faces.iter().flat_map(|face| face.corners);
    assert!(all.all(|c| c.min_element() >= 0.0 && c.max_element() <= 1.0));
    let lit: Vec<_> = scene.faces.iter().filter(|f| f.emission != Vec3::ZERO).collect();
    assert_eq!(lit.len(), 1);
    let downwards = lit[0].vector_area() - DVec3::new(0.0, -0.09, 0.0);
    assert!(downwards.length() < 1e-9, "the lamp shines downwards");
}

#[test]
fn furnished_room_has_one_lamp() {
    let scene = scene("room.glb");
    assert_eq!(scene.notes, [""; 0]);
    assert_eq!(scene.faces.len(), ROOM_FACES);
    let size = DVec3::new(4.2, 2.8, 4.0);
    for face in &scene.faces {
        let inside = |c: &DVec3| c.min_element() >= 0.0 && (*c - size).max_element() < 1e-6;
        assert!(face.corners.iter().all(inside), "{}", face.name);
        let is_wall = ["floor", "ceiling"].contains(&&*face.name) || face.name.ends_with("_wall");
        assert!(!is_wall || faces_inwards(face, size / 2.0), "{}", face.name);
        let radiance = match face.name.as_str() {
            "lamp" => Vec3::new(40.0, 32.0, 22.0),
            _ => Vec3::ZERO,
        };
        let emission = radiance * std::f32::consts::PI;
        assert!(
            face.emission.abs_diff_eq(emission, 1e-4),
            "{}: {}",
            face.name,
            face.emission
        );
    }
    let lamp = || scene.faces.iter().filter(|face| face.name == "lamp");
    assert_eq!(lamp().count(), 42);
    assert!(vector_area(lamp()).length() < 1e-6, "the lamp is closed");
    assert!(lamp().all(|face| !faces_inwards(face, DVec3::new(2.6, 2.0, 2.1))));
}

#[test]
fn studio_is_a_panorama_with_lamp_and_window() {
    let path = folder().join("studio.hdr");
    assert_eq!(crc32fast::hash(&std::fs::read(&path).unwrap()), STUDIO_CRC32);
    let map = Panorama::read(&path, None).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((map.size(), map.projection()), ([256, 128], MapProjection::LatLong));
    assert_eq!((&map.counts, &map.notes[..]), (&RepairCounts::default(), &[][..]));
    // The room is 5 × 3 × 6 m about the eye: the lamp on the ceiling, the window on the left.
    for (direction, radiance) in [
        ([0.0, 1.5, -0.6], [8.0, 6.5, 4.5]),
        ([2.5, 0.4, 1.7], [26.0, 27.0, 28.0]),
    ] {
        let seen = map.radiance(DVec3::from(direction));
        assert!(seen.abs_diff_eq(radiance.into(), 0.2), "{seen} from {direction:?}");
    }
}

#[test]
fn cornell_box_equals_measured_data() {
    let scene = scene("cornell_box.obj");
    assert_eq!(scene.faces.len(), 17);
    assert_eq!(scene.notes, ["1 face not planar: split into two triangles (6)"]);
    let middle = |name: &str| match name {
        "short_block" => Some(DVec3::new(186.0, 80.0, 168.0)),
        "tall_block" => Some(DVec3::new(368.0, 160.0, 351.0)),
        _ => None,
    };
    for face in &scene.faces {
        // A face of a block is seen from outside of it, and another one from the room's centre.
        let block = middle(&face.name);
        let inwards = faces_inwards(face, block.unwrap_or(DVec3::splat(278.0)));
        assert_eq!(inwards, block.is_none(), "{}", face.name);
    }
    let Some(data) = data_folder() else { return };
    let measured = data.join("cornell/cornell_measured.obj");
    let measured = scene_at(&measured);
    for (ours, theirs) in scene.faces.iter().zip(&measured.faces) {
        assert_eq!((&ours.name, ours.reflectance), (&theirs.name, theirs.reflectance));
        assert_eq!(ours.emission, theirs.emission);
    }
    let outline = |s: &Scene, k: usize| {
        let mut corners: Vec<[f64; 3]> = s.faces[k].outline().iter().map(DVec3::to_array).collect();
        let least = (0..corners.len()).min_by(|a, b| corners[*a].partial_cmp(&corners[*b]).expect("numbers"));
        corners.rotate_left(least.unwrap_or(0));
        corners
    };
    let all = |s: &Scene| {
        let mut faces: Vec<_> = (0..s.faces.len()).map(|k| outline(s, k)).collect();
        faces.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
        faces
    };
    assert_eq!(all(&scene), all(&measured));
}
