//! Writes the rays of one shot by every face, for `peers/embree`:
//! `cargo run --release -p radiosity-benches --example dump_rays -- SCENE --texels 32 --out FILE`.

use clap::Parser;
use common::import::{ImportOptions, load};
use common::mesh::Mesh;
use radiosity_benches::rays::dump;
use std::error::Error;
use std::path::PathBuf;

#[derive(Parser)]
struct Arguments {
    scene: PathBuf,
    /// Texels per side of a face.
    #[arg(long, default_value_t = 32)]
    texels: u32,
    /// Each face shoots as K×K cells.
    #[arg(long, default_value_t = 1)]
    cells: u32,
    #[arg(long, default_value = "target/peers/rays.bin")]
    out: PathBuf,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let scene = load(&arguments.scene, &ImportOptions::default())?;
    let mesh = Mesh::uniform(&scene, arguments.texels, arguments.cells)?;
    let shots: Vec<u32> = (0..mesh.cells.len() as u32).collect();
    if let Some(folder) = arguments.out.parent() {
        std::fs::create_dir_all(folder)?;
    }
    dump(&arguments.out, &mesh, &shots)?;
    println!(
        "{}: {} shooters × {} texels",
        arguments.out.display(),
        shots.len(),
        mesh.texels.len()
    );
    Ok(())
}
