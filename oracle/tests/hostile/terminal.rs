//! Where output goes: pipes that close or are full, terminals, and nowhere when it is to be quiet.

use super::kit::{errors, in_shell, put, run, told, well_behaved};
use super::room::{MATERIALS, ROOM, with_room};
use serde_json::Value;
use std::fs;

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
