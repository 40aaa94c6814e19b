//! What the matrix takes: n² weights and, in place, their factors, 16 n² bytes.

use common::scene::Scene;
use common::{Error, Result};

/// Memory that the matrix and its factors may take together: 11 585 texels.
pub const MEMORY: u64 = 2 << 30;
/// Bytes of the matrix over `texels` texels and of its factors.
pub fn bytes(texels: u64) -> u64 {
    texels.saturating_mul(texels).saturating_mul(16)
}

/// Refuses a scene whose matrix would not fit, before anything is allocated.
pub fn check(scene: &Scene, side: u32) -> Result<()> {
    let faces = scene.faces.len() as u64;
    let texels = faces * u64::from(side) * u64::from(side);
    if bytes(texels) <= MEMORY {
        return Ok(());
    }
    let all = (MEMORY as f64 / 16.0).sqrt() as u64;
    Err(Error::Usage(format!(
        "{}: the matrix of {texels} texels ({faces} faces × {side}²) needs {:.1} GB, {:.1} GB are allowed ({all} texels)",
        scene.name,
        bytes(texels) as f64 / 1e9,
        MEMORY as f64 / 1e9,
    )))
}

/// Texels a side of as many faces that fit; 0 where none do.
pub fn fitting(faces: u64) -> u64 {
    (MEMORY as f64 / 16.0 / (faces as f64).powi(2)).powf(0.25) as u64
}

/// n² zeros, or an error that says what to do.
pub fn allocate(n: usize) -> Result<Vec<f64>> {
    let mut weights: Vec<f64> = Vec::new();
    let count = n.saturating_mul(n);
    if bytes(n as u64) > MEMORY || weights.try_reserve_exact(count).is_err() {
        return Err(Error::Usage(format!(
            "the matrix of {n} texels needs {:.1} GB, more than this machine has: ask for fewer texels a face",
            bytes(n as u64) as f64 / 1e9
        )));
    }
    weights.resize(count, 0.0);
    Ok(weights)
}
