//! The text below the options in `--help`: examples and exit codes.

const EXIT_CODES: &str = "\
Exit codes: 0 done, in agreement; 1 the solvers disagree, or a tolerance or a gate is broken; 2 bad
usage or input; 3 a GPU was required and none was found; 4 a result could not be written; 130 Ctrl-C
before anything could be written";

const SOLVE_EXAMPLES: &str = "\
EXAMPLES:
  radiosity solve room.obj                              to 1 %: view.html, lightmap.exr, … in out/
  radiosity solve room.glb --error 0.5% --texels 32     a lightmap of 32×32 texels a face
  radiosity solve room.obj --gltf baked.glb             the scene with its light, for other programs
  radiosity solve room.glb --gltf baked.glb --uv keep   the same, on the scene's own charts (TEXCOORD_1)
  radiosity solve model.glb --sky 1 --sun 1,2,1,3       a model without lamps, outdoors
  radiosity solve room.obj --quality draft --json | jq .estimated_error
  radiosity solve room.obj --trace                      trace.html: the links of any texel, step by step
  radiosity solve room.glb --dry-run                    texels, memory and time, nothing solved";

const SHOOT_EXAMPLES: &str = "\
EXAMPLES:
  radiosity shoot room.obj --patches 1 --samples 1 --form-factor disc --iteration southwell    the paper's way
  radiosity shoot room.obj --solver gpu --visibility hemicube --item-buffer 512
  radiosity shoot room.obj --iteration southwell --max-shots 50
  radiosity shoot room.obj --trace                      trace.html: the solve shot by shot";

const RELIGHT_EXAMPLES: &str = "\
EXAMPLES:
  radiosity relight --room room.obj --object chair.obj
  radiosity relight --room room.hdr --room-size 5,3,6 --object bunny.obj --scale 0.1 --turn 30";

const COMPARE_EXAMPLES: &str = "\
EXAMPLES:
  radiosity compare scenes/cornell_box.obj
  radiosity compare room.obj --texels 32 --patches 4 --samples 1 --visibility hemicube
  radiosity compare room.obj --error 0.5%
  radiosity compare room.obj --shader deposit=mine.wgsl    yours; start from `radiosity shader deposit`";

const DIFF_EXAMPLES: &str = "\
EXAMPLES:
  radiosity diff out/draft out/reference
  radiosity diff mine truth --tolerance 1%             exit code 1 beyond it";

const CHECK_EXAMPLES: &str = "\
EXAMPLES:
  radiosity check out
  radiosity check baked room.obj --tolerance 2%    another program's lightmap";

/// Returns the text below the options of `command`; an empty name is the program itself.
pub fn help_footer(command: &str) -> String {
    let examples = match command {
        "solve" => SOLVE_EXAMPLES,
        "shoot" => SHOOT_EXAMPLES,
        "relight" => RELIGHT_EXAMPLES,
        "compare" => COMPARE_EXAMPLES,
        "diff" => DIFF_EXAMPLES,
        "check" => CHECK_EXAMPLES,
        _ => return EXIT_CODES.into(),
    };
    format!("{examples}\n\n{EXIT_CODES}")
}
