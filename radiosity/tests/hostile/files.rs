//! Files that never end, and files elsewhere.

use crate::program::room::folder_with_room;
use std::fs::{self, OpenOptions};
use std::os::unix::fs::symlink;
use std::process::Command;
use std::thread::spawn;

/// Pipes, devices, huge files, and files outside the scene's folder in every place where a file is read.
const REFUSED_FILES: &str = "
solve pipe.obj => pipe.obj: cannot be read
solve zero.obj => zero.obj: cannot be read
solve huge.obj => huge.obj: cannot be read
solve library.obj => pipe.obj cannot be read
solve buffer.gltf => pipe.obj cannot be read
solve texture.obj => t.mtl: material m: map_Kd pipe.obj cannot be read
solve pipe.obj --dry-run => pipe.obj: cannot be read
relight --room pipe.obj => pipe.obj: cannot be read
relight --room zero.obj --room-size 1,1,1 => zero.obj: cannot be read
relight --room room.obj --object pipe.obj => pipe.obj: cannot be read
relight --room piped => piped/result.json: cannot be read
relight --room endless => endless/result.json: cannot be read
relight --room walls => walls/000.exr: cannot be read
diff dark endless => dark/lightmap.exr: cannot be read
check piped => piped/result.json: cannot be read
solve below/up.obj => line 1: the material file ../m.mtl cannot be read: only files beside the scene or below it are read
solve below/root.obj => line 1: the material file /etc/passwd cannot be read: only files beside the scene or below it
solve below/around.obj => the material file none/../../m.mtl cannot be read: only files beside
solve below/texture.obj => t.mtl: material m: map_Kd ../../m.mtl cannot be read: only files beside
solve below/texture2.obj => t2.mtl: material m: map_Kd /etc/passwd cannot be read: only files beside
solve below/up.gltf => buffer 0: ../../etc/passwd cannot be read: only files beside
solve below/root.gltf => buffer 0: /etc/passwd cannot be read: only files beside
solve below/far.gltf => buffer 0: is at http://localhost/b: only files beside
merge pipe.obj zero.obj --seconds 1,4 => pipe.obj: cannot be read
merge zero.obj pipe.obj --seconds 1,4 => zero.obj: cannot be read
";

/// A black quad of one texel, as in result.json.
const ONE_QUAD: &str = r#"{"faces":[{"kind":"quad","corners":[[0,0,0],[1,0,0],[1,1,0],[0,1,0]],
    "texels":[1,1],"rect":[0,0,1,1],"file":"000.exr"}]}"#;

#[test]
fn endless_files_and_files_elsewhere_are_refused() {
    let folder = folder_with_room();
    folder.write("library.obj", "mtllib pipe.obj\n");
    folder.write("t.mtl", "newmtl m\nKe 1\nmap_Kd pipe.obj\n");
    let textured = "mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";
    folder.write("texture.obj", textured);
    let buffer = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"pipe.obj","byteLength":4}]}"#;
    folder.write("buffer.gltf", buffer);
    for (name, library) in [
        ("up", "../m.mtl"),
        ("root", "/etc/passwd"),
        ("around", "none/../../m.mtl"),
    ] {
        folder.write(&format!("below/{name}.obj"), format!("mtllib {library}\n"));
    }
    // A texture is named relative to its library.
    for (name, texture) in [("", "../../m.mtl"), ("2", "/etc/passwd")] {
        let library = format!("newmtl m\nKe 1\nmap_Kd {texture}\n");
        folder.write(&format!("below/lib/t{name}.mtl"), library);
        let scene = textured.replace("t.mtl", &format!("lib/t{name}.mtl"));
        folder.write(&format!("below/texture{name}.obj"), scene);
    }
    for (name, uri) in [
        ("up", "..%2f../etc/passwd"),
        ("root", "/etc/passwd"),
        ("far", "http://localhost/b"),
    ] {
        folder.write(&format!("below/{name}.gltf"), buffer.replace("pipe.obj", uri));
    }
    folder.write("dark/result.json", ONE_QUAD);
    folder.write("walls/room.json", ONE_QUAD);
    for dir in ["piped", "endless"] {
        fs::create_dir(folder.path(dir)).unwrap();
    }
    for name in ["pipe.obj", "piped/result.json", "dark/lightmap.exr", "walls/000.exr"] {
        let path = folder.path(name);
        assert!(Command::new("mkfifo").arg(&path).status().unwrap().success(), "{name}");
        // Whoever reads the pipe finds it empty, instead of waiting for ever.
        spawn(move || while OpenOptions::new().write(true).open(&path).is_ok() {});
    }
    symlink("/dev/zero", folder.path("zero.obj")).unwrap();
    symlink("/dev/zero", folder.path("endless/result.json")).unwrap();
    let huge = fs::File::create(folder.path("huge.obj")).unwrap();
    huge.set_len(1 << 42).unwrap();
    folder.assert_refused(REFUSED_FILES);
}
