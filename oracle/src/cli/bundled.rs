//! The scenes that come with the program.

use common::Result;
use common::solution::pending::Pending;
use common::solution::prepare;
use std::path::{Path, PathBuf};

/// A scene's files: its name, and what is in them.
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

const SCENES: [[(&str, &str); 2]; 5] = [
    scene!("cornell_box"),
    scene!("furnace"),
    scene!("paper_room"),
    scene!("paper_objects"),
    scene!("paper_room_objects"),
];

/// A scene of ours: from the root of a checkout by its short name; anywhere else its files are written into
/// `out`/scenes, to be looked at and changed.
///
/// Errors: they cannot be written.
pub fn bundled(name: &str, out: &Path) -> Result<PathBuf> {
    let folder = out.join("scenes");
    if let [checkout, _] = places(name, out)
        && checkout.exists()
    {
        return Ok(checkout);
    }
    prepare(&folder)?;
    let mut files = Pending::default();
    for (file, text) in SCENES.iter().filter(|[(obj, _), _]| *obj == name).flatten() {
        files.add(&folder.join(file), text.as_bytes())?;
    }
    files.finish()?;
    Ok(folder.join(name))
}

/// Where it lies, if it does.
pub fn found(name: &str, out: &Path) -> Option<PathBuf> {
    places(name, out).into_iter().find(|path| path.exists())
}

fn places(name: &str, out: &Path) -> [PathBuf; 2] {
    [
        Path::new("scenes").join(name),
        out.join("scenes").join(name),
    ]
}
