//! What stands below the options in `--help`: examples, and the exit codes.

const EXIT_CODES: &str = "\
Exit codes: 0 done, in agreement; 1 the solvers disagree, a tolerance or a gate is broken, or a
warning under --strict; 2 bad usage or input; 3 a GPU was required and none was found; 4 a result
could not be written; 130 Ctrl-C before there was anything to write";

const SOLVE: &str = "\
EXAMPLES:
  radiosity solve room.obj                              to 1 %: view.html, lightmap.exr, … in out/
  radiosity solve room.glb --error 0.5% --texels 32     a lightmap of 32×32 texels a face
  radiosity solve room.obj --gltf baked.glb             the scene with its light, for other programs
  radiosity solve room.glb --gltf baked.glb --uv keep   the same on its own lightmap's charts (TEXCOORD_1)
  radiosity solve room.obj --quality draft --json | jq .estimated_error
  radiosity solve room.obj --settings out/result.json   as that result was solved";

const RELIGHT: &str = "\
EXAMPLES:
  radiosity relight --room room.obj --object chair.obj
  radiosity relight --room room.hdr --room-size 5,3,6 --object bunny.obj --scale 0.1 --place 0,0,1";

const COMPARE: &str = "\
EXAMPLES:
  radiosity compare scenes/cornell_box.obj
  radiosity compare room.obj --texels 32 --cells 4 --samples 1 --visibility hemicube
  radiosity compare room.obj --error 0.5%";

const DIFF: &str = "\
EXAMPLES:
  radiosity diff out/draft out/reference
  radiosity diff mine truth --tolerance 1% --json | jq .relative_rms";

const CHECK: &str = "\
EXAMPLES:
  radiosity check out
  radiosity check baked --scene room.obj --tolerance 2%    another program's lightmap";

/// Below the options of a command; of the program itself where the name is empty.
pub fn below(command: &str) -> String {
    let examples = match command {
        "solve" => SOLVE,
        "relight" => RELIGHT,
        "compare" => COMPARE,
        "diff" => DIFF,
        "check" => CHECK,
        _ => return EXIT_CODES.into(),
    };
    format!("{examples}\n\n{EXIT_CODES}")
}
