//! No input ends in NaN, a hang or an abort: numbers that f32 cannot hold, faces on faces, more faces
//! than there is time for.

#![allow(
    clippy::disallowed_methods,
    reason = "reads what the program and the system wrote"
)]

use super::cube::{MATERIALS, ROOM, Room, result, soup, unit, with_materials};
use super::kit::{Row, in_shell, judge, put, row, run, told};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

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
