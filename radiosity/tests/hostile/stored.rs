//! Results on disk: values out of range, files of two solves, interrupted and concurrent writes.

use crate::program::command::TestFolder;
use crate::program::diff::rewrite_lightmap;
use crate::program::room::folder_with_room;
use serde_json::{Value, json};
use std::fs;

/// Copies the files of a result, with `value` at `pointer` of `description`.
fn copy_with_value(folder: &TestFolder, [from, to]: [&str; 2], description: &str, pointer: &str, value: &Value) {
    for file in fs::read_dir(folder.path(from)).unwrap().flatten() {
        if file.path().is_file() {
            let name = file.file_name().into_string().unwrap();
            folder.write(&format!("{to}/{name}"), folder.read(&format!("{from}/{name}")));
        }
    }
    let file = format!("{to}/{description}");
    folder.change_json(&file, |stored| *stored.pointer_mut(pointer).unwrap() = value.clone());
}

const BEYOND: &str = "
diff rho5 solved => rho5/result.json: face 2: its reflectance
diff solved rho-1 => rho-1/result.json: face 2: its reflectance
relight --room rho1 => rho1/result.json: face 2: its reflectance
relight --room dark --solver cpu => dark/result.json: face 1: its emission
relight --room inf --solver cpu => inf/result.json: does not describe a solve: number out of range at line 1
check dark => dark/result.json: face 1: its emission
check rho5 => rho5/result.json: face 2: its
check rho5 => rho5/result.json: face 2: its reflectance
relight --room walls-rho5 => walls-rho5/room.json: face 2: its reflectance
relight --room walls-rho-1 => walls-rho-1/room.json: face 2: its reflectance
relight --room walls-dark => walls-dark/room.json: face 1: its emission
relight --room walls-inf => walls-inf/room.json: does not describe a room: number out of range at line 1
relight --room nan --solver cpu => nan/lightmap.exr: face 0: the channels R, G, B are not finite
relight --room bright --solver cpu => bright/lightmap.exr: face 0
diff bright solved => bright/lightmap.exr: face 0
relight --room white --solver cpu => white/lightmap.exr: face 0: the channels reflectance.R, G, B hold
diff mixed solved => mixed/lightmap.exr: this and result.json are not of one solve
relight --room mixed --solver cpu => are not of one solve
check mixed => are not of one solve
";

#[test]
fn impossible_results_and_files_of_two_solves_are_refused() {
    let folder = folder_with_room();
    folder.succeed("solve room.obj --solver cpu --texels 4 --maps --out solved");
    let (rho, light) = ("/faces/2/reflectance", "/faces/1/emission");
    for (name, pointer, value) in [
        ("rho5", rho, json!([5.0, 0.5, 0.5])),
        ("rho-1", rho, json!([-1.0, 0.5, 0.5])),
        ("rho1", rho, json!([1.0, 0.5, 0.5])),
        ("dark", light, json!([0.0, -5.0, 0.0])),
        ("inf", light, json!([0.0, 1e39, 0.0])),
    ] {
        copy_with_value(&folder, ["solved", name], "result.json", pointer, &value);
        let walls = format!("walls-{name}");
        copy_with_value(&folder, ["solved/maps", &walls], "room.json", pointer, &value);
    }
    for (name, prefix, value) in [
        ("bright", "", f32::MAX),
        ("nan", "", f32::NAN),
        ("white", "reflectance.", 1.0),
    ] {
        copy_with_value(
            &folder,
            ["solved", name],
            "result.json",
            "/lightmap_crc32",
            &Value::Null,
        );
        rewrite_lightmap(&folder, name, |channels| {
            let count = channels["R"].len();
            channels.extend(["R", "G", "B"].map(|letter| (format!("{prefix}{letter}"), vec![value; count])));
        });
    }
    folder.succeed("shoot room.obj --solver cpu --texels 4 --epsilon 0.5 --iteration southwell --out mixed");
    folder.write("mixed/lightmap.exr", folder.read("solved/lightmap.exr"));
    folder.assert_refused(BEYOND);
}

#[test]
fn failed_write_keeps_old_result() {
    let folder = folder_with_room();
    folder.succeed("solve room.obj --solver cpu --texels 4");
    let read = || ["out/lightmap.exr", "out/result.json"].map(|name| folder.read(name));
    let before = read();
    let [image, text] = before.each_ref().map(|bytes| bytes.len() / 1024);
    assert!(image + 1 < text, "the limit below must let the image through");
    // Limits in blocks of 1024 bytes: no file fits, or only the lightmap.
    for blocks in [0, image + 1] {
        let script = format!("ulimit -f {blocks}; exec RUN");
        let end = folder.run_in_shell(&script, "shoot room.obj --solver cpu --texels 4 --epsilon 0.5 --quiet");
        assert_eq!(end.code, Some(4), "{end}");
        assert!(matches!(end.errors()[..], [line] if line.contains("out/")), "{end}");
        assert!(read() == before, "{end}: the old result is gone");
    }
}

#[test]
fn concurrent_solves_write_one_folder_without_partial_files() {
    let folder = folder_with_room();
    let script = "for k in 1 2 3 4 5 6 7 8; do RUN --epsilon 0.$k & all=\"$all $!\"; done; \
        for one in $all; do wait $one || exit $?; done";
    let end = folder.run_in_shell(script, "shoot room.obj --solver cpu --texels 2 --quiet");
    assert_eq!((end.code, end.stderr.as_str()), (Some(0), ""), "{end}");
    // Both files are of one solve, or the result is refused.
    let end = folder.run("diff out out --out diff");
    assert!(
        end.code == Some(0) || end.stderr.contains("are not of one solve"),
        "{end}"
    );
}
