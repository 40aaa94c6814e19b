//! Contradicting options and invalid values.

use super::kit::{Row, assert_rows, row};
use super::room::folder_with_room;
use std::fs;

const OPTIONS: &[Row] = &[
    row(
        "solve room.obj --texels 2 --adapter NOSUCH --out out",
        3,
        "no adapter is called \"NOSUCH\"",
    ),
    row(
        "solve room.obj --dry-run --adapter NOSUCH --out out",
        3,
        "no adapter is called \"NOSUCH\"",
    ),
    row(
        "solve room.obj --solver cpu --adapter any --out out",
        2,
        "--adapter contradicts",
    ),
    row(
        "solve room.obj --dry-run --solver cpu --adapter any --out out",
        2,
        "--adapter contradicts",
    ),
    row(
        "chart room.obj --solver cpu --adapter any --out out",
        2,
        "--adapter contradicts",
    ),
    row(
        "shoot room.obj --solver cpu --item-buffer 512 --out out",
        2,
        "--item-buffer applies to item buffers",
    ),
    row(
        "shoot room.obj --solver cpu --raster pixel --out out",
        2,
        "--raster applies to item buffers",
    ),
    row(
        "shoot room.obj --solver cpu --lookup 3x3 --out out",
        2,
        "--lookup applies to item buffers",
    ),
    row(
        "shoot room.obj --solver gpu --visibility rays --lookup exact --out out",
        2,
        "--lookup",
    ),
    row(
        "shoot room.obj --solver gpu --visibility rays --item-buffer 64 --out out",
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
        "shoot room.obj --dry-run --solver cpu --raster tessellated --out out",
        2,
        "--raster applies to item buffers",
    ),
    row(
        "compare room.obj --visibility rays --lookup exact --out out",
        2,
        "--lookup",
    ),
    row(
        "shoot room.obj --solver cpu --texels 2 --visibility hemicube --item-buffer 64 --lookup exact --out out",
        0,
        "wrote",
    ),
    row("solve room.obj --texels -1 --out out", 2, "-1 is not in 1..=8192 (see"),
    row(
        "shoot room.obj --epsilon -1 --out out",
        2,
        "-1 is not in 0 < X ≤ 1 (see",
    ),
    row(
        "shoot room.obj --max-shots -1 --out out",
        2,
        "-1 is not in 0..=4294967295 (see",
    ),
    row("solve room.obj -x --out out", 2, "unexpected argument '-x' found (see"),
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
    row("solve room.obj --bad\u{1b}[31m --out out", 2, "unexpected argument"),
];

#[test]
fn inapplicable_options_are_refused() {
    let folder = folder_with_room("options");
    assert_rows(&folder, OPTIONS);
    fs::remove_dir_all(folder).unwrap();
}
