//! Contradicting options, options that do not apply, and invalid values.

use super::room::{MATERIALS, ROOM, folder_with_room};

const REFUSED: &str = "
solve => the following required arguments were not provided: <SCENE>
shoot => the following required arguments were not provided: <SCENE>
nonsense => nonsense
diff only-one => B
solve room.obj -x => unexpected argument '-x' found (see
solve room.obj --texels 8192 --solver cpu --nonsense => --nonsense
completions cobol => cobol
solve room.obj --quality best => best
solve room.obj --texels -1 => -1 is not in 1..=8192 (see
solve room.obj --texels 0 => 0 is not in 1..=8192 (see
shoot room.obj --epsilon -1 => -1 is not in 0 < X ≤ 1 (see
shoot room.obj --epsilon 0 => 0 is not in 0 < X ≤ 1 (see
shoot room.obj --epsilon nan => nan
shoot room.obj --max-shots -1 => -1 is not in 0..=4294967295 (see
relight --room room.obj --reflectance .5,.5 => give 3 numbers separated by commas
relight --room room.obj --reflectance 1,1,1 => 1,1,1 is not in 0 ≤ ρ < 1 (see
solve room.obj --gltf a.obj => a.obj
solve room.obj --uv keep => --gltf
converge nowhere.obj => nowhere.obj
solve room.obj --solver cpu --adapter any => --adapter contradicts
solve room.obj --dry-run --solver cpu --adapter any => --adapter contradicts
chart room.obj --solver cpu --adapter any => --adapter contradicts
chart room.obj --quality reference => reference
chart room.obj --solver dense => dense
chart room.obj --texels 0 => 0 is not in 1..=256 (see
chart nowhere/at/all.obj => nowhere/at/all.obj: cannot be read
chart room.obj --vary nonsense => nonsense
chart room.obj --vary patches --texels 8 => --texels
solve room.obj --solver cpu --require-gpu => --require-gpu
shoot room.obj --solver cpu --item-buffer 512 => --item-buffer applies to item buffers
shoot room.obj --solver gpu --visibility rays --item-buffer 64 => --item-buffer
compare room.obj --visibility rays --item-buffer 64 => --item-buffer applies to item buffers
compare room.obj --error 1% --patches 2 => --patches
relight --room room.obj --solver cpu --item-buffer 512 => --item-buffer
shoot room.obj --error 1% => --error
shoot room.obj --trace --iteration cg => give --iteration southwell
shoot room.obj --trace --iteration chebyshev => give --iteration southwell
shoot room.obj --trace --conserve => --trace does not go with --conserve
shoot room.obj --trace --solver cpu --texels 4096 => give fewer --texels
solve room.obj --solver dense --texels 2 --trace => --trace shows links
compare room.obj --trace => --trace
shoot room.obj --solver dense => dense
shoot room.obj --solver matrix => matrix
solve room.obj --error 1% --quality normal => --quality
solve room.obj --error 1% --patches 4 => --patches is an option of `radiosity shoot`
solve room.obj --error=1% --conserve => --conserve is an option of `radiosity shoot`
plan room.obj --error 1% --cells 4 => --patches is an option of `radiosity shoot`
solve room.obj --error 1% --solver dense => --solver
solve room.obj --error 1% --adapter any => --adapter
solve room.obj --error 1% --require-gpu => --require-gpu
solve room.obj --error 1% --texels 8192 => would fit
solve room.obj --error 0 => --error
solve room.obj --error -1 => --error
solve room.obj --error 0.1% => --error
solve room.obj --error 11% => --error
solve room.obj --error nan => --error
solve room.obj --error one => --error
solve room.obj --solver dense --max-shots 9 => --max-shots is an option of `radiosity shoot`
solve room.obj --solver dense --adapter any => --adapter
solve room.obj --solver dense --require-gpu => --require-gpu
solve room.obj --solver dense --texels 82 => room.obj: 40344 texels take 26.0 GB, 2.1 GB are allowed for the matrix
solve room.obj --solver dense --texels 82 => --texels 43 would fit, or use --solver cpu
relight --room room.obj --scale 2 --object cube.obj => --scale
relight --room room.obj --turn 90 --object cube.obj => --turn before the first --object is for panoramas only
relight --room room.obj --object cube.obj --turn right => right is not a number of degrees
solve room.obj --lamp 0.5,0.5,0.5 => 0.5,0.5,0.5: give 4 numbers
solve room.obj --lamp 0.5,0.5,0.5,-1 => a lamp's power must be above 0
solve room.obj --lamp 0.5,0.5,0.5,1e30 => --lamp 0.5,0.5,0.5,1000000000000000000000000000000: lamp 1 emits
solve room.obj --sky -1 => --sky -1: its radiance must be
solve room.obj --sky nowhere.hdr => nowhere.hdr: cannot be read
solve room.obj --sun 0,0,0,1 => the sun needs a direction
solve room.obj --sun 0,1,0,0 => its irradiance must be
relight --room room.obj --object cube.obj --place 1,2 => 1,2
relight --room room.obj --object cube.obj --reflectance 1,1,1 => 1,1,1
relight --room room.obj --object cube.obj --conserve => --conserve
relight --room room.obj --object cube.obj --solver dense => --solver
relight --room room.obj --object cube.obj --camera 0,0,0,0,0,0,50 => camera
relight --room room.obj --object nowhere.obj => nowhere.obj
relight --room nowhere.hdr --object cube.obj => nowhere.hdr
relight --room cut.hdr --object cube.obj => --room-size
relight --room cut.hdr --room-size 1,1,1 --object cube.obj => cut.hdr
relight --room cut.hdr --room-size 1,0,1 --object cube.obj => --room-size
relight --room room.obj --room-size 1,1,1 --object cube.obj => room.obj
solve nowhere/at/all.obj => nowhere/at/all.obj: cannot be read
solve empty.obj => empty.obj: is empty
solve dim.obj => dim.mtl: material wall: reflectance Kd -0.5 0.5 0.5 must be
";

#[test]
fn options_and_files_are_refused_by_name() {
    let folder = folder_with_room();
    folder.write("cut.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n");
    folder.write("empty.obj", "");
    folder.write("dim.obj", ROOM.obj_text().replace("m.mtl", "dim.mtl"));
    folder.write("dim.mtl", MATERIALS.replace(".6 .5 .4", "-.5 .5 .5"));
    folder.assert_refused(REFUSED);
}

#[test]
fn missing_adapter_is_code_3_and_unwritable_folder_code_4() {
    let folder = folder_with_room();
    let missing = "no adapter is called \"NOSUCH\"";
    folder.fail_with(3, "solve room.obj --texels 2 --adapter NOSUCH", missing);
    folder.fail_with(3, "solve room.obj --dry-run --adapter NOSUCH", missing);
    folder.fail_with(3, "chart room.obj --adapter NOSUCH", missing);
    folder.write("file", "");
    folder.fail_with(4, "solve room.obj --solver cpu --out file/out", "file");
}
