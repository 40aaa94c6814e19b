//! Extreme input: numbers that f32 cannot hold, coinciding faces, many faces, long solves. None may end in NaN, a hang
//! or an abort.

#![allow(clippy::disallowed_methods, reason = "reads what the program and the system wrote")]

use super::cube::{MATERIALS, ROOM, Room, folder_with_materials, read_result, room_with_triangles, unit_hash};
use super::kit::{
    Row, assert_clean_end, assert_rows, describe_end, error_lines, processor_seconds, row, run_in_shell, run_program,
    write_file,
};
use serde_json::Value;
use std::fs;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

const NUMBERS: &[Row] = &[
    row("solve far.obj --solver cpu --out out", 2, "far.obj: extends over 1e78"),
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
    row("solve dark.obj --dry-run --out out", 2, "dark.obj: no face emits light"),
    row("chart dark.obj --out out", 2, "dark.obj: no face emits light"),
    row("converge dark.obj --out out", 2, "dark.obj: no face emits light"),
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
    row("solve inside_out.obj --two-sided --solver cpu --out out", 0, "% off"),
];

#[test]
fn extreme_numbers_are_solved_or_refused() {
    let folder = folder_with_materials("numbers");
    let far = Room { side: 1e78, ..ROOM };
    let near = Room { side: 1e-70, ..ROOM };
    let bright = Room { lamp: "sun", ..ROOM };
    let dark = Room { lamp: "wall", ..ROOM };
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
        write_file(&folder, &format!("{name}.obj"), room.obj_text());
    }
    assert_rows(&folder, NUMBERS);
    run_program(&folder, &["solve", "dark.obj", "--allow-dark", "--solver", "cpu"]);
    assert!(read_result(&folder)["estimated_error"].is_null());
    fs::remove_dir_all(folder).unwrap();
}

/// Σ absorbed and emitted of a result; every figure of its energy is a number.
fn absorbed_and_emitted(folder: &Path) -> [f64; 2] {
    let energy = &read_result(folder)["energy"];
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
fn duplicated_room_is_as_bright_as_single_one() {
    let folder = folder_with_materials("again");
    let patches = ["--solver", "cpu", "--patches", "4", "--samples", "4"];
    let solve = |name: &str| {
        let ended = run_program(&folder, &[&["shoot", name], &patches[..]].concat());
        let what = describe_end(name, &ended);
        println!("{what}");
        assert_eq!(ended.code, Some(0), "{what}");
        (absorbed_and_emitted(&folder), ended.stderr)
    };
    let ([absorbed, emitted], said) = solve("room.obj");
    assert!(!said.contains("lie on each other"), "{said}");
    for times in [2, 4] {
        for mixed in [false, true] {
            let room = Room { times, mixed, ..ROOM };
            write_file(&folder, "again.obj", room.obj_text());
            let (found, said) = solve("again.obj");
            // The sums of another order of faces.
            let near = |a: f64, b: f64| ((a - b) / b).abs() < 1e-5;
            assert!(near(found[0], absorbed) && near(found[1], emitted), "{found:?}");
            assert!(said.contains("only the first of each is lit"), "{said}");
        }
    }
    let relight = "relight --room room.obj --object room.obj --solver cpu --texels 4";
    let ended = run_program(&folder, &relight.split(' ').collect::<Vec<_>>());
    let what = describe_end(relight, &ended);
    println!("{what}");
    assert_eq!(ended.code, Some(0), "{what}");
    let [_, found] = absorbed_and_emitted(&folder);
    assert!((found / emitted - 1.0).abs() < 1e-5, "{found}");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn white_walls_converge_and_report_rounding() {
    let folder = folder_with_materials("white");
    write_file(
        &folder,
        "m.mtl",
        MATERIALS.replace(".5 .5 .5", ".999999 .999999 .999999"),
    );
    let room = ["room.obj", "--solver", "cpu"];
    // Asked for an error, it says that there is none to be had.
    let ended = run_program(&folder, &[&["solve"], &room[..]].concat());
    let what = describe_end("white walls", &ended);
    println!("{what}");
    assert_eq!(ended.code, Some(0), "{what}");
    for said in ["rounding adds up to ", "was requested, and about "] {
        assert!(ended.stderr.contains(said), "{}", ended.stderr);
    }
    absorbed_and_emitted(&folder);
    let ended = run_program(
        &folder,
        &[&["shoot"], &room[..], &["--iteration", "cg", "--conserve"]].concat(),
    );
    let what = describe_end("white walls, shot", &ended);
    println!("{what}");
    assert_eq!(ended.code, Some(0), "{what}");
    assert!(ended.stderr.contains("rounding adds up to "), "{}", ended.stderr);
    assert_eq!(read_result(&folder)["converged"], true);
    // All light is absorbed in the end, and the walls' is a millionth of what they hold.
    let [absorbed, emitted] = absorbed_and_emitted(&folder);
    assert!((absorbed / emitted - 1.0).abs() < 0.12, "{absorbed} of {emitted}");
    fs::remove_dir_all(folder).unwrap();
}

/// Writes a room with `count` copies of one square.
fn coinciding_squares(count: usize) -> String {
    let one = "v .2 .2 .5\nv .8 .2 .5\nv .8 .8 .5\nv .2 .8 .5\n";
    ROOM.obj_text() + "usemtl wall\n" + one + &"f 9 10 11 12\n".repeat(count)
}

/// Writes a room with `count` squares whose corners differ by up to a thousandth.
fn nearly_coinciding_squares(count: usize) -> String {
    let square = |k: u32| {
        let low = 0.2 + 1e-6 * f64::from(k % 1000) * unit_hash(k);
        format!("v {low} .2 .5\nv .8 {low} .5\nv .8 .8 .5\nv {low} .8 .5\nf -4 -3 -2 -1\n")
    };
    let squares: String = (0..count as u32).map(square).collect();
    ROOM.obj_text() + "usemtl wall\n" + &squares
}

/// Returns the number right before `words` in `text`.
fn number_before(text: &str, words: &str) -> f64 {
    let (before, _) = text.split_once(words).unwrap_or_else(|| panic!("no {words:?}: {text}"));
    let digits = before.rsplit(|c: char| !c.is_ascii_digit()).next().unwrap();
    digits
        .parse()
        .unwrap_or_else(|_| panic!("no number before {words:?}: {text}"))
}

/// With twice the faces a search of all pairs would find four times as many.
#[test]
fn pairs_and_links_grow_linearly_with_coinciding_faces() {
    let folder = folder_with_materials("coinciding");
    let rooms = [
        (coinciding_squares as fn(usize) -> String, 10_000),
        (nearly_coinciding_squares, 5_000),
    ];
    for (room, count) in rooms {
        let counts = [count, 2 * count].map(|count| {
            write_file(&folder, "squares.obj", room(count));
            let solve = "solve squares.obj --solver cpu --quality draft --texels 2 --out out";
            let ended = run_program(&folder, &solve.split(' ').collect::<Vec<_>>());
            let what = describe_end(solve, &ended);
            println!("{count} squares: {what}");
            assert_eq!(ended.code, Some(0), "{what}");
            assert!(error_lines(&ended).is_empty(), "{what}");
            assert_clean_end(&folder, &ended, &what);
            [" pairs of fronts lie on each other", " links in "].map(|words| number_before(&ended.stderr, words))
        });
        let [few, many] = counts;
        println!("{few:?} and {many:?} pairs and links");
        for (few, many) in few.into_iter().zip(many) {
            assert!(few > 0.0 && many <= 2.5 * few, "{few} and {many}");
        }
    }
    fs::remove_dir_all(folder).unwrap();
}

const MANY: &[Row] = &[
    row(
        "shoot star.obj --solver cpu --texels 1 --patches 1 --samples 1 --out out",
        0,
        "split into triangles",
    ),
    // Without options the defaults are coarser, and a note says so.
    row(
        "shoot soup.obj --solver cpu --epsilon 0.1 --out out",
        0,
        "1006 faces: 16×16 texels, 1×1 patch and 4 samples a patch instead of",
    ),
    row(
        "solve soup.obj --texels 2048 --quality draft --solver cpu --out out",
        2,
        "would fit",
    ),
    row(
        "shoot soup.obj --dry-run --texels 16 --patches 4 --solver cpu",
        0,
        "  memory  ",
    ),
];

#[test]
fn scenes_of_many_faces_are_solved_coarser_or_refused() {
    let folder = folder_with_materials("faces");
    write_file(&folder, "soup.obj", room_with_triangles(1000));
    let corner = |k: u32| {
        let (y, x) = (f64::from(k) * std::f64::consts::TAU / 1000.0).sin_cos();
        let r = if k.is_multiple_of(2) { 1.0 } else { 0.5 };
        format!("v {} {} 0\n", r * x, r * y)
    };
    let numbers: String = (1..=1000).map(|k| format!(" {k}")).collect();
    let star = (0..1000).map(corner).collect::<String>();
    write_file(
        &folder,
        "star.obj",
        format!("mtllib m.mtl\n{star}usemtl lamp\nf{numbers}\n"),
    );
    assert_rows(&folder, MANY);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn long_solve_is_announced_before_it_starts() {
    let folder = folder_with_materials("long");
    write_file(&folder, "soup.obj", room_with_triangles(3000));
    let shoot = "shoot soup.obj --solver cpu --texels 16 --patches 4 --samples 16";
    // The solve would take hours. The announcement comes within two minutes of processor time, forecast included.
    let script = "ulimit -t 120; \"$0\" \"$@\"; true";
    let ended = run_in_shell(&folder, script, &shoot.split(' ').collect::<Vec<_>>());
    println!("{}", describe_end(shoot, &ended));
    let line = ended.stderr.lines().find(|line| line.contains("is expected to take"));
    let line = line.unwrap_or_else(|| panic!("{}", ended.stderr));
    assert!(line.contains("s: --texels ") && line.contains("a tenth"), "{line}");
    fs::remove_dir_all(folder).unwrap();
}

/// Returns true if a process has installed a handler of SIGINT.
fn handles_interrupt(id: u32) -> bool {
    const SIGINT: u32 = 2;
    let text = fs::read_to_string(format!("/proc/{id}/status")).unwrap_or_default();
    let caught = text.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    let mask = caught.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask & (1 << (SIGINT - 1)) != 0)
}

#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_stops_preparation() {
    let folder = folder_with_materials("interrupted");
    write_file(&folder, "soup.obj", room_with_triangles(5000));
    let shoot = "shoot soup.obj --solver cpu --texels 16 --patches 4 --samples 256 --quiet";
    let mut child = Command::new(env!("CARGO_BIN_EXE_radiosity"))
        .args(shoot.split(' '))
        .current_dir(&folder)
        .process_group(0)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let id = child.id();
    // The preparation takes far more than a second of work after Ctrl-C is handled.
    let mut wait_until = |what: &str, reached: &dyn Fn() -> bool| {
        while !reached() {
            assert!(child.try_wait().unwrap().is_none(), "ended before {what}");
            sleep(Duration::from_millis(10));
        }
    };
    wait_until("Ctrl-C is handled", &|| handles_interrupt(id));
    let start = processor_seconds(id);
    wait_until("it is interrupted", &|| processor_seconds(id) > start + 1.0);
    let interrupt = format!("kill -INT {}", child.id());
    assert!(Command::new("sh").args(["-c", &interrupt]).status().unwrap().success());
    let start = processor_seconds(id);
    let mut work = 0.0;
    while child.try_wait().unwrap().is_none() && work < 20.0 {
        sleep(Duration::from_millis(10));
        work = processor_seconds(id) - start;
    }
    let code = child.try_wait().unwrap().map(|status| status.code());
    println!("{code:?} after {work:.1} s of work");
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(code, Some(Some(130)));
    assert!(!folder.join("out/result.json").exists());
    fs::remove_dir_all(folder).unwrap();
}
