//! Results on disk: values out of range, files of two solves, interrupted and concurrent writes.

use super::kit::{Row, assert_clean_end, assert_rows, describe_end, error_lines, row, run_in_shell, run_program};
use super::room::{folder_with_room, solve_into};
use common::solution::pixels::ImagePlanes;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, Vec2, WritableImage,
};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// Copies `from` to `to` with the entry at `pointer` of its description replaced.
fn copy_with_entry(folder: &Path, from: &str, to: &str, name: &str, pointer: &str, value: Value) {
    fs::create_dir_all(folder.join(to)).unwrap();
    for file in fs::read_dir(folder.join(from)).unwrap().flatten() {
        if file.path().is_file() {
            fs::copy(file.path(), folder.join(to).join(file.file_name())).unwrap();
        }
    }
    let path = folder.join(to).join(name);
    let mut description: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    *description.pointer_mut(pointer).unwrap() = value;
    fs::write(path, description.to_string()).unwrap();
}

/// Rooms with a reflectance of 1 or more, or with negative or infinite emission.
const BEYOND: &[Row] = &[
    row(
        "diff rho5 solved --out out",
        2,
        "rho5/result.json: face 2: its reflectance",
    ),
    row(
        "diff solved rho-1 --out out",
        2,
        "rho-1/result.json: face 2: its reflectance",
    ),
    row(
        "relight --room rho1 --out out",
        2,
        "rho1/result.json: face 2: its reflectance",
    ),
    row(
        "relight --room dark --solver cpu --out out",
        2,
        "dark/result.json: face 5: its emission",
    ),
    row(
        "relight --room inf --solver cpu --out out",
        2,
        "inf/result.json: does not describe a solve: number out of range at line 1",
    ),
    row(
        "converge room.obj --truth dark --out out",
        2,
        "dark/result.json: face 5: its emission",
    ),
    row(
        "chart room.obj --solver cpu --truth rho5 --out out",
        2,
        "rho5/result.json: face 2: its",
    ),
    row(
        "relight --room walls5 --out out",
        2,
        "walls5/room.json: face 2: its reflectance",
    ),
    row(
        "relight --room walls-1 --out out",
        2,
        "walls-1/room.json: face 2: its reflectance",
    ),
    row(
        "relight --room wallsdark --out out",
        2,
        "wallsdark/room.json: face 5: its emission",
    ),
    row(
        "relight --room wallsinf --out out",
        2,
        "wallsinf/room.json: does not describe a room: number out of range at line 1",
    ),
    row(
        "relight --room nan --solver cpu --out out",
        2,
        "nan/lightmap.exr: face 0: the channels R, G, B are not finite",
    ),
    row(
        "relight --room bright --solver cpu --out out",
        2,
        "bright/lightmap.exr: face 0",
    ),
    row(
        "relight --room white --solver cpu --out out",
        2,
        "white/lightmap.exr: face 0: the channels reflectance.R, G, B hold",
    ),
    row("diff bright solved --out out", 2, "bright/lightmap.exr: face 0"),
];

#[test]
fn stored_rooms_with_impossible_materials_are_refused() {
    let folder = folder_with_room("beyond");
    solve_into("solve", &folder, "solved", &["--maps"]);
    let grey = |rho: f64| json!([rho, 0.5, 0.5]);
    let (rho, light) = ("/faces/2/reflectance", "/faces/5/emission");
    for (name, pointer, value) in [
        ("5", rho, grey(5.0)),
        ("-1", rho, grey(-1.0)),
        ("1", rho, grey(1.0)),
        ("dark", light, json!([0.0, -5.0, 0.0])),
        ("inf", light, json!([0.0, 1e39, 0.0])),
    ] {
        let stored = if pointer == rho {
            format!("rho{name}")
        } else {
            name.into()
        };
        copy_with_entry(&folder, "solved", &stored, "result.json", pointer, value.clone());
        let walls = format!("walls{name}");
        copy_with_entry(&folder, "solved/maps", &walls, "room.json", pointer, value);
    }
    copy_with_channels(&folder, "solved", "bright", "", f32::MAX);
    copy_with_channels(&folder, "solved", "nan", "", f32::NAN);
    copy_with_channels(&folder, "solved", "white", "reflectance.", 1.0);
    assert_rows(&folder, BEYOND);
    fs::remove_dir_all(folder).unwrap();
}

const OF_TWO_SOLVES: &[Row] = &[
    row(
        "diff mixed fine --out out",
        2,
        "mixed/lightmap.exr: this and result.json are not of one solve",
    ),
    row("relight --room mixed --solver cpu --out out", 2, "are not of one solve"),
    row(
        "chart room.obj --solver cpu --truth mixed --out out",
        2,
        "are not of one solve",
    ),
];

/// Copies `from` to `to` with `value` in every pixel of R, G and B with this prefix.
fn copy_with_channels(folder: &Path, from: &str, to: &str, prefix: &str, value: f32) {
    let path = folder.join(from).join("lightmap.exr");
    let ImagePlanes {
        width,
        height,
        mut channels,
    } = ImagePlanes::read(&path, 1 << 20).unwrap();
    copy_with_entry(folder, from, to, "result.json", "/lightmap_crc32", Value::Null);
    for name in ["R", "G", "B"] {
        channels.insert(format!("{prefix}{name}"), vec![value; width * height]);
    }
    let plane = |(name, values): (String, _)| AnyChannel::new(name.as_str(), FlatSamples::F32(values));
    let layer = Layer::new(
        Vec2(width, height),
        LayerAttributes::default(),
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(channels.into_iter().map(plane).collect()),
    );
    let path = folder.join(to).join("lightmap.exr");
    Image::from_layer(layer).write().to_file(path).unwrap();
}

#[test]
fn files_of_two_solves_are_refused() {
    let folder = folder_with_room("two");
    solve_into("solve", &folder, "fine", &[]);
    solve_into(
        "shoot",
        &folder,
        "mixed",
        &["--epsilon", "0.5", "--iteration", "southwell"],
    );
    let of = |dir: &str| folder.join(dir).join("lightmap.exr");
    fs::copy(of("fine"), of("mixed")).unwrap();
    assert_rows(&folder, OF_TWO_SOLVES);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn failed_write_keeps_old_result() {
    let folder = folder_with_room("limit");
    solve_into("solve", &folder, "out", &[]);
    let files = ["lightmap.exr", "result.json"].map(|name| folder.join("out").join(name));
    let before = files.clone().map(|file| fs::read(file).unwrap());
    let [image, text] = before.each_ref().map(|bytes| bytes.len() / 1024);
    assert!(image + 1 < text, "the limit below must let the image through");
    let shoot = [
        "shoot",
        "room.obj",
        "--solver",
        "cpu",
        "--texels",
        "4",
        "--epsilon",
        "0.5",
    ];
    // Limits in blocks of 1024 bytes: no file fits, or only the lightmap.
    for blocks in [0, image + 1] {
        let script = format!("ulimit -f {blocks}; exec \"$0\" \"$@\"");
        let ended = run_in_shell(&folder, &script, &[&shoot[..], &["--quiet"]].concat());
        let what = describe_end("shoot under ulimit -f", &ended);
        println!("{what}");
        assert_eq!(ended.code, Some(4), "{what}");
        assert!(
            matches!(error_lines(&ended)[..], [line] if line.contains("out/")),
            "{what}"
        );
        assert_clean_end(&folder, &ended, &what);
        let after = files.clone().map(|file| fs::read(file).unwrap());
        assert!(after == before, "{what}: the old result is gone");
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn concurrent_solves_write_one_folder_without_partial_files() {
    let folder = folder_with_room("many");
    let script = "for k in 1 2 3 4 5 6 7 8; do \"$0\" \"$@\" --epsilon 0.$k & all=\"$all $!\"; done; \
        for one in $all; do wait $one || exit $?; done";
    let shoot = ["shoot", "room.obj", "--solver", "cpu", "--texels", "2", "--quiet"];
    let ended = run_in_shell(&folder, script, &shoot);
    let what = describe_end("eight solves at once", &ended);
    println!("{what}");
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""), "{what}");
    assert_clean_end(&folder, &ended, &what);
    // Both files are of one solve, or the result is refused.
    let ended = run_program(&folder, &["diff", "out", "out", "--out", "diff"]);
    let told = ended.code == Some(0) || ended.stderr.contains("are not of one solve");
    assert!(told, "{}", ended.stderr);
    fs::remove_dir_all(folder).unwrap();
}
