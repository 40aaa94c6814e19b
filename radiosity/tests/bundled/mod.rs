//! The scenes of the repository.

use common::import::{ImportOptions, load_scene};
use common::scene::Scene;
use std::path::Path;

/// Reads a scene of the folder scenes/.
pub fn bundled_scene(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    load_scene(&folder.join(name), &ImportOptions::default()).unwrap()
}
