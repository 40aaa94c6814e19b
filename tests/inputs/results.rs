//! Readers of stored results: `result.json` with its lightmap, a room's maps, and the list of a result's files.

use crate::allow_caught_panics;
use crate::folder::Folder;
use crate::requirements::{require_one_line, require_sound_faces, require_sound_solution};
use common::capture::maps;
use common::solution::write::encode_exr;
use common::solution::{StoredSolution, write_files};
use oracle::diff::Diff;
use std::fs;

/// A square and a triangle of 2×2 texels each.
const TWO_FACES: &str = r#"{"scene":"two","faces":[
    {"name":"square","kind":"quad","corners":[[0,0,0],[1,0,0],[1,1,0],[0,1,0]],"texels":[2,2],"rect":[0,0,2,2],
     "file":"0.exr","emission":[1,1,1],"reflectance":[0.5,0.5,0.5]},
    {"name":"triangle","kind":"triangle","corners":[[0,0,1],[0,1,1],[1,1,1]],"texels":[2,2],"rect":[2,0,2,2],
     "file":"1.exr"}]}"#;

/// Largest number of texels of a result that is compared with itself.
const MAX_COMPARED_TEXELS: usize = 4096;

thread_local! {
    static RESULT_FOLDER: Folder = Folder::new(&[("lightmap.exr", &image([8, 4], &["", "emission.", "sky."]))]);
    static LIGHTMAP_FOLDER: Folder = Folder::new(&[("result.json", TWO_FACES.as_bytes())]);
    static ROOM_FOLDER: Folder = Folder::new(&[
        ("room.json", TWO_FACES.as_bytes()),
        ("0.exr", &image([2, 2], &["", "radiosity."])),
        ("1.exr", &image([2, 2], &[""])),
    ]);
}

/// Encodes an image with the channels R, G and B after each of these prefixes.
fn image(size: [u32; 2], prefixes: &[&str]) -> Vec<u8> {
    let names = prefixes
        .iter()
        .flat_map(|prefix| ["R", "G", "B"].map(|letter| format!("{prefix}{letter}")));
    let values: Vec<f32> = (0..size[0] * size[1]).map(|k| k as f32 / 32.0).collect();
    encode_exr(size, names.map(|name| (name, values.clone())).collect()).expect("an image")
}

/// Checks the reader of `result.json`, beside a lightmap of 8×4 pixels.
pub fn check_result(data: &[u8]) {
    RESULT_FOLDER.with(|folder| {
        folder.write("result.json", data);
        require_sound_result(folder);
    });
}

/// Checks the reader of `lightmap.exr`, beside a description of two faces.
pub fn check_lightmap(data: &[u8]) {
    allow_caught_panics();
    LIGHTMAP_FOLDER.with(|folder| {
        folder.write("lightmap.exr", data);
        require_sound_result(folder);
    });
}

/// Checks the reader of a room's maps: the first byte chooses whether the rest is `room.json` or the map of its first face.
pub fn check_room(data: &[u8]) {
    allow_caught_panics();
    let Some((first, rest)) = data.split_first() else {
        return;
    };
    let (name, other) = match first {
        b'0' => ("0.exr", image([2, 2], &["", "radiosity."])),
        _ => ("room.json", TWO_FACES.as_bytes().to_vec()),
    };
    ROOM_FOLDER.with(|folder| {
        folder.write(name, rest);
        match maps::read(folder.as_ref()) {
            Ok(room) => {
                require_sound_faces(&room.scene);
                let texels = room.resolutions.iter().map(|[w, h]| (w * h) as usize);
                assert_eq!(texels.sum::<usize>(), room.radiosity.len());
                assert!(room.radiosity.iter().all(|value| value.length_squared().is_finite()));
            }
            Err(error) => require_one_line(&error),
        }
        folder.write(name, &other);
    });
}

/// Checks that a new result removes nothing outside of its folder, whatever files the description of the result before lists.
pub fn check_outdated_files(data: &[u8]) {
    let folder = Folder::new(&[("out/result.json", data), ("beside/a", b""), ("out/maps/a", b"")]);
    let empty = folder.path("empty");
    fs::create_dir(&empty).expect("a folder");
    let description = r#"{"files":{"b":"00000000"}}"#;
    match write_files(&folder.path("out"), [("result.json", description)]) {
        Ok(()) => {
            let written = fs::read(folder.path("out/result.json")).expect("the new description");
            assert_eq!(written, description.as_bytes());
        }
        Err(error) => require_one_line(&error),
    }
    assert!(empty.is_dir() && folder.path("beside/a").is_file());
}

fn require_sound_result(folder: &Folder) {
    let stored = match StoredSolution::read(folder.as_ref()) {
        Ok(stored) => stored,
        Err(error) => return require_one_line(&error),
    };
    require_sound_solution(&stored);
    if stored.radiosity.len() <= MAX_COMPARED_TEXELS {
        match Diff::new(&stored, &stored) {
            Ok(diff) => assert_eq!(diff.worst_rms(), 0.0, "a result differs from itself"),
            Err(error) => require_one_line(&error),
        }
    }
}
