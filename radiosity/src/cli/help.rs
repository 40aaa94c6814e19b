//! `--help`: the options that it leaves out, and the text below them: examples and exit codes.

use super::options::is_shooting_option;

const EXIT_CODES: &str = "\
Exit codes: 0 done, in agreement; 1 the solvers disagree, a tolerance or a gate is broken, or a
warning under --strict; 2 bad usage or input; 3 a GPU was required and none was found; 4 a result
could not be written; 130 Ctrl-C before anything could be written";

const SOLVE_EXAMPLES: &str = "\
EXAMPLES:
  radiosity solve room.obj                              to 1 %: view.html, lightmap.exr, … in out/
  radiosity solve room.glb --error 0.5% --texels 32     a lightmap of 32×32 texels a face
  radiosity solve room.obj --gltf baked.glb             the scene with its light, for other programs
  radiosity solve room.glb --gltf baked.glb --uv keep   the same, on the scene's own charts (TEXCOORD_1)
  radiosity solve room.obj --quality draft --json | jq .estimated_error
  radiosity solve room.glb --dry-run                    texels, memory and time, nothing solved
  radiosity solve room.obj --settings out/result.json   with the settings of that result";

const SHOOT_EXAMPLES: &str = "\
EXAMPLES:
  radiosity shoot room.obj --patches 1 --samples 1 --form-factor disc --iteration southwell    the paper's way
  radiosity shoot room.obj --solver gpu --visibility hemicube --item-buffer 512
  radiosity shoot room.obj --iteration southwell --max-shots 50";

const RELIGHT_EXAMPLES: &str = "\
EXAMPLES:
  radiosity relight --room room.obj --object chair.obj
  radiosity relight --room room.hdr --room-size 5,3,6 --object bunny.obj --scale 0.1 --place 0,0,1";

const COMPARE_EXAMPLES: &str = "\
EXAMPLES:
  radiosity compare scenes/cornell_box.obj
  radiosity compare room.obj --texels 32 --patches 4 --samples 1 --visibility hemicube
  radiosity compare room.obj --error 0.5%";

const DIFF_EXAMPLES: &str = "\
EXAMPLES:
  radiosity diff out/draft out/reference
  radiosity diff mine truth --tolerance 1% --json | jq .relative_rms";

const CHECK_EXAMPLES: &str = "\
EXAMPLES:
  radiosity check out
  radiosity check baked --scene room.obj --tolerance 2%    another program's lightmap";

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

/// Options that commands accept but do not list: few users need them, and a shorter list is read. GUIDE.md has them.
const UNLISTED_OPTIONS: [(&str, &[&str]); 10] = [
    ("solve", &["join-quads"]),
    (
        "shoot",
        &[
            "allow-dark",
            "gltf",
            "join-quads",
            "maps",
            "quality",
            "reflectance",
            "require-gpu",
            "settings",
            "strict",
            "uv",
        ],
    ),
    (
        "compare",
        &[
            "conserve",
            "iteration",
            "join-quads",
            "lookup",
            "max-shots",
            "quality",
            "raster",
            "reflectance",
            "require-gpu",
            "two-sided",
        ],
    ),
    (
        "relight",
        &[
            "curve",
            "join-quads",
            "object-texels",
            "quality",
            "require-gpu",
            "strict",
            "two-sided",
        ],
    ),
    ("merge", &["column"]),
    ("table4", &["composite"]),
    ("check", &["reflectance"]),
    (
        "chart",
        &[
            "join-quads",
            "limit",
            "peers",
            "reflectance",
            "repeats",
            "require-gpu",
            "two-sided",
        ],
    ),
    ("stress", &["adapter", "faces", "kind", "quality", "texels"]),
    ("adapters", &["json"]),
];

/// Returns true for an option that `command` accepts but does not list; `solve` and `relight` list none of shooting.
pub fn is_unlisted(command: &str, arg: &clap::Arg) -> bool {
    let Some(option) = arg.get_long() else {
        return false;
    };
    let unlisted = |(name, options): &(&str, &[&str])| *name == command && options.contains(&option);
    let shooting = matches!(command, "solve" | "relight") && is_shooting_option(arg.get_id().as_str());
    shooting || UNLISTED_OPTIONS.iter().any(unlisted)
}
