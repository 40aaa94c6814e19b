//! Messages for faults of OBJ and MTL files.

use super::files::Folder;
use std::fs;

const SQUARE_VERTICES: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// Returns the error of an OBJ with this text.
fn error(text: impl AsRef<[u8]>) -> String {
    Folder::new().with("a.obj", text).error("a.obj")
}

/// Returns the error of a face whose material has these lines.
fn material_error(lines: &str) -> String {
    let text = format!("mtllib a.mtl\n{SQUARE_VERTICES}usemtl m\nf 1 2 3 4\n");
    Folder::new()
        .with("a.obj", text)
        .with("a.mtl", format!("newmtl m\n{lines}"))
        .error("a.obj")
}

fn assert_begins(error: String, expected: &str) {
    assert!(
        error.starts_with(expected),
        "`{error}` does not begin with `{expected}`"
    );
}

#[test]
fn invalid_geometry_is_refused() {
    let faults = [
        ("", "a.obj: is empty"),
        (" \n\n", "a.obj: is empty"),
        ("# nothing\n", "a.obj: has no faces"),
        ("v 0 0 0\nl 1 1\n", "a.obj: has no faces"),
        ("v 0 0\n", "a.obj: line 1: a vertex needs three numbers"),
        ("\n\nv 0 0 x\n", "a.obj: line 3: a vertex needs three numbers"),
        ("v 1 1 1 0\n", "a.obj: line 1: a vertex has the weight 0"),
        ("v 1 1 1 0 0 0 0\n", "a.obj: line 1: a vertex has too many numbers"),
        (
            "Sg one\nf 1 2 5\ng two\nv 0 0 9\nf 1 2 3\n",
            "a.obj: line 6: a corner of this face is a vertex that does not",
        ),
        (
            "Sf 1 2 3\nf 1 2 -5\n",
            "a.obj: line 6: a corner of this face is a vertex that does not exist",
        ),
        (
            "Sf 0 1 2\n",
            "a.obj: line 5: a corner of this face is a vertex that does not exist",
        ),
        (
            "Sf /1 2 3 4\n",
            "a.obj: line 5: a corner of this face is a vertex that does not exist",
        ),
        (
            "Sf 1 2 99999999999999999999\n",
            "a.obj: line 5: a corner of this face is not the number of a vertex",
        ),
        (
            "Sf 1 2 three\n",
            "a.obj: line 5: a corner of this face is not the number of a vertex",
        ),
        (
            "Sf 1 2 3 4\nf 1 2",
            "a.obj: line 6: the last face has too few corners: is the file cut off?",
        ),
        (
            "Sv nan 0 0\nf 1 2 3\n\nf 1 2 5\n",
            "a.obj: face 2 (line 8): a corner is not a finite number",
        ),
        (
            "Sv 0 inf 0\nf 1 2 5\n",
            "a.obj: face 1 (line 6): a corner is not a finite number",
        ),
        (
            "Sv 0 1e999 0\nf 1 2 5\n",
            "a.obj: face 1 (line 6): a corner is not a finite number",
        ),
        ("Sf 1 1 2\nf 3 3 3 3\n", "a.obj: none of its 2 faces has an area"),
    ];
    for (text, expected) in faults {
        assert_begins(error(text.replacen('S', SQUARE_VERTICES, 1)), expected);
    }
}

#[test]
fn too_many_corners_are_refused() {
    let corners: String = (0..2000).map(|k| format!(" {}", k % 4 + 1)).collect();
    assert_begins(
        error(format!("{SQUARE_VERTICES}f{corners}\n")),
        "a.obj: face 1 (line 5): has 2000 corners",
    );
}

#[test]
fn binary_and_non_utf8_files_are_refused() {
    assert_begins(error(b"v 0 0 0\n# caf\xe9\n"), "a.obj: line 2: is not UTF-8");
    assert_begins(error(b"v 0 0 0\n\x7fELF\0\0\0"), "a.obj: line 2: is binary");
}

#[test]
fn invalid_library_lines_are_refused() {
    assert_begins(
        error("\nmtllib b.mtl\n"),
        "a.obj: line 2: the material file b.mtl cannot be read: there is no such file; put it",
    );
    assert_begins(error("mtllib\n"), "a.obj: line 1: mtllib names no file");
    assert_begins(
        error("mtllib .\n"),
        "a.obj: line 1: the material file . cannot be read: it is a directory",
    );
    assert_begins(error("usemtl\n"), "a.obj: line 1: usemtl names no material");
    assert_begins(
        error("usemtl white\n"),
        "a.obj: line 1: material white is not defined before this line",
    );
    let late = Folder::new()
        .with("a.obj", "usemtl a\nmtllib a.mtl\n")
        .with("a.mtl", "newmtl a\nKd 0.5\n");
    assert_begins(
        late.error("a.obj"),
        "a.obj: line 1: material a is not defined before this line",
    );
    let binary = Folder::new()
        .with("a.obj", "mtllib a.mtl\n")
        .with("a.mtl", "newmtl a\n\0");
    assert_begins(binary.error("a.obj"), "a.mtl: line 2: is binary");
}

#[test]
fn invalid_materials_are_refused() {
    let faults = [
        (
            "Kd 1.1 1 1\n",
            "a.mtl: material m: reflectance Kd 1.1 1 1 must be at least 0 and at most 1",
        ),
        (
            "Kd 0.5 0.5 -0.1\n",
            "a.mtl: material m: reflectance Kd 0.5 0.5 -0.1 must be",
        ),
        ("Kd nan 0 0\n", "a.mtl: material m: reflectance Kd NaN 0 0 must be"),
        ("Ke 0 -1 0\n", "a.mtl: material m: emitted radiance Ke 0 -1 0 must be"),
        ("Ke inf 0 0\n", "a.mtl: material m: emitted radiance Ke inf 0 0 must be"),
        (
            "Kd 0.5\nmap_Kd wood.png\n",
            "a.mtl: material m: map_Kd wood.png cannot be read: there is no such file",
        ),
        (
            "Kd 0.5\nKe 1\nmap_Ke sky.png\n",
            "a.mtl: material m: map_Ke sky.png cannot be read: there is no such file",
        ),
        ("Kd\n", "a.mtl: line 2: Kd needs three numbers"),
        ("\nKe 1 2\n", "a.mtl: line 3: Ke needs three numbers"),
        ("Kd red\n", "a.mtl: line 2: cannot be understood"),
        ("Kd 0.5 0.5 half\n", "a.mtl: line 2: cannot be understood"),
        ("Kd spectral paint.rfl\n", "a.mtl: line 2: Kd needs three numbers"),
        ("Kd xyz 0.5 0.5 0.5\n", "a.mtl: line 2: Kd can only be given as RGB"),
        ("Kd 0.5\nnewmtl\n", "a.mtl: line 3: a material needs a name"),
    ];
    for (lines, expected) in faults {
        assert_begins(material_error(lines), expected);
    }
}

#[test]
fn unreadable_files_are_refused() {
    let folder = Folder::new();
    assert_begins(folder.error("a.obj"), "a.obj: cannot be read: there is no such file");
    fs::create_dir(folder.path("b.obj")).expect("a folder");
    assert_begins(folder.error("b.obj"), "b.obj: cannot be read: it is a directory");
    folder.put("c.txt", "v 0 0 0\n");
    assert_begins(
        folder.error("c.txt"),
        "c.txt: is of no known type: give an .obj, a .gltf or a .glb",
    );
    folder.put("d.glb", "v 0 0 0\n");
    assert_begins(folder.error("d.glb"), "d.glb: does not begin as glTF does");
    #[cfg(unix)]
    if let Err(error) = common::import::load_scene(std::path::Path::new("/dev/zero"), &Default::default()) {
        assert_begins(
            error.to_string(),
            "/dev/zero: cannot be read: it is not an ordinary file",
        );
    }
}
