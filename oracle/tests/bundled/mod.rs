//! The scenes of the repository.

use common::import::{ImportOptions, load};
use common::scene::Scene;
use std::path::Path;

/// Reads one of them.
pub fn bundled(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    load(&folder.join(name), &ImportOptions::default()).unwrap()
}
