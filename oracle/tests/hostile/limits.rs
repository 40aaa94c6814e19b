//! No input ends in NaN, a hang or an abort: numbers that f32 cannot hold, faces on faces, more faces
//! than there is time or memory for.

#![allow(
    clippy::disallowed_methods,
    reason = "reads what the program and the system wrote"
)]

use super::kit::{Row, errors, folder, in_shell, judge, row, run, told, well_behaved};
use common::sampling::hash;
use oracle::plan::Counts;
use oracle::plan::memory::Memory;
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

const MATERIALS: &str = "newmtl wall\nKd .5 .5 .5\nnewmtl lamp\nKd .5 .5 .5\nKe 1 1 1\n\
    newmtl sun\nKd .5 .5 .5\nKe 1e38 1e38 1e38\n";
/// The walls of a unit cube, their fronts inwards; the second is the ceiling.
const WALLS: [[u32; 4]; 6] = [
    [1, 2, 3, 4],
    [8, 7, 6, 5],
    [1, 5, 6, 2],
    [4, 3, 7, 8],
    [1, 4, 8, 5],
    [2, 6, 7, 3],
];

/// A way to write a room down.
#[derive(Clone, Copy)]
struct Room {
    side: f64,
    lamp: &'static str,
    /// How often it is listed, every second time in triangles if `mixed`.
    times: u32,
    mixed: bool,
    inside_out: bool,
}

const ROOM: Room = Room {
    side: 1.0,
    lamp: "lamp",
    times: 1,
    mixed: false,
    inside_out: false,
};

impl Room {
    fn obj(self) -> String {
        let mut text = "mtllib m.mtl\n".to_owned();
        for z in [0.0, self.side] {
            for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
                writeln!(text, "v {:e} {:e} {z:e}", x * self.side, y * self.side).unwrap();
            }
        }
        for time in 0..self.times {
            for (k, mut wall) in WALLS.into_iter().enumerate() {
                if self.inside_out {
                    wall.reverse();
                }
                let material = if k == 1 { self.lamp } else { "wall" };
                let [a, b, c, d] = wall;
                writeln!(text, "usemtl {material}").unwrap();
                if self.mixed && time % 2 == 1 {
                    writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").unwrap();
                } else {
                    writeln!(text, "f {a} {b} {c} {d}").unwrap();
                }
            }
        }
        text
    }
}

fn put(folder: &Path, name: &str, text: impl AsRef<[u8]>) {
    fs::write(folder.join(name), text).unwrap();
}

fn with_materials(name: &str) -> std::path::PathBuf {
    let folder = folder(name);
    put(&folder, "m.mtl", MATERIALS);
    put(&folder, "room.obj", ROOM.obj());
    folder
}

/// A number of 0…1.
fn unit(k: u32) -> f64 {
    f64::from(hash(k)) / 2f64.powi(32)
}

/// A room with so many small triangles anywhere in it.
fn soup(count: u32) -> String {
    let mut text = ROOM.obj() + "usemtl wall\n";
    for k in 0..count {
        let at = [0, 1, 2].map(|c| 0.03 + 0.9 * unit(12 * k + c));
        for corner in 1..4 {
            let p = [0, 1, 2].map(|c| at[c as usize] + 0.03 * unit(12 * k + 3 * corner + c));
            writeln!(text, "v {:.6} {:.6} {:.6}", p[0], p[1], p[2]).unwrap();
        }
        text += "f -3 -2 -1\n";
    }
    text
}

fn result(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("out/result.json")).unwrap()).unwrap()
}

const NUMBERS: &[Row] = &[
    row(
        "solve far.obj --solver cpu --out out",
        2,
        "far.obj: extends over 1e78",
    ),
    row(
        "solve near.obj --solver cpu --out out",
        2,
        "near.obj: extends over 1e-70",
    ),
    row(
        "solve bright.obj --solver cpu --out out",
        2,
        "m.mtl: material sun: emitted radiance Ke",
    ),
    row(
        "relight --room room.obj --object room.obj --scale 1e99 --solver cpu --out out",
        2,
        "room.obj: reaches from 0.000,0.000,0.000 to 1.000e99,1.000e99,1.000e99, too far outside a room of size 1.000",
    ),
    row(
        "relight --room room.obj --object room.obj --place 1e6,0,0 --solver cpu --out out",
        2,
        "too far outside a room",
    ),
    row(
        "compare dark.obj --out out",
        2,
        "dark.obj: no face emits light: give a material Ke",
    ),
    row(
        "solve dark.obj --solver cpu --out out",
        2,
        "dark.obj: no face emits light: give a material Ke (OBJ) or emissiveFactor (glTF); --allow-dark",
    ),
    row("plan dark.obj", 2, "dark.obj: no face emits light"),
    row(
        "chart dark.obj --out out",
        2,
        "dark.obj: no face emits light",
    ),
    row(
        "converge dark.obj --out out",
        2,
        "dark.obj: no face emits light",
    ),
    row(
        "relight --room dark.obj --object dark.obj --scale 0.1 --solver cpu --out out",
        2,
        "dark.obj: no face emits light",
    ),
    row(
        "solve dark.obj --allow-dark --solver cpu --out out",
        0,
        "note: no face emits light",
    ),
    row(
        "solve inside_out.obj --solver cpu --out out",
        0,
        "--two-sided makes a front of each back",
    ),
    row(
        "solve inside_out.obj --two-sided --solver cpu --out out",
        0,
        "% off",
    ),
];

#[test]
fn numbers_are_held_or_refused() {
    let folder = with_materials("numbers");
    let far = Room { side: 1e78, ..ROOM };
    let near = Room {
        side: 1e-70,
        ..ROOM
    };
    let bright = Room {
        lamp: "sun",
        ..ROOM
    };
    let dark = Room {
        lamp: "wall",
        ..ROOM
    };
    let inside_out = Room {
        inside_out: true,
        ..ROOM
    };
    let rooms = [
        ("far", far),
        ("near", near),
        ("bright", bright),
        ("dark", dark),
        ("inside_out", inside_out),
    ];
    for (name, room) in rooms {
        put(&folder, &format!("{name}.obj"), room.obj());
    }
    judge(&folder, NUMBERS);
    run(
        &folder,
        &["solve", "dark.obj", "--allow-dark", "--solver", "cpu"],
    );
    assert!(result(&folder)["estimated_error"].is_null());
    fs::remove_dir_all(folder).unwrap();
}

/// Σ absorbed and emitted of a result; every figure of its energy is a number.
fn energy(folder: &Path) -> [f64; 2] {
    let energy = &result(folder)["energy"];
    for (name, value) in energy.as_object().unwrap() {
        let parts = value.as_array().map_or(std::slice::from_ref(value), |v| v);
        assert!(parts.iter().all(Value::is_number), "{name}: {value}");
    }
    ["absorbed", "emitted"].map(|name| {
        let parts = energy[name].as_array().unwrap();
        parts.iter().filter_map(Value::as_f64).sum()
    })
}

#[test]
fn a_room_listed_again_is_as_bright_as_once() {
    let folder = with_materials("again");
    let cells = ["--solver", "cpu", "--cells", "4", "--samples", "4"];
    let solve = |name: &str| {
        let ended = run(&folder, &[&["solve", name], &cells[..]].concat());
        let what = told(name, &ended);
        println!("{what}");
        assert_eq!(ended.code, Some(0), "{what}");
        (energy(&folder), ended.stderr)
    };
    let ([absorbed, emitted], said) = solve("room.obj");
    assert!(!said.contains("lie on each other"), "{said}");
    for times in [2, 4] {
        for mixed in [false, true] {
            let room = Room {
                times,
                mixed,
                ..ROOM
            };
            put(&folder, "again.obj", room.obj());
            let (found, said) = solve("again.obj");
            // The sums of another order of faces.
            let near = |a: f64, b: f64| ((a - b) / b).abs() < 1e-5;
            assert!(
                near(found[0], absorbed) && near(found[1], emitted),
                "{found:?}"
            );
            assert!(said.contains("only the first of each is lit"), "{said}");
        }
    }
    let relight = "relight --room room.obj --object room.obj --solver cpu --texels 4";
    let ended = run(&folder, &relight.split(' ').collect::<Vec<_>>());
    let what = told(relight, &ended);
    println!("{what}");
    assert_eq!(ended.code, Some(0), "{what}");
    let [_, found] = energy(&folder);
    assert!((found / emitted - 1.0).abs() < 1e-5, "{found}");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn white_walls_converge_and_say_what_rounding_adds() {
    let folder = with_materials("white");
    put(
        &folder,
        "m.mtl",
        MATERIALS.replace(".5 .5 .5", ".999999 .999999 .999999"),
    );
    let solve = ["solve", "room.obj", "--solver", "cpu"];
    // Asked for an error, it says that there is none to be had.
    let ended = run(&folder, &solve);
    let what = told("white walls", &ended);
    println!("{what}");
    assert_eq!(ended.code, Some(0), "{what}");
    for said in ["rounding adds up to ", "was asked, and about "] {
        assert!(ended.stderr.contains(said), "{}", ended.stderr);
    }
    energy(&folder);
    let ended = run(
        &folder,
        &[&solve[..], &["--iteration", "cg", "--conserve"]].concat(),
    );
    let what = told("white walls, shot", &ended);
    println!("{what}");
    assert_eq!(ended.code, Some(0), "{what}");
    assert!(
        ended.stderr.contains("rounding adds up to "),
        "{}",
        ended.stderr
    );
    assert_eq!(result(&folder)["converged"], true);
    // All light is absorbed in the end, and the walls' is a millionth of what they hold.
    let [absorbed, emitted] = energy(&folder);
    assert!(
        (absorbed / emitted - 1.0).abs() < 0.12,
        "{absorbed} of {emitted}"
    );
    fs::remove_dir_all(folder).unwrap();
}

const MANY: &[Row] = &[
    row(
        "solve coinciding.obj --solver cpu --quality draft --texels 2 --out out",
        0,
        "pairs of fronts lie on each other",
    ),
    row(
        "solve nearly.obj --solver cpu --quality draft --texels 2 --out out",
        0,
        "pairs of fronts lie on each other",
    ),
    row(
        "solve star.obj --solver cpu --texels 1 --cells 1 --samples 1 --out out",
        0,
        "split into triangles",
    ),
    // Nothing is set: coarser than it would be, and said.
    row(
        "solve soup.obj --solver cpu --epsilon 0.1 --out out",
        0,
        "1006 faces: 16×16 texels, 1×1 cell and 4 samples a cell instead of",
    ),
    row(
        "solve soup.obj --texels 2048 --quality draft --solver cpu --out out",
        2,
        "would fit",
    ),
    row(
        "plan soup.obj --texels 16 --cells 4 --solver cpu",
        0,
        "  memory  ",
    ),
];

#[test]
fn many_faces_end_in_time() {
    let folder = with_materials("faces");
    let square = |k: u32| {
        let low = 0.2 + 1e-6 * f64::from(k % 1000) * unit(k);
        format!("v {low} .2 .5\nv .8 {low} .5\nv .8 .8 .5\nv {low} .8 .5\nf -4 -3 -2 -1\n")
    };
    let one = "v .2 .2 .5\nv .8 .2 .5\nv .8 .8 .5\nv .2 .8 .5\n";
    let same = ROOM.obj() + "usemtl wall\n" + one + &"f 9 10 11 12\n".repeat(20_000);
    put(&folder, "coinciding.obj", same);
    let nearly: String = (0..10_000).map(square).collect();
    put(
        &folder,
        "nearly.obj",
        ROOM.obj() + "usemtl wall\n" + &nearly,
    );
    put(&folder, "soup.obj", soup(1000));
    let corner = |k: u32| {
        let (y, x) = (f64::from(k) * std::f64::consts::TAU / 1000.0).sin_cos();
        let r = if k.is_multiple_of(2) { 1.0 } else { 0.5 };
        format!("v {} {} 0\n", r * x, r * y)
    };
    let numbers: String = (1..=1000).map(|k| format!(" {k}")).collect();
    let star = (0..1000).map(corner).collect::<String>();
    put(
        &folder,
        "star.obj",
        format!("mtllib m.mtl\n{star}usemtl lamp\nf{numbers}\n"),
    );
    judge(&folder, MANY);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn what_takes_long_says_so_before_it_starts() {
    let folder = with_materials("long");
    put(&folder, "soup.obj", soup(3000));
    let solve = "solve soup.obj --solver cpu --texels 16 --cells 4 --samples 16";
    // Whatever it says, it says in the first seconds.
    let script = "timeout -s KILL 40 \"$0\" \"$@\"; true";
    let ended = in_shell(&folder, script, &solve.split(' ').collect::<Vec<_>>());
    println!("{}", told(solve, &ended));
    let line = ended
        .stderr
        .lines()
        .find(|line| line.contains("is expected to take"));
    let line = line.unwrap_or_else(|| panic!("{}", ended.stderr));
    assert!(
        line.contains("s: --texels ") && line.contains("a tenth"),
        "{line}"
    );
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn too_little_memory_is_refused() {
    let folder = with_materials("memory");
    let solve = "solve room.obj --solver cpu --texels 1024 --quality draft";
    let words: Vec<&str> = solve.split(' ').collect();
    let ended = in_shell(&folder, "ulimit -v 800000; exec \"$0\" \"$@\"", &words);
    let what = told(solve, &ended);
    println!("{what}");
    assert_eq!(ended.code, Some(2), "{what}");
    well_behaved(&folder, &ended, &what);
    let line = errors(&ended)[0];
    assert!(
        line.contains("allowed by ulimit") && line.contains("would fit"),
        "{line}"
    );
    // And what is said to fit does.
    let found = line
        .split("--texels ")
        .nth(1)
        .and_then(|rest| rest.split(' ').next());
    let texels = found.unwrap_or_else(|| panic!("{line}"));
    let fitting = [
        "solve",
        "room.obj",
        "--solver",
        "cpu",
        "--quality",
        "draft",
        "--texels",
        texels,
    ];
    let ended = in_shell(&folder, "ulimit -v 800000; exec \"$0\" \"$@\"", &fitting);
    let what = told(texels, &ended);
    println!("{what}");
    assert_eq!(ended.code, Some(0), "{what}");
    fs::remove_dir_all(folder).unwrap();
}

/// Runs the program until it ends; its greatest resident memory in bytes.
fn peak(folder: &Path, arguments: &str) -> u64 {
    let mut child = Command::new(env!("CARGO_BIN_EXE_radiosity"))
        .args(arguments.split(' '))
        .current_dir(folder)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut most = 0;
    while child.try_wait().unwrap().is_none() {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find(|line| line.starts_with("VmHWM:"));
        let kib = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<u64>().ok());
        most = most.max(kib.unwrap_or(0) << 10);
        sleep(Duration::from_millis(2));
    }
    most
}

#[cfg(target_os = "linux")]
#[test]
fn the_memory_of_a_plan_is_that_of_the_solve() {
    let folder = with_materials("planned");
    put(&folder, "soup.obj", soup(10_000));
    // Texels, faces, links.
    for (name, texels, cells, more) in [
        ("room.obj", 512, 1, ""),
        ("room.obj", 128, 8, ""),
        ("soup.obj", 1, 1, " --max-shots 2"),
    ] {
        let arguments = format!(
            "solve {name} --solver cpu --epsilon 0.1 --texels {texels} --cells {cells} --samples 1 --quiet{more}"
        );
        let found = peak(&folder, &arguments);
        let scene = common::import::load(&folder.join(name), &Default::default()).unwrap();
        let settings = common::settings::Settings {
            meshing: common::settings::Meshing {
                texels,
                cells,
                samples: 1,
            },
            ..Default::default()
        };
        let mut memory = Memory::cpu(&Counts::new(&scene, &settings.meshing), &settings);
        if !more.is_empty() {
            // Two shots make few of the links.
            memory.links = 0;
        }
        let share = memory.bytes() as f64 / found as f64;
        println!("{arguments}: {found} bytes, {share:.2} of them told");
        assert!(
            (1.0 / 1.3..1.3).contains(&share),
            "{arguments}: {found}, {memory:?}"
        );
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn ctrl_c_ends_the_preparation() {
    let folder = with_materials("interrupted");
    put(&folder, "soup.obj", soup(5000));
    let solve = "solve soup.obj --solver cpu --texels 16 --cells 4 --samples 256 --quiet";
    let mut child = Command::new(env!("CARGO_BIN_EXE_radiosity"))
        .args(solve.split(' '))
        .current_dir(&folder)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    sleep(Duration::from_secs(4));
    let interrupt = format!("kill -INT {}", child.id());
    assert!(
        Command::new("sh")
            .args(["-c", &interrupt])
            .status()
            .unwrap()
            .success()
    );
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() && start.elapsed().as_secs() < 10 {
        sleep(Duration::from_millis(10));
    }
    let code = child.try_wait().unwrap().map(|status| status.code());
    println!("{:?} after {:?}", code, start.elapsed());
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(code, Some(Some(130)));
    assert!(!folder.join("out/result.json").exists());
    fs::remove_dir_all(folder).unwrap();
}
