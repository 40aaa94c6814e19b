//! The scenes compiled into the program.

use common::Result;
use common::solution::write_files;
use std::path::{Path, PathBuf};

/// Name and text of a scene's two files.
macro_rules! scene {
    ($name:literal) => {
        [
            (
                concat!($name, ".obj"),
                include_str!(concat!("../../scenes/", $name, ".obj")),
            ),
            (
                concat!($name, ".mtl"),
                include_str!(concat!("../../scenes/", $name, ".mtl")),
            ),
        ]
    };
}

const BUNDLED_SCENES: [[(&str, &str); 2]; 7] = [
    scene!("cornell_box"),
    scene!("furnace"),
    scene!("paper_room"),
    scene!("paper_objects"),
    scene!("paper_room_objects"),
    scene!("occluded_plates"),
    scene!("slivers"),
];

/// Returns the path of a bundled scene: `scenes/NAME` in the root of a checkout; elsewhere its files are written
/// to `out`/scenes, where the user can read and change them.
///
/// Errors: the files cannot be written.
pub fn bundled_scene(name: &str, out: &Path) -> Result<PathBuf> {
    let checkout = Path::new("scenes").join(name);
    if checkout.exists() {
        return Ok(checkout);
    }
    let folder = out.join("scenes");
    let files = BUNDLED_SCENES.iter().filter(|[(obj, _), _]| *obj == name).flatten();
    write_files(&folder, files.copied())?;
    Ok(folder.join(name))
}
