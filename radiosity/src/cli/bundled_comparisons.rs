//! Comparisons of bundled scenes that together run every shader: each visibility, projection and lookup, one sample and
//! several, form factors, links between nodes, relighting. `compare --all` shows them, and `sabotage` judges mutants by them.

use super::bundled::bundled_scene;
use super::compare::read_comparison;
use common::Result;
use oracle::compare::presets::SceneRequest;
use std::path::Path;

/// Arguments of each, the cheapest first.
pub const COMPARE_ARGUMENTS: [&str; 10] = [
    "occluded_plates.obj --texels 5 --patches 1 --samples 3 --visibility rays",
    "occluded_plates.obj --texels 4 --patches 1 --samples 1 --form-factor disc --iteration southwell --item-buffer 64",
    "occluded_plates.obj --texels 4 --error 5%",
    "occluded_plates.obj --texels 4 --patches 1 --samples 1 --form-factor paper --iteration southwell \
     --visibility paper --item-buffer 64",
    "occluded_plates.obj --texels 5 --patches 2 --samples 4 --visibility hemicube --item-buffer 64",
    "occluded_plates.obj --texels 4 --patches 2 --samples 2 --visibility hemisphere --item-buffer 64 --conserve --two-sided",
    "slivers.obj --texels 12 --patches 1 --samples 2 --visibility rays",
    "cornell_box.obj --texels 5 --patches 5 --samples 2 --visibility rays",
    "cornell_box.obj --texels 2 --error 10%",
    "slivers.obj --texels 4 --error 5%",
];

/// Reads the scenes and the settings.
///
/// Errors: a scene cannot be written to `out`.
pub fn load_comparisons(out: &Path) -> Result<Vec<SceneRequest>> {
    let load = |options: &&'static str| {
        let (name, rest) = options.split_once(' ').unwrap_or((options, ""));
        let scene = bundled_scene(name, out)?;
        let words = rest.split_whitespace().map(Into::into);
        read_comparison([scene.into_os_string()].into_iter().chain(words))
    };
    COMPARE_ARGUMENTS.iter().map(load).collect()
}
