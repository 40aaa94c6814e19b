//! The program without arguments, outside the repository.

use super::command::empty_folder;
use std::fs;
use std::process::Command;

#[test]
fn demo_runs_outside_the_repository() {
    let folder = empty_folder("demo");
    // Without a driver the demo only solves on the CPU, which takes a second.
    let output = Command::new(env!("CARGO_BIN_EXE_radiosity"))
        .current_dir(&folder)
        .env("VK_DRIVER_FILES", "none")
        .env("VK_ICD_FILENAMES", "none")
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(3), "{said}");
    let result = fs::read_to_string(folder.join("out/cornell_box/result.json")).unwrap();
    let result: serde_json::Value = serde_json::from_str(&result).unwrap();
    assert_eq!(result["scene"], "out/scenes/cornell_box.obj");
    assert_eq!(result["converged"], true);
    for name in ["cornell_box.obj", "cornell_box.mtl"] {
        let ours = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/").to_owned() + name;
        let written = fs::read(folder.join("out/scenes").join(name)).unwrap();
        assert!(written == fs::read(ours).unwrap(), "{name}");
    }
    fs::remove_dir_all(folder).unwrap();
}
