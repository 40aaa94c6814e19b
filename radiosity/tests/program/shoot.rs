//! `shoot`, and `solve` with options of `shoot`, which works for one version.

use super::command::TestFolder;
use serde_json::{Value, json};

#[test]
fn solve_with_option_of_shooting_shoots_and_names_shoot() {
    let folder = TestFolder::new();
    let run = |command: &str, rest: &str| {
        let line = format!("{command} scenes/cornell_box.obj --solver cpu --texels 3 {rest}");
        let end = folder.succeed(&line);
        end.stderr.matches("is an option of `radiosity shoot` now").count()
    };
    assert_eq!(run("shoot", "--samples 1 --patches 2 --out new"), 0);
    assert_eq!(run("solve", "--samples 1 --cells 2 --out old"), 1);
    assert_eq!(folder.read("new/lightmap.exr"), folder.read("old/lightmap.exr"));
    let settings = folder.read_json("old/result.json")["settings"].clone();
    assert_eq!(settings, folder.read_json("new/result.json")["settings"]);
    assert_eq!((&settings["cells"], &settings["samples"]), (&json!(2), &json!(1)));
    // A solve to an error says nothing of shooting, and has another lightmap.
    assert_eq!(run("solve", "--error 10% --out old"), 0);
    assert_ne!(folder.read("new/lightmap.exr"), folder.read("old/lightmap.exr"));
}

#[test]
fn shoot_writes_files_of_contract_with_default_settings() {
    let folder = TestFolder::new();
    let end = folder.succeed("shoot scenes/cornell_box.obj --solver cpu --texels 4 --max-shots 7");
    let result = folder.read_json("out/result.json");
    let note = "1 face not planar: split into two triangles (6)";
    assert_eq!(end.stderr.matches(note).count(), 1, "{end}");
    assert!(result["notes"].to_string().contains(note), "{}", result["notes"]);
    for (pointer, value) in [
        ("/shots", json!(7)),
        ("/converged", json!(false)),
        ("/solver", json!("cpu")),
        ("/adapter", Value::Null),
        ("/settings/texels", json!(4)),
        ("/settings/cells", json!(4)),
        ("/settings/samples", json!(4)),
        ("/settings/iteration", json!("cg")),
        ("/settings/visibility", json!("rays")),
        ("/faces/0/kind", json!("quad")),
        ("/faces/0/texels", json!([4, 4])),
    ] {
        assert_eq!(result.pointer(pointer), Some(&value), "{pointer}");
    }
    assert!(result["settings"]["error"].is_null());
    assert!(result["energy"]["imbalance"].as_f64().unwrap() < 1e-5);
    let faces = result["faces"].as_array().unwrap();
    assert_eq!(faces[0]["corners"].as_array().unwrap().len(), 4);
    for key in ["name", "area", "rect", "emission", "reflectance"] {
        assert!(!faces[0][key].is_null(), "{key}");
    }
    assert!(
        faces.iter().any(|face| face["from"] == 5),
        "the non-planar left wall is split"
    );
    let files = ["", "lightmap.exr", "preview.png", "result.json", "view.html"];
    let files = files.map(|name| folder.path("out").join(name));
    assert_eq!(folder.list_files(), files.into_iter().collect());
    assert!(!folder.read_planes("out/lightmap.exr").channels.is_empty());
}
