//! Light that is not in the scene's file: lamps, skies and suns as options, and objects and panoramas that turn.

use super::command::TestFolder;
use super::room::{Cube, MATERIALS, ROOM, folder_with_room};
use serde_json::Value;
use std::f64::consts::PI;

/// Makes a folder with a floor of side 2 and a room, both without a lamp.
fn dark_folder() -> TestFolder {
    let folder = TestFolder::new();
    let corners = "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\n";
    folder.write("m.mtl", MATERIALS);
    folder.write("floor.obj", format!("mtllib m.mtl\n{corners}usemtl wall\nf 1 2 3 4\n"));
    folder.write("dark.obj", Cube { lamp: "wall", ..ROOM }.obj_text());
    folder
}

fn emitted_power(result: &Value) -> Vec<f64> {
    let power = result["energy"]["emitted"].as_array().unwrap();
    power.iter().filter_map(Value::as_f64).collect()
}

/// Returns the relative error that `check` finds.
fn checked_error(folder: &TestFolder) -> f64 {
    folder.succeed("check out --out check");
    folder.read_json("check/check.json")["estimated_error"]
        .as_f64()
        .unwrap()
}

#[test]
fn lamps_light_a_dark_room_with_their_power() {
    let folder = dark_folder();
    folder.succeed("solve dark.obj --lamp 0.5,0.5,0.5,60 --lamp 0.5,1,0.5,20 --error 5% --texels 4 --solver cpu");
    let result = folder.read_json("out/result.json");
    assert!(
        emitted_power(&result)
            .iter()
            .all(|power| (power / 80.0 - 1.0).abs() < 1e-5),
        "{result}"
    );
    let faces = result["faces"].as_array().unwrap();
    let named = |name: &str| faces.iter().filter(|face| face["name"] == name).count();
    assert_eq!([faces.len(), named("lamp 1"), named("lamp 2")], [46, 20, 20]);
    let notes = result["notes"].to_string();
    assert!(
        notes.contains("lamp 2 is moved by") && !notes.contains("lamp 1 is moved"),
        "{notes}"
    );
    // The second lamp lights a spot of the ceiling far smaller than the texels, which `check` takes as they are.
    folder.succeed("solve dark.obj --lamp 0.5,0.5,0.5,60 --error 5% --texels 4 --solver cpu");
    assert!(checked_error(&folder) < 0.05);
}

#[test]
fn sky_and_sun_light_a_floor() {
    let folder = dark_folder();
    for (options, irradiance) in [("--sky 2", 2.0 * PI), ("--sun 0,1,1,100", 100.0 * 0.5_f64.sqrt())] {
        folder.succeed(&format!("solve floor.obj {options} --texels 4 --solver cpu"));
        let result = folder.read_json("out/result.json");
        let all = 4.0 * irradiance;
        assert!(
            emitted_power(&result)
                .iter()
                .all(|power| (power / all - 1.0).abs() < 1e-3),
            "{result}"
        );
        let planes = folder.read_planes("out/lightmap.exr");
        let expected = (0.6 * irradiance) as f32;
        assert!(planes.channels["R"].iter().all(|b| (b / expected - 1.0).abs() < 1e-3));
        assert_eq!(planes.channels["sky.R"], planes.channels["irradiance.R"]);
        assert!(checked_error(&folder) < 1e-3);
    }
    assert_eq!(
        folder.read_json("out/result.json")["settings"]["suns"][0]["irradiance"][0],
        100.0
    );
    // A closed room sees nothing of it.
    let end = folder.succeed("solve dark.obj --sky 2 --texels 2 --solver cpu");
    let told = ["none comes from outside", "--two-sided", "--lamp X,Y,Z,W"];
    assert!(told.iter().all(|part| end.stderr.contains(part)), "{end}");
    assert!(!end.stderr.contains("was requested"), "{end}");
}

#[test]
fn turned_objects_and_turned_panoramas_keep_their_light() {
    let folder = folder_with_room();
    let room = "--room room.obj --texels 2 --error 10% --solver cpu --object cube.obj";
    folder.succeed(&format!("relight {room} --turn 90 --place 0.5,0.4,0.5"));
    let result = folder.read_json("out/result.json");
    assert_eq!(result["objects"][0]["turn"], 90.0);
    // The first corner of the cube, −0.1 in all coordinates: (x, y, z) turns to (z, y, −x).
    let corner = result["faces"][6]["corners"].to_string();
    let corners = result["faces"][6]["corners"].as_array().unwrap();
    let has = |p: [f64; 3]| {
        corners.iter().any(|corner| {
            let near = |k: usize| (corner[k].as_f64().unwrap() - p[k]).abs() < 1e-6;
            (0..3).all(near)
        })
    };
    assert!(has([0.4, 0.3, 0.6]), "{corner}");
}
