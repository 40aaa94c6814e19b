//! Radiance maps of walls: written, painted on, and read back.

use common::Error;
use common::capture::maps::{MappedRoom, read, write};
use common::scene::{Face, Scene};
use common::solution::pixels::ImagePlanes;
use common::solution::write::encode_exr;
use common::text::escape_control;
use glam::{DVec3, Vec3};
use radiosity_tests::composites::pixel_bits;
use radiosity_tests::radiance_files::empty_folder;
use radiosity_tests::{box_faces, named_scene};
use std::collections::BTreeMap;
use std::f32::consts::PI;
use std::fs;
use std::path::Path;

/// A room with irregular coordinates and a two-sided triangle whose name is not allowed for a file.
fn lit() -> (Scene, Vec<[u32; 2]>, Vec<Vec3>) {
    let (low, high) = (DVec3::new(0.1, -1.0 / 3.0, 2.7e-3), DVec3::new(3.3, 2.1, 4.7));
    let mut faces = box_faces(low, high, true, Vec3::new(0.1, 0.2, 0.0), Vec3::new(0.7, 0.3, 0.1));
    let corners = [low, DVec3::new(1.0, 0.7, 0.3), high];
    faces.push(Face::triangle("../ä/\n", corners, Vec3::ZERO, Vec3::splat(0.5)));
    let scene = Scene {
        faces,
        ..named_scene("odd", Vec::new())
    };
    let scene = scene.two_sided();
    let resolution = |face: &Face| match face.outline().len() {
        3 => [5, 5],
        _ => [7, 3],
    };
    let resolutions: Vec<[u32; 2]> = scene.faces.iter().map(resolution).collect();
    let count: u32 = resolutions.iter().map(|[w, h]| w * h).sum();
    // All exponents, because the rounding of π·(B/π) differs between them.
    let value = |k: u32| f32::from_bits((k.wrapping_mul(2_654_435_761) >> 2) % 0x5d00_0000);
    let radiosity = (0..count).map(|k| Vec3::new(value(3 * k), value(3 * k + 1), value(3 * k + 2)));
    (scene, resolutions, radiosity.collect())
}

fn written(name: &str) -> (std::path::PathBuf, Scene, Vec<Vec3>) {
    let folder = empty_folder(name);
    let (scene, resolutions, radiosity) = lit();
    write(&folder, &scene, &resolutions, &radiosity).unwrap();
    (folder, scene, radiosity)
}

#[test]
fn written_room_is_read_back_bit_for_bit() {
    let (folder, scene, radiosity) = written("round");
    let MappedRoom {
        scene: back,
        resolutions,
        radiosity: values,
    } = read(&folder).unwrap();
    assert_eq!(pixel_bits(&values), pixel_bits(&radiosity));
    assert!(back.notes.is_empty(), "{:?}", back.notes);
    assert_eq!(resolutions, lit().1);
    assert_eq!(back.name, scene.name);
    assert_eq!(back.faces.len(), scene.faces.len());
    for (a, b) in back.faces.iter().zip(&scene.faces) {
        // Names come back without control characters.
        assert_eq!((&a.name, a.shape), (&escape_control(&b.name), b.shape));
        assert_eq!(a.corners, b.corners);
        assert_eq!((a.emission, a.reflectance), (b.emission, b.reflectance));
        assert_eq!((a.input_face, a.partner), (b.input_face, b.partner));
    }
    // π·(B/π) would change some bits.
    let rounded: Vec<Vec3> = radiosity.iter().map(|b| *b / PI * PI).collect();
    assert_ne!(rounded, radiosity);
    let mut names: Vec<String> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names.len(), 15, "nothing unfinished stays: {names:?}");
    assert_eq!((&*names[0], &*names[14]), ("000-floor.exr", "room.json"));
    assert_eq!(names[6], "006-______.exr");
    fs::remove_dir_all(folder).unwrap();
}

fn read_planes(path: &Path) -> BTreeMap<String, Vec<f32>> {
    ImagePlanes::read(path, 1 << 10).unwrap().channels
}

fn write_planes(path: &Path, size: [u32; 2], planes: impl IntoIterator<Item = (String, Vec<f32>)>) {
    fs::write(path, encode_exr(size, planes.into_iter().collect()).unwrap()).unwrap();
}

#[test]
fn map_holds_upright_radiance() {
    let (folder, _, radiosity) = written("upright");
    // Seven columns and three rows, the last row of texels first.
    let wall = read_planes(&folder.join("000-floor.exr"));
    for (pixel, value) in wall["R"].iter().enumerate() {
        let texel = (2 - pixel / 7) * 7 + pixel % 7;
        assert_eq!(*value, radiosity[texel].x / PI, "{pixel}");
    }
    let first = 6 * 21;
    let triangle = read_planes(&folder.join("006-______.exr"));
    let same = |(pixel, value): (usize, &f32)| *value == radiosity[first + pixel].z;
    assert!(triangle["radiosity.B"].iter().enumerate().all(same));
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn painted_texels_are_taken_from_their_radiance() {
    let (folder, _, radiosity) = written("painted");
    let path = folder.join("001-ceiling.exr");
    let mut map = read_planes(&path);
    // Upper left pixel: the last row of texels.
    map.get_mut("G").unwrap()[0] = 2.0;
    write_planes(&path, [7, 3], map);
    let path = folder.join("002-left.exr");
    let mut map = read_planes(&path);
    map.retain(|name, _| !name.starts_with("radiosity"));
    write_planes(&path, [7, 3], map);
    let back = read(&folder).unwrap();
    assert_eq!(back.scene.notes.len(), 2, "{:?}", back.scene.notes);
    assert!(
        back.scene.notes[0].starts_with("001-ceiling.exr: 1 of 21"),
        "{:?}",
        back.scene.notes
    );
    assert!(
        back.scene.notes[1].starts_with("002-left.exr: 21 of 21"),
        "{:?}",
        back.scene.notes
    );
    for (k, (value, before)) in back.radiosity.iter().zip(&radiosity).enumerate() {
        let again = *before / PI * PI;
        let truth = match k {
            35 => Vec3::new(again.x, 2.0 * PI, again.z),
            42..63 => again,
            _ => *before,
        };
        assert_eq!(*value, truth, "{k}");
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn broken_folders_are_refused_by_file_and_face() {
    let refusal = |folder: &Path, what: &[&str]| {
        let Err(error @ Error::Input { .. }) = read(folder) else {
            panic!("{what:?} was read");
        };
        let text = error.to_string();
        assert!(what.iter().all(|w| text.contains(w)) && !text.contains('\n'), "{text}");
    };
    let (folder, ..) = written("broken");
    let path = folder.join("003-right.exr");
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() - 1]).unwrap();
    refusal(&folder, &["003-right.exr"]);
    fs::remove_file(&path).unwrap();
    refusal(&folder, &["003-right.exr", "cannot be read"]);
    let three = |value: f32, count: usize| -> Vec<(String, Vec<f32>)> {
        ["R", "G", "B"].map(|name| (name.to_owned(), vec![value; count])).into()
    };
    for (value, count, size) in [(f32::NAN, 21, [7, 3]), (-1.0, 21, [7, 3]), (1.0, 24, [8, 3])] {
        write_planes(&path, size, three(value, count));
        refusal(&folder, &["003-right.exr", "face 3"]);
    }
    write_planes(&path, [7, 3], three(1.0, 21).split_off(1));
    refusal(&folder, &["003-right.exr", "face 3", "R, G and B"]);
    fs::write(&path, &whole).unwrap();
    assert!(read(&folder).is_ok());
    let json = folder.join("room.json");
    let text = fs::read_to_string(&json).unwrap();
    for (from, to, what) in [
        ("\"004-front.exr\"", "\"../004-front.exr\"", "face 4"),
        ("\"004-front.exr\"", "\"/etc/passwd\"", "face 4"),
        ("\"004-front.exr\"", "null", "face 4"),
        ("\"004-front.exr\"", "\"none.exr\"", "none.exr"),
        ("\"quad\"", "\"triangle\"", "face 0"),
        ("  7,\n", "  4294967295,\n", "room.json"),
        ("{", "[", "room.json"),
    ] {
        assert!(text.contains(from));
        fs::write(&json, text.replacen(from, to, 1)).unwrap();
        refusal(&folder, &[what]);
    }
    let (scene, resolutions, radiosity) = lit();
    let short = write(&folder, &scene, &resolutions, &radiosity[1..]);
    assert!(matches!(short, Err(Error::Usage(_))));
    fs::write(folder.join("file"), "").unwrap();
    let nowhere = write(&folder.join("file"), &scene, &resolutions, &radiosity);
    assert!(matches!(nowhere, Err(Error::Write { .. })));
    fs::remove_dir_all(folder).unwrap();
}
