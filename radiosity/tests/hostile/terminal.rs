//! Output: closed and full pipes, control characters, `--quiet`.

use crate::program::merge::expose_scene;
use crate::program::room::{MATERIALS, ROOM, folder_with_room};
use std::fs;

const SOLVE: &str = "solve room.obj --solver cpu --texels 4";
const PLAN: &str = "solve room.obj --dry-run --solver cpu";
const CLOSED: &str = "RUN | true; exit ${PIPESTATUS[0]}";

/// Script around the program, arguments, exit code, and whether there is a result.
const PIPES: &[(&str, &str, i32, bool)] = &[
    (CLOSED, PLAN, 0, false),
    (CLOSED, "adapters", 0, false),
    (CLOSED, "--help", 0, false),
    ("RUN 2>&1 | true; exit ${PIPESTATUS[0]}", SOLVE, 0, true),
    ("RUN >/dev/full", PLAN, 4, false),
    ("RUN >/dev/full", "adapters", 4, false),
    ("RUN >/dev/full", "--help", 4, false),
    ("RUN >/dev/full", "--version", 4, false),
    ("RUN >/dev/full", SOLVE, 0, true),
    ("RUN 2>/dev/full", SOLVE, 0, true),
    ("RUN 2>/dev/full", "solve none.obj", 2, false),
    ("RUN 2>/dev/full", "solve", 2, false),
    ("RUN >&- 2>&-", SOLVE, 0, true),
    ("RUN >&-", PLAN, 0, false),
];

#[test]
fn closed_and_full_pipes_do_not_end_a_solve() {
    let folder = folder_with_room();
    for (script, arguments, code, result) in PIPES {
        let _ = fs::remove_dir_all(folder.path("out"));
        let end = folder.run_in_shell(script, arguments);
        assert_eq!(end.code, Some(*code), "{end}");
        assert_eq!(end.errors().len(), usize::from(*code == 4), "{end}");
        assert_eq!(folder.has("out/result.json"), *result, "{end}");
    }
}

#[test]
fn control_characters_in_names_are_escaped() {
    let folder = folder_with_room();
    let room = ROOM.obj_text();
    let room = room.replace("usemtl lamp", "g lamp\u{1b}[2J\u{7}\nusemtl lamp\u{1b}]0;x");
    folder.write("\u{1b}[31mred.obj", room);
    folder.write("m.mtl", MATERIALS.replace("newmtl lamp", "newmtl lamp\u{1b}]0;x"));
    folder.succeed("shoot \u{1b}[31mred.obj --solver cpu --patches 1 --texels 2");
    let result = folder.read_json("out/result.json");
    for name in [&result["scene"], &result["faces"][1]["name"]] {
        let name = name.as_str().unwrap();
        assert!(name.contains("\\u{1b}[") && !name.contains('\u{1b}'), "{name:?}");
    }
    folder.write("\u{1b}[31mcube.obj", folder.read("cube.obj"));
    let line = "relight --room \u{1b}[31mred.obj --object \u{1b}[31mcube.obj --place .5,.5,.5 --solver cpu --texels 2 --error 5%";
    folder.succeed(line);
    for (name, seconds) in [("\u{1b}[1.png", 1.0), ("\u{9b}2.png", 4.0)] {
        expose_scene([48, 32], seconds).save(folder.path(name)).unwrap();
    }
    folder.succeed("merge \u{1b}[1.png \u{9b}2.png --seconds 1,4");
    for page in ["report.html", "view.html", "merge.html"] {
        let text = folder.read_text(&format!("out/{page}"));
        let control = text.find(|c: char| c.is_control() && !"\t\n\r".contains(c));
        assert_eq!(control, None, "{page}");
    }
    folder.assert_refused(
        "solve no\u{1b}[2Jroom.obj => no\\u{1b}[2Jroom.obj: cannot be read
         solve room.obj --bad\u{1b}[31m => unexpected argument",
    );
}

#[test]
fn quiet_prints_errors_only() {
    let folder = folder_with_room();
    // An input that gives notes of the import and of the adapter.
    folder.write("odd.obj", ROOM.obj_text() + "f 1 1 2\nf 1 2 2\nl 1 2\n");
    for (line, code) in [
        ("solve odd.obj --solver cpu --texels 2", 0),
        ("solve odd.obj --adapter NOSUCH --texels 2", 3),
    ] {
        let end = folder.run(line);
        assert!(end.stderr.contains("note:"), "{end}");
        let end = folder.run(&format!("{line} --quiet"));
        assert_eq!(end.code, Some(code), "{end}");
        assert_eq!(
            (end.stdout.as_str(), end.stderr.lines().count()),
            ("", end.errors().len()),
            "{end}"
        );
    }
}
