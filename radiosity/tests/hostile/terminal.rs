//! Output: closed and full pipes, control characters, `--quiet`.

use super::kit::{assert_clean_end, describe_end, error_lines, run_in_shell, run_program, write_file};
use super::room::{MATERIALS, ROOM, folder_with_room};
use serde_json::Value;
use std::fs;

/// Script around the program, arguments, exit code, number of error lines, true if there is a result.
const PIPES: &[(&str, &str, i32, usize, bool)] = &[
    (
        "\"$0\" \"$@\" | true; exit ${PIPESTATUS[0]}",
        "solve room.obj --dry-run --solver cpu",
        0,
        0,
        false,
    ),
    ("\"$0\" \"$@\" | true; exit ${PIPESTATUS[0]}", "adapters", 0, 0, false),
    ("\"$0\" \"$@\" | true; exit ${PIPESTATUS[0]}", "--help", 0, 0, false),
    (
        "\"$0\" \"$@\" 2>&1 | true; exit ${PIPESTATUS[0]}",
        "solve room.obj --solver cpu --texels 4",
        0,
        0,
        true,
    ),
    (
        "\"$0\" \"$@\" >/dev/full",
        "solve room.obj --dry-run --solver cpu",
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
        "solve room.obj --dry-run --solver cpu",
        0,
        0,
        false,
    ),
];

#[test]
fn closed_and_full_pipes_do_not_end_a_solve() {
    let folder = folder_with_room("pipes");
    for (script, arguments, code, lines, result) in PIPES {
        let _ = fs::remove_dir_all(folder.join("out"));
        let words: Vec<&str> = arguments.split_whitespace().collect();
        let ended = run_in_shell(&folder, script, &words);
        let what = format!("{script}: {}", describe_end(arguments, &ended));
        println!("{what}");
        assert_eq!(ended.code, Some(*code), "{what}");
        assert_eq!(error_lines(&ended).len(), *lines, "{what}");
        assert_clean_end(&folder, &ended, &what);
        assert_eq!(folder.join("out/result.json").exists(), *result, "{what}");
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn control_characters_in_names_are_escaped() {
    let folder = folder_with_room("names");
    let room = ROOM.replace("usemtl lamp", "g lamp\u{1b}[2J\u{7}\nusemtl lamp\u{1b}]0;x");
    write_file(&folder, "\u{1b}[31mred.obj", room);
    write_file(
        &folder,
        "m.mtl",
        MATERIALS.replace("newmtl lamp", "newmtl lamp\u{1b}]0;x"),
    );
    let shoot = [
        "shoot",
        "\u{1b}[31mred.obj",
        "--solver",
        "cpu",
        "--patches",
        "1",
        "--texels",
        "2",
    ];
    let ended = run_program(&folder, &shoot);
    let what = describe_end("names with escapes", &ended);
    println!("{what}");
    assert_eq!(ended.code, Some(0), "{what}");
    assert_clean_end(&folder, &ended, &what);
    let text = fs::read_to_string(folder.join("out/result.json")).unwrap();
    let result: Value = serde_json::from_str(&text).unwrap();
    for name in [&result["scene"], &result["faces"][5]["name"]] {
        let name = name.as_str().unwrap();
        assert!(name.contains("\\u{1b}[") && !name.contains('\u{1b}'), "{name:?}");
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn quiet_prints_errors_only() {
    let folder = folder_with_room("quiet");
    // An input that gives notes of the import and of the adapter.
    let odd = format!("{ROOM}f 1 1 2\nf 1 2 2\nl 1 2\n");
    write_file(&folder, "odd.obj", odd);
    for (arguments, code) in [
        ("solve odd.obj --solver cpu --texels 2", 0),
        ("solve odd.obj --adapter NOSUCH --texels 2", 3),
    ] {
        let words: Vec<&str> = arguments.split_whitespace().collect();
        let ended = run_program(&folder, &words);
        assert!(ended.stderr.contains("note:"), "{}", describe_end(arguments, &ended));
        let ended = run_program(&folder, &[&words[..], &["--quiet"]].concat());
        let what = describe_end(arguments, &ended);
        println!("{what}");
        assert_eq!(ended.code, Some(code), "{what}");
        let lines = ended.stdout.lines().chain(ended.stderr.lines());
        let rest = lines.filter(|line| !line.starts_with("error:"));
        assert_eq!(rest.collect::<Vec<_>>(), [""; 0], "{what}");
    }
    fs::remove_dir_all(folder).unwrap();
}
