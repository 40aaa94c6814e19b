//! Messages for faults of OBJ and MTL files.

use super::files::{Folder, assert_begins, text_lines};
use std::fs;

/// Lines of an OBJ, and the beginning of the message.
const OBJ_FAULTS: &str = "
 => is empty
 ;; => is empty
# nothing; => has no faces
v 0 0 0; l 1 1; => has no faces
v 0 0; => line 1: a vertex needs three numbers
;;v 0 0 x; => line 3: a vertex needs three numbers
v 1 1 1 0; => line 1: a vertex has the weight 0
v 1 1 1 0 0 0 0; => line 1: a vertex has too many numbers
S g one; f 1 2 6; g two; v 0 0 9; f 1 2 3; => line 6: a corner of this face is a vertex that does not
S f 1 2 3; f 1 2 -5; => line 6: a corner of this face is a vertex that does not exist
S f 0 1 2; => line 5: a corner of this face is a vertex that does not exist
S f /1 2 3 4; => line 5: a corner of this face is a vertex that does not exist
S f 1 2 99999999999999999999; => line 5: a corner of this face is not the number of a vertex
S f 1 2 three; => line 5: a corner of this face is not the number of a vertex
S f 1 2 3 4; f 1 2 => line 6: the last face has too few corners: is the file cut off?
S v nan 0 0; f 1 2 3;; f 1 2 5; => face 2 (line 8): a corner is not a finite number
S v 0 inf 0; f 1 2 5; => face 1 (line 6): a corner is not a finite number
S v 0 1e999 0; f 1 2 5; => face 1 (line 6): a corner is not a finite number
S f 1 1 2; f 3 3 3 3; => none of its 2 faces has an area
;mtllib b.mtl; => line 2: the material file b.mtl cannot be read: there is no such file; put it
mtllib; => line 1: mtllib names no file
mtllib .; => line 1: the material file . cannot be read: it is a directory
usemtl; => line 1: usemtl names no material
usemtl white; => line 1: material white is not defined before this line
usemtl m; mtllib a.mtl; => line 1: material m is not defined before this line
v 0 0 0; \x7fELF\0\0\0 => line 2: is binary
";

#[test]
fn invalid_obj_lines_are_refused() {
    let folder = Folder::new().with("a.mtl", "newmtl m\nKd 0.5\n");
    for (text, expected) in OBJ_FAULTS.lines().filter_map(|row| row.split_once(" => ")) {
        folder.put("a.obj", text_lines(text));
        assert_begins(&folder.error("a.obj"), &format!("a.obj: {expected}"));
    }
    let corners: String = (0..2000).map(|k| format!(" {}", k % 4 + 1)).collect();
    folder.put("a.obj", text_lines(&format!("S f{corners};")));
    assert_begins(&folder.error("a.obj"), "a.obj: face 1 (line 5): has 2000 corners");
    folder.put("a.obj", b"v 0 0 0\n# caf\xe9\n");
    assert_begins(&folder.error("a.obj"), "a.obj: line 2: is not UTF-8");
}

/// Lines of a material `m`, and the beginning of the message.
const MTL_FAULTS: &str = "
Kd 1.1 1 1; => material m: reflectance Kd 1.1 1 1 must be at least 0 and at most 1
Kd 0.5 0.5 -0.1; => material m: reflectance Kd 0.5 0.5 -0.1 must be
Kd nan 0 0; => material m: reflectance Kd NaN 0 0 must be
Ke 0 -1 0; => material m: emitted radiance Ke 0 -1 0 must be
Ke inf 0 0; => material m: emitted radiance Ke inf 0 0 must be
Kd 0.5; map_Kd wood.png; => material m: map_Kd wood.png cannot be read: there is no such file
Kd 0.5; Ke 1; map_Ke sky.png; => material m: map_Ke sky.png cannot be read: there is no such file
map_Kd; => material m: map_Kd names no file
map_Kd -clamp on; => material m: map_Kd names no file
map_Kd -s; => material m: map_Kd has an option -s without numbers
map_Ke -o x a.png; => material m: map_Ke has an option -o without numbers
map_Kd -mm 0 1 a.png; => material m: map_Kd has the option -mm, which is not supported
Kd; => line 2: Kd needs three numbers
;Ke 1 2; => line 3: Ke needs three numbers
Kd red; => line 2: cannot be understood
Kd 0.5 0.5 half; => line 2: cannot be understood
Kd spectral paint.rfl; => line 2: Kd needs three numbers
Kd xyz 0.5 0.5 0.5; => line 2: Kd can only be given as RGB
Kd 0.5; newmtl; => line 3: a material needs a name
\0 => line 2: is binary
";

#[test]
fn invalid_materials_are_refused() {
    let folder = Folder::new().with("a.obj", text_lines("mtllib a.mtl; S usemtl m; f 1 2 3 4;"));
    for (text, expected) in MTL_FAULTS.lines().filter_map(|row| row.split_once(" => ")) {
        folder.put("a.mtl", format!("newmtl m\n{}", text_lines(text)));
        assert_begins(&folder.error("a.obj"), &format!("a.mtl: {expected}"));
    }
}

#[test]
fn unreadable_files_are_refused() {
    let folder = Folder::new().with("c.txt", "v 0 0 0\n").with("d.glb", "v 0 0 0\n");
    fs::create_dir(folder.path("b.obj")).expect("a folder");
    for (name, expected) in [
        ("a.obj", "cannot be read: there is no such file"),
        ("b.obj", "cannot be read: it is a directory"),
        ("c.txt", "is of no known type: give an .obj, a .gltf or a .glb"),
        ("d.glb", "does not begin as glTF does"),
        #[cfg(unix)]
        ("/dev/zero", "cannot be read: it is not an ordinary file"),
    ] {
        assert_begins(&folder.error(name), &format!("{name}: {expected}"));
    }
}
