//! Writes the rays of one shot per face, for `peers/embree`:
//! `cargo run --release -p radiosity-benches --example dump_rays -- SCENE --texels 32 --out FILE`.

use clap::Parser;
use common::import::{ImportOptions, load_scene};
use common::mesh::Mesh;
use radiosity_benches::rays::dump_rays;
use std::error::Error;
use std::path::PathBuf;

#[derive(Parser)]
struct Arguments {
    scene: PathBuf,
    /// Texels per side of a face.
    #[arg(long, default_value_t = 32)]
    texels: u32,
    /// Each face shoots as K×K patches.
    #[arg(long, default_value_t = 1)]
    cells: u32,
    #[arg(long, default_value = "target/peers/rays.bin")]
    out: PathBuf,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let scene = load_scene(&arguments.scene, &ImportOptions::default())?;
    let mesh = Mesh::uniform(&scene, arguments.texels, arguments.cells)?;
    let shots: Vec<u32> = (0..mesh.patches.len() as u32).collect();
    if let Some(folder) = arguments.out.parent() {
        std::fs::create_dir_all(folder)?;
    }
    dump_rays(&arguments.out, &mesh, &shots)?;
    println!(
        "{}: {} shooters × {} texels",
        arguments.out.display(),
        shots.len(),
        mesh.texels.len()
    );
    Ok(())
}
