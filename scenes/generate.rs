//! Writes the bundled scenes beside this file: `cargo run -p radiosity-common --example generate_scenes`.

mod model;

use std::path::Path;

fn main() -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    for (name, bytes) in model::scene_files() {
        std::fs::write(folder.join(name), bytes)?;
    }
    Ok(())
}
