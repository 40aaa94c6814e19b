//! Files that never end.

use crate::program::room::folder_with_room;
use std::fs::{self, OpenOptions};
use std::os::unix::fs::symlink;
use std::process::Command;
use std::thread::spawn;

/// Pipes, devices and huge files in every place where a file is read.
const ENDLESS: &str = "
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
merge pipe.obj zero.obj --seconds 1,4 => pipe.obj: cannot be read
merge zero.obj pipe.obj --seconds 1,4 => zero.obj: cannot be read
";

/// A black quad of one texel, as in result.json.
const ONE_QUAD: &str = r#"{"faces":[{"kind":"quad","corners":[[0,0,0],[1,0,0],[1,1,0],[0,1,0]],
    "texels":[1,1],"rect":[0,0,1,1],"file":"000.exr"}]}"#;

#[test]
fn endless_files_are_refused() {
    let folder = folder_with_room();
    folder.write("library.obj", "mtllib pipe.obj\n");
    folder.write("t.mtl", "newmtl m\nKe 1\nmap_Kd pipe.obj\n");
    let textured = "mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";
    folder.write("texture.obj", textured);
    let buffer = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"pipe.obj","byteLength":4}]}"#;
    folder.write("buffer.gltf", buffer);
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
    folder.assert_refused(ENDLESS);
}
