//! Reads the output of `radiosity solve` (result.json and lightmap.exr) and prints the light of a texel.
//!
//! `cargo run --release --example read_lightmap [DIR] [FACE] [I] [J]`

use oracle::prelude::*;
use std::f32::consts::PI;
use std::path::Path;

fn main() -> Result<()> {
    let mut words = std::env::args().skip(1);
    let dir = words.next().unwrap_or_else(|| "out".into());
    let mut number = || words.next().and_then(|word| word.parse().ok());
    let numbers = [number(), number(), number()].map(Option::unwrap_or_default);
    println!("{}", describe_texel(Path::new(&dir), numbers)?);
    Ok(())
}

/// Describes the radiosity and radiance of texel i, j of a face of W×H texels.
pub fn describe_texel(dir: &Path, [face, i, j]: [usize; 3]) -> Result<String> {
    let stored = StoredSolution::read(dir)?;
    let none = || Error::Usage(format!("face {face} has no texel {i}, {j}"));
    let [w, h] = *stored.resolutions.get(face).ok_or_else(none)?;
    if i >= w as usize || j >= h as usize {
        return Err(none());
    }
    let name = &stored.scene.faces[face].name;
    let b = stored.radiosity[stored.texel_range(face).start + j * w as usize + i];
    Ok(format!(
        "{name}, texel {i}, {j} of {w}×{h}: B = {b:.4} W/m², L = {:.4} W/m²/sr",
        b / PI
    ))
}
