//! Results on disk: values out of range, files of two solves, interrupted and concurrent writes.

use crate::program::bake::{FLOOR, write_gltf};
use crate::program::command::TestFolder;
use crate::program::diff::rewrite_lightmap;
use crate::program::merge::expose_scene;
use crate::program::room::folder_with_room;
use image::ImageFormat;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::PathBuf;

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
relight --room rho5 => rho5/result.json: face 2: its reflectance
relight --room dark --solver cpu => dark/result.json: face 1: its emission
relight --room inf --solver cpu => inf/result.json: does not describe a solve: number out of range at line 1
check dark => dark/result.json: face 1: its emission
check e38 => e38/result.json: face 1: its emission
check 3e38 => 3e38/result.json: face 1: its emission
relight --room 3e38 => 3e38/result.json: face 1: its emission
relight --room walls-e38 => walls-e38/room.json: face 1: its emission
check far => far/result.json: its light is lost in rounding
diff far solved => far/result.json: its light is lost in rounding
relight --room walls-far => walls-far/room.json: its light is lost in rounding
check vast => vast/result.json: extends over 1e99
check bent => bent/result.json: face 0: its corners are not those of a planar, convex quad
relight --room dart => dart/result.json: face 0: its corners are not those of a planar, convex quad
relight --room walls-bent => walls-bent/room.json: face 0: its corners are not
check rho5 => rho5/result.json: face 2: its reflectance
relight --room walls-rho5 => walls-rho5/room.json: face 2: its reflectance
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
        ("dark", light, json!([0.0, -5.0, 0.0])),
        ("inf", light, json!([0.0, 1e39, 0.0])),
        ("e38", light, json!([1e38, 1e38, 1e38])),
        ("3e38", light, json!([3e38, 3e38, 3e38])),
        ("far", "/faces/0/corners/0/0", json!(-1e39)),
        ("vast", "/faces/0/corners/0/0", json!(-1e99)),
        ("bent", "/faces/0/corners/2/2", json!(0.7)),
        ("dart", "/faces/0/corners/2", json!([0.2, 0.2, 0.0])),
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

/// Outputs that are an input, by name, by a link or by a way around, or another output.
const OVERWRITING: &str = "
solve room.glb --gltf room.glb => room.glb: would replace the input room.glb
solve room.glb --gltf none/../room.glb => none/../room.glb: would replace the input room.glb
solve link.glb --gltf ./room.glb => ./room.glb: would replace the input link.glb
shoot room.obj --out new --gltf ./new/lightmap.glb => new/lightmap.exr: is also where new/lightmap.exr would be written
solve result.json --out . => ./result.json: would replace the input result.json
solve maps/room.json --maps --out . => ./maps/room.json: would replace the input maps/room.json
solve library.obj --out . => ./view.html: would replace the input view.html
solve texture.obj --out . => ./preview.png: would replace the input preview.png
relight --room solved --out solved => solved/lightmap.exr: would replace the input solved/lightmap.exr
relight --room linked --out solved => solved/lightmap.exr: would replace the input linked/lightmap.exr
relight --room out => out/lightmap.exr: would replace the input out/lightmap.exr
merge preview.png radiance.exr --seconds 1,4 --out . => ./radiance.exr: would replace the input radiance.exr
check solved check.json --out . => ./check.json: would replace the input check.json
chart chart.json --out . => ./chart.json: would replace the input chart.json
compare report.json --out . => ./report.json: would replace the input report.json
";

#[test]
fn output_that_would_replace_an_input_is_refused() {
    let folder = folder_with_room();
    write_gltf(&folder, "room.glb", &FLOOR, false);
    let gltf = folder.read_text("room.glb");
    for name in ["result.json", "check.json", "chart.json", "report.json"] {
        folder.write(name, &gltf);
    }
    folder.write("maps/room.json", gltf);
    folder.write("maps/room.glb.bin", folder.read("room.glb.bin"));
    folder.write("view.html", "newmtl lamp\nKe 1 1 1\n");
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl lamp\nf 1/1 2/1 3/1\n";
    folder.write("library.obj", format!("mtllib view.html\n{triangle}"));
    folder.write("t.mtl", "newmtl lamp\nKe 1 1 1\nKd .5 .5 .5\nmap_Kd preview.png\n");
    folder.write("texture.obj", format!("mtllib t.mtl\n{triangle}"));
    folder.succeed("solve room.obj --solver cpu --texels 4 --out solved");
    folder.succeed("solve room.obj --solver cpu --texels 4");
    for (name, seconds) in [("preview.png", 1.0), ("radiance.exr", 4.0)] {
        let picture = expose_scene([48, 32], seconds);
        picture.save_with_format(folder.path(name), ImageFormat::Png).unwrap();
    }
    symlink("room.glb", folder.path("link.glb")).unwrap();
    symlink("solved", folder.path("linked")).unwrap();
    folder.assert_refused(OVERWRITING);
}

/// Returns the content of all files by path.
fn read_all(folder: &TestFolder) -> BTreeMap<PathBuf, Vec<u8>> {
    let files = folder.list_files().into_iter().filter(|path| path.is_file());
    files.map(|path| (path.clone(), fs::read(path).unwrap())).collect()
}

#[test]
fn failed_write_keeps_old_result() {
    let folder = folder_with_room();
    let solve = "solve room.obj --solver cpu --texels 4 --maps --gltf out/baked.glb";
    folder.succeed(solve);
    folder.write("out/note.txt", "mine");
    let before = read_all(&folder);
    let blocks = before.values().map(|bytes| bytes.len() / 1024);
    // Limits in blocks of 1024 bytes, at which one of the files is the first that does not fit.
    let blocks: BTreeSet<usize> = blocks.filter(|blocks| *blocks < 300).collect();
    assert!(blocks.len() > 4, "{blocks:?}");
    for blocks in blocks {
        let script = format!("ulimit -f {blocks}; exec RUN");
        let end = folder.run_in_shell(&script, &format!("{solve} --error 5% --quiet"));
        assert_eq!(end.code, Some(4), "{end}");
        assert!(matches!(end.errors()[..], [line] if line.contains("out/")), "{end}");
        assert!(read_all(&folder) == before, "{end}: the old result is not as it was");
    }
}

/// Where the end comes depends on the machine; what is left is a result wherever it comes, and the next write leaves nothing
/// unfinished.
#[test]
fn killed_solve_leaves_a_whole_result() {
    let folder = folder_with_room();
    folder.succeed("shoot room.obj --solver cpu --texels 4");
    folder.succeed("diff out out");
    let before: Vec<_> = read_all(&folder).into_keys().collect();
    for wait in (0..40).step_by(2) {
        let script = format!(
            "RUN --epsilon 0.{} & sleep 0.{wait:02}; kill -9 $!; wait $!; \
             \"$0\" diff out out --out diff && rm -r diff && \"$0\" diff out out",
            1 + wait % 9
        );
        let end = folder.run_in_shell(&script, "shoot room.obj --solver cpu --texels 4 --quiet");
        assert_eq!(end.code, Some(0), "{end}");
        let after: Vec<_> = read_all(&folder).into_keys().collect();
        assert_eq!(after, before);
    }
}

#[test]
fn next_solve_removes_the_files_of_the_one_before_and_no_others() {
    let folder = folder_with_room();
    folder.succeed("solve room.obj --solver cpu --texels 4 --maps");
    folder.write("out/note.txt", "mine");
    folder.write("out/drafts/note.txt", "mine");
    let objects = "--object cube.obj --place .5,.4,.5 --solver cpu";
    folder.succeed(&format!("relight --room out/maps {objects}"));
    assert!(folder.has("out/maps/room.json"), "the input of the new result");
    folder.succeed("solve room.obj --solver cpu --texels 4 --maps");
    folder.succeed("relight --room room.obj --object cube.obj --place .5,.4,.5 --solver cpu --texels 4");
    assert!(folder.has("out/composite.exr") && !folder.has("out/maps"));
    folder.succeed("solve room.obj --solver dense --texels 4");
    let names = [
        "drafts",
        "lightmap.exr",
        "note.txt",
        "preview.png",
        "result.json",
        "view.html",
    ];
    let mut left: Vec<_> = fs::read_dir(folder.path("out"))
        .unwrap()
        .flatten()
        .map(|entry| entry.file_name())
        .collect();
    left.sort();
    assert_eq!(left, names);
    assert!(folder.has("out/drafts/note.txt"));
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
