//! `relight` run as a program: rooms of every kind, the files it writes.

use super::command::TestFolder;
use super::room::folder_with_room;
use serde_json::{Value, json};

/// Files that a relight writes.
const OUTPUTS: [&str; 6] = [
    "lightmap.exr",
    "result.json",
    "composite.exr",
    "background.exr",
    "composite.png",
    "report.html",
];

/// Runs `relight` with these options into `out`, over files that it must replace; returns its result.
fn relight(folder: &TestFolder, options: &str, out: &str) -> Value {
    for file in OUTPUTS {
        folder.write(&format!("{out}/{file}"), "poison");
    }
    folder.succeed(&format!("relight {options} --solver cpu --quiet --out {out}"));
    for file in OUTPUTS {
        assert!(folder.read(&format!("{out}/{file}")).len() > 100, "{file} is as it was");
    }
    let result = folder.read_json(&format!("{out}/result.json"));
    assert_eq!(result["method"], "signed");
    assert_eq!(result["negative_texels"], 0);
    assert!(result["energy"]["imbalance"].as_f64().unwrap() < 1e-4);
    let lit = options.contains("--object");
    assert_eq!(result["object_shots"].as_u64() > Some(0), lit, "{options}");
    // Without an object the background is unchanged bit for bit.
    let [composite, background] = ["composite", "background"].map(|name| folder.read(&format!("{out}/{name}.exr")));
    assert_eq!(composite == background, !lit, "{options}");
    result
}

#[test]
fn relight_accepts_scenes_results_and_maps() {
    let folder = folder_with_room();
    // Given patches and samples make all three rooms shoot alike.
    let links = "--texels 4 --patches 4 --samples 4";
    folder.succeed(&format!("shoot room.obj --maps --solver cpu {links} --out solved"));
    let objects = "--object cube.obj --place 0.5,0.4,0.5 --object cube.obj --scale 0.5 --place 0.2,0.2,0.2";
    for (room, out) in [("room.obj", "scene"), ("solved", "result"), ("solved/maps", "maps")] {
        let options = format!("--room {room} {objects} --reflectance 0,0,0 {links}");
        let result = relight(&folder, &options, out);
        assert!(result["map_shots"].as_u64().unwrap() > 0);
        assert_eq!(result["faces"].as_array().unwrap().len(), 18);
        assert_eq!(result["faces"][12]["reflectance"], json!([0.0, 0.0, 0.0]));
    }
    // The same room in three forms: the files of a solve lose nothing, its maps only the unshot power.
    for (other, bound) in [("result", 1e-6), ("maps", 2e-3)] {
        folder.succeed(&format!("diff {other} scene --out diff"));
        let diff = folder.read_json("diff/diff.json");
        for channel in diff["relative_rms"].as_array().unwrap() {
            assert!(channel.as_f64().unwrap() <= bound, "{diff}");
        }
    }
}

/// Makes a lat-long map, bright above and dim below, as a Radiance picture of plain pixels: mantissa, exponent 128 + 1,
/// so that a channel is its byte / 128.
fn panorama() -> Vec<u8> {
    let (width, height) = (64, 32);
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    for row in 0..height {
        let pixel = if row < 6 {
            [255, 240, 220, 131]
        } else {
            [64, 60, 56, 128]
        };
        bytes.extend(pixel.repeat(width));
    }
    bytes
}

#[test]
fn panorama_lights_object_and_receives_its_shadow() {
    let folder = folder_with_room();
    folder.write("room.hdr", panorama());
    let room = "--room room.hdr --room-size 4,3,4 --texels 4";
    // The object half a metre above the floor shadows it and receives the lamp's light.
    let object = format!("{room} --object cube.obj --scale 4 --place 0,0.9,0");
    let result = relight(&folder, &object, "object");
    // Without the encoded pictures, which may contain any text.
    let page = folder.read_text("object/report.html");
    let pictures = page.split("base64,").enumerate();
    let text = pictures.map(|(k, part)| &part[if k == 0 { 0 } else { part.find('"').unwrap() }..]);
    let text: String = text.collect();
    assert!(text.contains("room.hdr") && text.contains("cube.obj"), "{text}");
    assert!(!text.contains("http:") && !text.contains("https:") && !text.contains("NaN"));
    assert_eq!(result["faces"].as_array().unwrap().len(), 12);
    assert!(result["map_shots"].as_u64().unwrap() > 0);
    relight(&folder, room, "empty");
    let [with, without] = ["object", "empty"].map(|out| floor_radiosity(&folder, out));
    assert!(
        with > 0.0 && with < 0.99 * without,
        "{with} with the object, {without} without"
    );
}

/// Returns the red radiosity of the room's floor, summed over its texels.
fn floor_radiosity(folder: &TestFolder, out: &str) -> f64 {
    let result = folder.read_json(&format!("{out}/result.json"));
    let lies = |face: &&Value| {
        let corners = face["corners"].as_array().unwrap();
        corners.iter().all(|corner| corner[1] == 0.0)
    };
    let faces = result["faces"].as_array().unwrap();
    let rect = &faces.iter().find(lies).unwrap()["rect"];
    let [x, y, w, h] = [0, 1, 2, 3].map(|k| rect[k].as_u64().unwrap() as usize);
    let planes = folder.read_planes(&format!("{out}/lightmap.exr"));
    let row = |y: usize| &planes.channels["R"][y * planes.width + x..][..w];
    (y..y + h).flat_map(row).map(|b| f64::from(*b)).sum()
}

#[test]
fn relight_to_error_has_requested_and_estimated_error() {
    let folder = folder_with_room();
    let asked = "--room room.obj --object cube.obj --place 0.5,0.4,0.5 --error 2% --texels 8";
    let result = relight(&folder, asked, "out");
    assert_eq!(result["settings"]["error"], 0.02);
    let error = result["estimated_error"].as_f64().unwrap();
    assert!(error > 0.0 && error <= 0.02, "{error}");
}
