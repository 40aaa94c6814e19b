//! Extreme input: numbers that f32 cannot hold, coinciding faces, many faces, long solves. None may end in NaN, a hang
//! or an abort.

use crate::program::command::{ProgramEnd, TestFolder};
use crate::program::room::{Cube, ROOM, folder_with_room, room_with_triangles, unit_hash};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

const NUMBERS: &str = "
solve far.obj --solver cpu => far.obj: extends over 1e78
solve near.obj --solver cpu => near.obj: extends over 1e-70
solve bright.obj --solver cpu => m.mtl: material sun: emitted radiance Ke
relight --room room.obj --object room.obj --scale 1e99 --solver cpu => room.obj: reaches from 0.000,0.000,0.000 to \
    1.000e99,1.000e99,1.000e99, the room only from 0.000,0.000,0.000 to 1.000,1.000,1.000: see --scale and --place
relight --room room.obj --object room.obj --place 1e6,0,0 --solver cpu => room.obj: reaches from
compare dark.obj => dark.obj: no face emits light: give a material Ke
solve dark.obj --solver cpu => dark.obj: no face emits light: give a material Ke (OBJ) or emissiveFactor (glTF), or solve it with --lamp X,Y,Z,W or --sky L
solve dark.obj --dry-run => dark.obj: no face emits light
chart dark.obj => dark.obj: no face emits light
converge dark.obj => dark.obj: no face emits light
relight --room dark.obj --object dark.obj --scale 0.1 --solver cpu => dark.obj: no face emits light
solve line.obj --solver cpu => line.obj: no face that emits light has an area: face 7 (unnamed_object) is a line
relight --room line.obj --object cube.obj => line.obj: no face that emits light has an area: face 7
solve outlier.obj --solver cpu => outlier.obj: its light is lost in rounding: the largest lamp, face 2 (unnamed_object), \
    extends over 1.0e0, and the scene over 1.0e12; is a corner of face 7 (unnamed_object) misplaced?
";

#[test]
fn extreme_numbers_are_solved_or_refused() {
    let folder = folder_with_room();
    let room = |name: &str, room: Cube| folder.write(name, room.obj_text());
    room("far.obj", Cube { high: 1e78, ..ROOM });
    room("near.obj", Cube { high: 1e-70, ..ROOM });
    room("bright.obj", Cube { lamp: "sun", ..ROOM });
    room("dark.obj", Cube { lamp: "wall", ..ROOM });
    let dark = Cube { lamp: "wall", ..ROOM }.obj_text();
    folder.write("line.obj", dark + "usemtl lamp\nf 1 2 1\n");
    folder.write("outlier.obj", ROOM.obj_text() + "v .5 1e12 .5\nusemtl wall\nf 1 2 -1\n");
    let turned = Cube {
        inside_out: true,
        ..ROOM
    };
    room("inside_out.obj", turned);
    folder.assert_refused(NUMBERS);
    for (line, part) in [
        ("solve inside_out.obj", "--two-sided makes a front of each back"),
        ("solve inside_out.obj --two-sided", "% off"),
    ] {
        let end = folder.succeed(&format!("{line} --solver cpu"));
        assert!(end.stderr.contains(part), "{end}");
    }
}

/// Σ absorbed and emitted of a result; every figure of its energy is a number.
fn absorbed_and_emitted(folder: &TestFolder) -> [f64; 2] {
    let energy = folder.read_json("out/result.json")["energy"].clone();
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
    let folder = folder_with_room();
    let solve = |name: &str| {
        let end = folder.succeed(&format!("shoot {name} --solver cpu --texels 4 --patches 2 --samples 4"));
        let noted = end.stderr.contains("only one of each is lit");
        (absorbed_and_emitted(&folder), noted)
    };
    let ([absorbed, emitted], noted) = solve("room.obj");
    assert!(!noted);
    for (times, mixed) in [(2, false), (2, true), (4, false), (4, true)] {
        folder.write("again.obj", Cube { times, mixed, ..ROOM }.obj_text());
        let (found, noted) = solve("again.obj");
        // The sums of another order of faces.
        let near = |a: f64, b: f64| ((a - b) / b).abs() < 1e-5;
        assert!(near(found[0], absorbed) && near(found[1], emitted), "{found:?}");
        assert!(noted, "{times} {mixed}");
    }
    folder.succeed("relight --room room.obj --object room.obj --solver cpu --texels 4");
    let [_, found] = absorbed_and_emitted(&folder);
    assert!((found / emitted - 1.0).abs() < 1e-5, "{found}");
}

#[test]
fn white_walls_converge_and_report_rounding() {
    let folder = folder_with_room();
    let white = "newmtl wall\nKd .999999 .999999 .999999\nnewmtl lamp\nKd .999999 .999999 .999999\nKe 1 1 1\n";
    folder.write("m.mtl", white);
    // The estimate tells that the requested error cannot be had.
    let end = folder.succeed("solve room.obj --solver cpu --texels 8");
    for said in ["rounding adds up to ", "was requested, and about "] {
        assert!(end.stderr.contains(said), "{end}");
    }
    absorbed_and_emitted(&folder);
    let end = folder.succeed("shoot room.obj --solver cpu --texels 8 --iteration cg --conserve");
    assert!(end.stderr.contains("rounding adds up to "), "{end}");
    assert_eq!(folder.read_json("out/result.json")["converged"], true);
    // All light is absorbed in the end, and the walls' is a millionth of what they hold.
    let [absorbed, emitted] = absorbed_and_emitted(&folder);
    assert!((absorbed / emitted - 1.0).abs() < 0.12, "{absorbed} of {emitted}");
}

/// Returns the text of a room with `count` squares, whose corners differ by up to `most`.
fn coinciding_squares(count: u32, most: f64) -> String {
    let square = |k: u32| {
        let low = 0.2 + most * unit_hash(k);
        format!("v {low} .2 .5\nv .8 {low} .5\nv .8 .8 .5\nv {low} .8 .5\nf -4 -3 -2 -1\n")
    };
    let squares: String = (0..count).map(square).collect();
    ROOM.obj_text() + "usemtl wall\n" + &squares
}

/// Returns the number right before `words` in the messages.
fn number_before(end: &ProgramEnd, words: &str) -> f64 {
    let (before, _) = end
        .stderr
        .split_once(words)
        .unwrap_or_else(|| panic!("no {words}: {end}"));
    let digits = before.rsplit(|c: char| !c.is_ascii_digit()).next().unwrap();
    digits
        .parse()
        .unwrap_or_else(|_| panic!("no number before {words}: {end}"))
}

/// With twice the faces a search of all pairs would find four times as many.
#[test]
fn pairs_and_links_grow_linearly_with_coinciding_faces() {
    let folder = folder_with_room();
    for (most, count) in [(0.0, 1000), (1e-3, 500)] {
        let [few, many] = [count, 2 * count].map(|count| {
            folder.write("squares.obj", coinciding_squares(count, most));
            let end = folder.succeed("solve squares.obj --solver cpu --quality draft --texels 2");
            [" pairs of fronts lie on each other", " links in "].map(|words| number_before(&end, words))
        });
        println!("{few:?} and {many:?} pairs and links");
        for (few, many) in few.into_iter().zip(many) {
            assert!(few > 0.0 && many <= 2.5 * few, "{few} and {many}");
        }
    }
}

#[test]
fn scenes_of_many_faces_are_solved_coarser_or_refused() {
    let folder = folder_with_room();
    folder.write("soup.obj", room_with_triangles(1000));
    let corner = |k: u32| {
        let (y, x) = (f64::from(k) * std::f64::consts::TAU / 1000.0).sin_cos();
        let r = if k.is_multiple_of(2) { 1.0 } else { 0.5 };
        format!("v {} {} 0\n", r * x, r * y)
    };
    let numbers: String = (1..=1000).map(|k| format!(" {k}")).collect();
    let star = (0..1000).map(corner).collect::<String>();
    folder.write("star.obj", format!("mtllib m.mtl\n{star}usemtl lamp\nf{numbers}\n"));
    // Without options the defaults are coarser, and a note says so.
    let coarser = "1006 faces: --texels 16 --patches 1 --samples 4 instead of 16, 4 and 4";
    for (line, part) in [
        ("star.obj --texels 1 --patches 1 --samples 1", "split into triangles"),
        ("soup.obj --max-shots 3", coarser),
        ("soup.obj --dry-run --texels 16 --patches 4", "  memory  "),
    ] {
        let end = folder.succeed(&format!("shoot {line} --solver cpu"));
        assert!((end.stdout.clone() + &end.stderr).contains(part), "{end}");
    }
    folder.fail_with(
        2,
        "solve soup.obj --texels 2048 --quality draft --solver cpu",
        "would fit",
    );
}

/// The solve would take minutes, and its preparation seconds.
#[test]
fn interrupt_during_preparation_is_code_130_and_writes_nothing() {
    let folder = folder_with_room();
    folder.write("soup.obj", room_with_triangles(3000));
    let shoot = "shoot soup.obj --solver cpu --samples 256";
    let mut child = Command::new(env!("CARGO_BIN_EXE_radiosity"))
        .args(shoot.split(' '))
        .current_dir(folder.path(""))
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    lines.find(|line| line.contains(" faces: --texels ")).expect("a note");
    let interrupt = format!("kill -INT {}", child.id());
    assert!(Command::new("sh").args(["-c", &interrupt]).status().unwrap().success());
    lines.for_each(drop);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(!folder.has("out/result.json"));
}
