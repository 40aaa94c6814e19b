//! No input ends in a panic, a hang, an abort or a lost result: each row of these tables is one
//! call of the program in a folder of hostile files, its exit code, and what it has to say.

use super::kit::{Row, errors, folder, in_shell, judge, row, run, told, well_behaved};
use common::solution::pixels::Planes;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, Vec2,
    WritableImage,
};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::Command;

/// A closed room of one quad a wall; the ceiling is a lamp.
const ROOM: &str = "mtllib m.mtl
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
usemtl wall\nf 1 2 3 4\nf 6 5 8 7\nf 5 1 4 8\nf 2 6 7 3\nf 5 6 2 1\nusemtl lamp\nf 4 3 7 8
";
const MATERIALS: &str = "newmtl wall\nKd .6 .5 .4\nnewmtl lamp\nKd .5 .5 .5\nKe 1 1 1\n";

/// A folder with a healthy room in it, `room.obj`.
fn with_room(name: &str) -> std::path::PathBuf {
    let folder = folder(name);
    put(&folder, "room.obj", ROOM);
    put(&folder, "m.mtl", MATERIALS);
    folder
}

fn put(folder: &Path, name: &str, text: impl AsRef<[u8]>) {
    fs::write(folder.join(name), text).unwrap();
}

/// A pipe that nobody writes into.
fn pipe(folder: &Path, name: &str) {
    let made = Command::new("mkfifo").arg(folder.join(name)).status();
    assert!(made.unwrap().success(), "mkfifo {name}");
}

/// A triangle with this texture; its material goes into `t.mtl`.
fn textured(picture: &str, folder: &Path) -> &'static str {
    put(
        folder,
        "t.mtl",
        format!("newmtl m\nKe 1\nmap_Kd {picture}\n"),
    );
    "mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n"
}

/// Files that never end, or never begin.
const ENDLESS: &[Row] = &[
    row("solve pipe.obj --out out", 2, "pipe.obj: cannot be read"),
    row("solve zero.obj --out out", 2, "zero.obj: cannot be read"),
    row("solve huge.obj --out out", 2, "huge.obj: cannot be read"),
    row("solve library.obj --out out", 2, "pipe.obj cannot be read"),
    row("solve buffer.gltf --out out", 2, "pipe.obj cannot be read"),
    row(
        "solve texture.obj --out out",
        2,
        "t.mtl: material m: map_Kd pipe.obj cannot be read",
    ),
    row("plan pipe.obj", 2, "pipe.obj: cannot be read"),
    row(
        "relight --room pipe.obj --out out",
        2,
        "pipe.obj: cannot be read",
    ),
    row(
        "relight --room zero.obj --room-size 1,1,1 --out out",
        2,
        "zero.obj: cannot be read",
    ),
    row(
        "relight --room room.obj --object pipe.obj --out out",
        2,
        "pipe.obj: cannot be read",
    ),
    row(
        "relight --room piped --out out",
        2,
        "piped/result.json: cannot be read",
    ),
    row(
        "relight --room endless --out out",
        2,
        "endless/result.json: cannot be read",
    ),
    row(
        "relight --room walls --out out",
        2,
        "walls/000.exr: cannot be read",
    ),
    row(
        "diff dark endless --out out",
        2,
        "dark/lightmap.exr: cannot be read",
    ),
    row(
        "chart room.obj --solver cpu --peers pipe.obj --out out",
        2,
        "pipe.obj: cannot be read",
    ),
    row(
        "chart room.obj --solver cpu --truth piped --out out",
        2,
        "piped/result.json: cannot be read",
    ),
    row(
        "converge room.obj --truth piped --out out",
        2,
        "piped/result.json: cannot be read",
    ),
    row(
        "table4 --composite pipe.obj --out out",
        2,
        "pipe.obj: cannot be read",
    ),
    row(
        "merge pipe.obj zero.obj --seconds 1,4 --out out",
        2,
        "pipe.obj: cannot be read",
    ),
    row(
        "merge --exposures pipe.obj --out out",
        2,
        "pipe.obj: cannot be read",
    ),
    row(
        "merge --exposures zero.obj --out out",
        2,
        "zero.obj: cannot be read",
    ),
];

/// `dir`/result.json of one black quad of one texel.
fn one_quad(folder: &Path, dir: &str) {
    fs::create_dir_all(folder.join(dir)).unwrap();
    let quad = "[[0,0,0],[1,0,0],[1,1,0],[0,1,0]]";
    let text = format!(
        "{{\"faces\":[{{\"kind\":\"quad\",\"corners\":{quad},\"texels\":[1,1],\"rect\":[0,0,1,1],\"file\":\"000.exr\"}}]}}"
    );
    put(folder, &format!("{dir}/result.json"), text);
}

#[test]
fn what_never_ends_is_refused() {
    let folder = with_room("endless");
    pipe(&folder, "pipe.obj");
    let link = |from: &str, to: &str| std::os::unix::fs::symlink(from, folder.join(to)).unwrap();
    link("/dev/zero", "zero.obj");
    let huge = fs::File::create(folder.join("huge.obj")).unwrap();
    huge.set_len(1 << 42).unwrap();
    put(&folder, "library.obj", "mtllib pipe.obj\n");
    put(&folder, "texture.obj", textured("pipe.obj", &folder));
    let buffer = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"pipe.obj","byteLength":4}]}"#;
    put(&folder, "buffer.gltf", buffer);
    for dir in ["piped", "endless", "walls"] {
        fs::create_dir(folder.join(dir)).unwrap();
    }
    pipe(&folder, "piped/result.json");
    link("/dev/zero", "endless/result.json");
    one_quad(&folder, "dark");
    pipe(&folder, "dark/lightmap.exr");
    one_quad(&folder, "walls");
    fs::rename(
        folder.join("walls/result.json"),
        folder.join("walls/room.json"),
    )
    .unwrap();
    pipe(&folder, "walls/000.exr");
    judge(&folder, ENDLESS);
    fs::remove_dir_all(folder).unwrap();
}

/// Solves `room.obj` into `dir`, with `more` options.
fn solved(folder: &Path, dir: &str, more: &[&str]) {
    let solve = ["solve", "room.obj", "--solver", "cpu", "--texels", "4"];
    let ended = run(
        folder,
        &[&solve[..], &["--quiet", "--out", dir], more].concat(),
    );
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
}

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

/// Scripts around the program, its arguments, its exit code, error lines that are seen, and
/// whether there is a result.
const PIPES: &[(&str, &str, i32, usize, bool)] = &[
    (
        "\"$0\" \"$@\" | true; exit ${PIPESTATUS[0]}",
        "plan room.obj --solver cpu",
        0,
        0,
        false,
    ),
    (
        "\"$0\" \"$@\" | true; exit ${PIPESTATUS[0]}",
        "adapters",
        0,
        0,
        false,
    ),
    (
        "\"$0\" \"$@\" | true; exit ${PIPESTATUS[0]}",
        "--help",
        0,
        0,
        false,
    ),
    (
        "\"$0\" \"$@\" 2>&1 | true; exit ${PIPESTATUS[0]}",
        "solve room.obj --solver cpu --texels 4",
        0,
        0,
        true,
    ),
    (
        "\"$0\" \"$@\" >/dev/full",
        "plan room.obj --solver cpu",
        4,
        1,
        false,
    ),
    ("\"$0\" \"$@\" >/dev/full", "adapters", 4, 1, false),
    ("\"$0\" \"$@\" >/dev/full", "--help", 4, 1, false),
    ("\"$0\" \"$@\" >/dev/full", "--version", 4, 1, false),
    (
        "\"$0\" \"$@\" >/dev/full",
        "solve room.obj --solver cpu --texels 4",
        0,
        0,
        true,
    ),
    (
        "\"$0\" \"$@\" 2>/dev/full",
        "solve room.obj --solver cpu --texels 4",
        0,
        0,
        true,
    ),
    ("\"$0\" \"$@\" 2>/dev/full", "solve none.obj", 2, 0, false),
    ("\"$0\" \"$@\" 2>/dev/full", "solve", 2, 0, false),
    (
        "\"$0\" \"$@\" >&- 2>&-",
        "solve room.obj --solver cpu --texels 4",
        0,
        0,
        true,
    ),
    (
        "\"$0\" \"$@\" >&-",
        "plan room.obj --solver cpu",
        0,
        0,
        false,
    ),
];

#[test]
fn no_pipe_ends_a_solve() {
    let folder = with_room("pipes");
    for (script, arguments, code, lines, result) in PIPES {
        let _ = fs::remove_dir_all(folder.join("out"));
        let words: Vec<&str> = arguments.split_whitespace().collect();
        let ended = in_shell(&folder, script, &words);
        let what = format!("{script}: {}", told(arguments, &ended));
        println!("{what}");
        assert_eq!(ended.code, Some(*code), "{what}");
        assert_eq!(errors(&ended).len(), *lines, "{what}");
        well_behaved(&folder, &ended, &what);
        assert_eq!(folder.join("out/result.json").exists(), *result, "{what}");
    }
    fs::remove_dir_all(folder).unwrap();
}

/// Options that do not go together, and values that are none.
const OPTIONS: &[Row] = &[
    row(
        "solve room.obj --texels 2 --adapter NOSUCH --out out",
        3,
        "no adapter is called \"NOSUCH\"",
    ),
    row(
        "plan room.obj --adapter NOSUCH",
        3,
        "no adapter is called \"NOSUCH\"",
    ),
    row(
        "solve room.obj --solver cpu --adapter any --out out",
        2,
        "--adapter contradicts",
    ),
    row(
        "plan room.obj --solver cpu --adapter any",
        2,
        "--adapter contradicts",
    ),
    row(
        "chart room.obj --solver cpu --adapter any --out out",
        2,
        "--adapter contradicts",
    ),
    row(
        "solve room.obj --solver cpu --item-buffer 512 --out out",
        2,
        "--item-buffer applies to item buffers",
    ),
    row(
        "solve room.obj --solver cpu --raster pixel --out out",
        2,
        "--raster applies to item buffers",
    ),
    row(
        "solve room.obj --solver cpu --lookup 3x3 --out out",
        2,
        "--lookup applies to item buffers",
    ),
    row(
        "solve room.obj --solver gpu --visibility rays --lookup exact --out out",
        2,
        "--lookup",
    ),
    row(
        "solve room.obj --solver gpu --visibility rays --item-buffer 64 --out out",
        2,
        "--item-buffer",
    ),
    row(
        "compare room.obj --visibility rays --item-buffer 64 --out out",
        2,
        "--item-buffer applies to item buffers",
    ),
    row(
        "relight --room room.obj --solver cpu --item-buffer 512 --out out",
        2,
        "--item-buffer",
    ),
    row(
        "plan room.obj --solver cpu --raster tessellated",
        2,
        "--raster applies to item buffers",
    ),
    row(
        "compare room.obj --visibility rays --lookup exact --out out",
        2,
        "--lookup",
    ),
    row(
        "solve room.obj --solver cpu --texels 2 --visibility hemicube --item-buffer 64 --lookup exact --out out",
        0,
        "wrote",
    ),
    row(
        "solve room.obj --texels -1 --out out",
        2,
        "-1 is not in 1..=8192 (see",
    ),
    row(
        "solve room.obj --epsilon -1 --out out",
        2,
        "-1 is not in 0 < X ≤ 1 (see",
    ),
    row(
        "solve room.obj --max-shots -1 --out out",
        2,
        "-1 is not in 0..=4294967295 (see",
    ),
    row(
        "solve room.obj -x --out out",
        2,
        "unexpected argument '-x' found (see",
    ),
    row(
        "solve room.obj --reflectance .5,.5 --out out",
        2,
        "give 3 numbers separated by commas",
    ),
    row(
        "solve room.obj --reflectance 1,1,1 --out out",
        2,
        "1,1,1 is not in 0 ≤ ρ < 1 (see",
    ),
    row(
        "check out --reflectance .5,.5,.5 --out out",
        2,
        "--reflectance applies to --scene SCENE",
    ),
    row(
        "solve no\u{1b}[2Jroom.obj --out out",
        2,
        "no\\u{1b}[2Jroom.obj: cannot be read",
    ),
    row(
        "solve room.obj --bad\u{1b}[31m --out out",
        2,
        "unexpected argument",
    ),
];

#[test]
fn no_option_is_ignored() {
    let folder = with_room("options");
    judge(&folder, OPTIONS);
    fs::remove_dir_all(folder).unwrap();
}

/// Files that are not what they seem.
const DAMAGED: &[Row] = &[
    row(
        "merge cut.jpg long.jpg --seconds 1,4 --out out",
        2,
        "cut.jpg: is cut off",
    ),
    row(
        "merge almost.jpg long.jpg --seconds 1,4 --out out",
        2,
        "almost.jpg: is cut off",
    ),
    row(
        "solve v1.gltf --out out",
        2,
        "v1.gltf: is glTF version 1.0: export it as version 2",
    ),
    row(
        "solve v3.gltf --out out",
        2,
        "v3.gltf: is glTF version 3.0: export it as version 2",
    ),
    row(
        "merge short.jpg long.jpg --seconds 1,4 --out out",
        0,
        "2 exposures",
    ),
    row(
        "solve fine.gltf --allow-dark --solver cpu --texels 2 --out out",
        0,
        "1 faces",
    ),
    row(
        "solve texture.obj --out out",
        2,
        "t.mtl: material m: map_Kd cut.jpg is cut off",
    ),
    row(
        "solve index.gltf --out out",
        2,
        "index.gltf: has the index 4294967296 in `mesh`",
    ),
];

/// A glTF of one triangle, its node's mesh being number `mesh`.
fn triangle(version: &str, mesh: u64) -> String {
    use base64::{Engine, engine::general_purpose::STANDARD};
    let corners = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let bytes: Vec<u8> = corners
        .as_flattened()
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let uri = format!(
        "data:application/octet-stream;base64,{}",
        STANDARD.encode(&bytes)
    );
    json!({
        "asset": {"version": version},
        "nodes": [{"mesh": mesh}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": uri}],
    })
    .to_string()
}

#[test]
fn damaged_files_are_not_guessed_at() {
    let folder = folder("damaged");
    // Codes of a smooth scene, gamma 2, and of four times the time.
    for (name, brightness) in [("short.jpg", 1), ("long.jpg", 2)] {
        let code = |x: u32| (brightness * x).min(255) as u8;
        let image = image::RgbImage::from_fn(120, 90, |x, _| image::Rgb([code(x + 10); 3]));
        image.save(folder.join(name)).unwrap();
    }
    let bytes = fs::read(folder.join("short.jpg")).unwrap();
    put(&folder, "cut.jpg", &bytes[..bytes.len() * 4 / 5]);
    put(&folder, "almost.jpg", &bytes[..bytes.len() - 1]);
    put(&folder, "v1.gltf", triangle("1.0", 0));
    put(&folder, "v3.gltf", triangle("3.0", 0));
    put(&folder, "index.gltf", triangle("2.0", 1 << 32));
    put(&folder, "texture.obj", textured("cut.jpg", &folder));
    put(&folder, "fine.gltf", triangle("2.0", 0));
    judge(&folder, DAMAGED);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn names_do_not_reach_the_terminal_as_commands() {
    let folder = with_room("names");
    let room = ROOM.replace("usemtl lamp", "g lamp\u{1b}[2J\u{7}\nusemtl lamp\u{1b}]0;x");
    put(&folder, "\u{1b}[31mred.obj", room);
    put(
        &folder,
        "m.mtl",
        MATERIALS.replace("newmtl lamp", "newmtl lamp\u{1b}]0;x"),
    );
    let solve = [
        "solve",
        "\u{1b}[31mred.obj",
        "--solver",
        "cpu",
        "--cells",
        "1",
        "--texels",
        "2",
    ];
    let ended = run(&folder, &solve);
    let what = told("names with escapes", &ended);
    println!("{what}");
    assert_eq!(ended.code, Some(0), "{what}");
    well_behaved(&folder, &ended, &what);
    let text = fs::read_to_string(folder.join("out/result.json")).unwrap();
    let result: Value = serde_json::from_str(&text).unwrap();
    for name in [&result["scene"], &result["faces"][5]["name"]] {
        let name = name.as_str().unwrap();
        assert!(
            name.contains("\\u{1b}[") && !name.contains('\u{1b}'),
            "{name:?}"
        );
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn quiet_is_quiet() {
    let folder = with_room("quiet");
    // Notes of the import, of the adapter and of mending.
    let odd = format!("{ROOM}f 1 1 2\nf 1 2 2\nl 1 2\n");
    put(&folder, "odd.obj", odd);
    for (arguments, code) in [
        ("solve odd.obj --solver cpu --texels 2", 0),
        ("solve odd.obj --adapter NOSUCH --texels 2", 3),
    ] {
        let words: Vec<&str> = arguments.split_whitespace().collect();
        let ended = run(&folder, &words);
        assert!(
            ended.stderr.contains("note:"),
            "{}",
            told(arguments, &ended)
        );
        let ended = run(&folder, &[&words[..], &["--quiet"]].concat());
        let what = told(arguments, &ended);
        println!("{what}");
        assert_eq!(ended.code, Some(code), "{what}");
        let lines = ended.stdout.lines().chain(ended.stderr.lines());
        let rest = lines.filter(|line| !line.starts_with("error:"));
        assert_eq!(rest.collect::<Vec<_>>(), [""; 0], "{what}");
    }
    fs::remove_dir_all(folder).unwrap();
}
