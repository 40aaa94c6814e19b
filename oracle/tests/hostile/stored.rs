//! Results on disk: what they may hold, what belongs together, and that a solve replaces one whole or not at all.

use super::kit::{Row, errors, in_shell, judge, row, run, told, well_behaved};
use super::room::{solved, with_room};
use common::solution::pixels::Planes;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, Vec2,
    WritableImage,
};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// Copies `from` to `to` with the entry at `pointer` of its description replaced.
fn damaged(folder: &Path, from: &str, to: &str, name: &str, pointer: &str, value: Value) {
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

/// Rooms that reflect more than they receive, or shine darkness.
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
    row(
        "diff bright solved --out out",
        2,
        "bright/lightmap.exr: face 0",
    ),
];

#[test]
fn stored_rooms_are_held_to_what_a_material_may_be() {
    let folder = with_room("beyond");
    solved(&folder, "solved", &["--maps"]);
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
        damaged(
            &folder,
            "solved",
            &stored,
            "result.json",
            pointer,
            value.clone(),
        );
        let walls = format!("walls{name}");
        damaged(&folder, "solved/maps", &walls, "room.json", pointer, value);
    }
    painted(&folder, "solved", "bright", "", f32::MAX);
    painted(&folder, "solved", "nan", "", f32::NAN);
    painted(&folder, "solved", "white", "reflectance.", 1.0);
    judge(&folder, BEYOND);
    fs::remove_dir_all(folder).unwrap();
}

const OF_TWO_SOLVES: &[Row] = &[
    row(
        "diff mixed fine --out out",
        2,
        "mixed/lightmap.exr: this and result.json are not of one solve",
    ),
    row(
        "relight --room mixed --solver cpu --out out",
        2,
        "are not of one solve",
    ),
    row(
        "chart room.obj --solver cpu --truth mixed --out out",
        2,
        "are not of one solve",
    ),
];

/// Copies `from` to `to` with `value` in every pixel of R, G and B with this prefix.
fn painted(folder: &Path, from: &str, to: &str, prefix: &str, value: f32) {
    let path = folder.join(from).join("lightmap.exr");
    let Planes {
        width,
        height,
        mut channels,
    } = Planes::read(&path, 1 << 20).unwrap();
    damaged(
        folder,
        from,
        to,
        "result.json",
        "/lightmap_crc32",
        Value::Null,
    );
    for name in ["R", "G", "B"] {
        channels.insert(format!("{prefix}{name}"), vec![value; width * height]);
    }
    let plane =
        |(name, values): (String, _)| AnyChannel::new(name.as_str(), FlatSamples::F32(values));
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
fn files_of_two_solves_are_no_result() {
    let folder = with_room("two");
    solved(&folder, "fine", &[]);
    solved(
        &folder,
        "mixed",
        &["--epsilon", "0.5", "--iteration", "southwell"],
    );
    let of = |dir: &str| folder.join(dir).join("lightmap.exr");
    fs::copy(of("fine"), of("mixed")).unwrap();
    judge(&folder, OF_TWO_SOLVES);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn what_cannot_be_written_whole_leaves_the_old_result() {
    let folder = with_room("limit");
    solved(&folder, "out", &[]);
    let files = ["lightmap.exr", "result.json"].map(|name| folder.join("out").join(name));
    let before = files.clone().map(|file| fs::read(file).unwrap());
    let [image, text] = before.each_ref().map(|bytes| bytes.len() / 1024);
    assert!(
        image + 1 < text,
        "the limit below must let the image through"
    );
    let solve = [
        "solve",
        "room.obj",
        "--solver",
        "cpu",
        "--texels",
        "4",
        "--epsilon",
        "0.5",
    ];
    // Blocks of 1024 bytes: nothing at all, the image but not its description.
    for blocks in [0, image + 1] {
        let script = format!("ulimit -f {blocks}; exec \"$0\" \"$@\"");
        let ended = in_shell(&folder, &script, &[&solve[..], &["--quiet"]].concat());
        let what = told("solve under ulimit -f", &ended);
        println!("{what}");
        assert_eq!(ended.code, Some(4), "{what}");
        assert!(
            matches!(errors(&ended)[..], [line] if line.contains("out/")),
            "{what}"
        );
        well_behaved(&folder, &ended, &what);
        let after = files.clone().map(|file| fs::read(file).unwrap());
        assert!(after == before, "{what}: the old result is gone");
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn many_may_write_into_one_folder() {
    let folder = with_room("many");
    let script = "for k in 1 2 3 4 5 6 7 8; do \"$0\" \"$@\" --epsilon 0.$k & all=\"$all $!\"; done; \
        for one in $all; do wait $one || exit $?; done";
    let solve = [
        "solve", "room.obj", "--solver", "cpu", "--texels", "2", "--quiet",
    ];
    let ended = in_shell(&folder, script, &solve);
    let what = told("eight solves at once", &ended);
    println!("{what}");
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""), "{what}");
    well_behaved(&folder, &ended, &what);
    // One of them was the last to write both, or it is said.
    let ended = run(&folder, &["diff", "out", "out", "--out", "diff"]);
    let told = ended.code == Some(0) || ended.stderr.contains("are not of one solve");
    assert!(told, "{}", ended.stderr);
    fs::remove_dir_all(folder).unwrap();
}
