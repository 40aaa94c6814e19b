//! Memory of the dense matrix: n² weights and their factors in f64, 16 n² bytes. A dense solve that does not fit is
//! refused by it before anything is allocated.

use common::scene::Scene;
use common::{Error, Result};

/// Largest memory of the matrix and its factors together: 11 585 texels.
pub const MAX_MATRIX_BYTES: u64 = 2 << 30;
/// Returns the bytes of the matrix over `texels` texels and of its factors.
pub fn matrix_bytes(texels: u64) -> u64 {
    texels.saturating_mul(texels).saturating_mul(16)
}

/// Checks that the matrix of `scene` fits, before anything is allocated.
///
/// Errors: it does not.
pub fn check_memory(scene: &Scene, side: u32) -> Result<()> {
    let faces = scene.faces.len() as u64;
    let texels = faces * u64::from(side) * u64::from(side);
    if matrix_bytes(texels) <= MAX_MATRIX_BYTES {
        return Ok(());
    }
    let all = (MAX_MATRIX_BYTES as f64 / 16.0).sqrt() as u64;
    Err(Error::Usage(format!(
        "{}: the matrix of {texels} texels ({faces} faces × {side}²) needs {:.1} GB, {:.1} GB are allowed ({all} texels)",
        scene.name,
        matrix_bytes(texels) as f64 / 1e9,
        MAX_MATRIX_BYTES as f64 / 1e9,
    )))
}

/// Allocates n² zeros.
///
/// Errors: they do not fit.
pub fn allocate_weights(n: usize) -> Result<Vec<f64>> {
    let mut weights: Vec<f64> = Vec::new();
    let count = n.saturating_mul(n);
    if matrix_bytes(n as u64) > MAX_MATRIX_BYTES || weights.try_reserve_exact(count).is_err() {
        return Err(Error::Usage(format!(
            "the matrix of {n} texels needs {:.1} GB, more than this machine has: ask for fewer texels a face",
            matrix_bytes(n as u64) as f64 / 1e9
        )));
    }
    weights.resize(count, 0.0);
    Ok(weights)
}
