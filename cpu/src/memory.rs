//! What a solve takes on the host, before anything is allocated.

use crate::twin::link::Sums;
use common::constants::LINK_BYTES;
use common::settings::Iteration;
use glam::{Vec3, Vec4};

/// Bytes of the links that are kept, and of what cells exchange by this iteration.
pub fn links(cells: u64, texels: u64, iteration: Iteration) -> u64 {
    let row = 4 * texels.max(1);
    let places = (LINK_BYTES / row).clamp(1, cells.max(1));
    let matrix = cells.saturating_mul(cells).saturating_mul(4);
    let exchanges = iteration != Iteration::Southwell && matrix <= LINK_BYTES;
    places
        .saturating_mul(row)
        .saturating_add(if exchanges { matrix } else { 0 })
}

/// Bytes of the texels' state: B, r and H, a second time in the answer, ρ, and what is summed for
/// one shooter or in the end.
pub fn state(texels: u64) -> u64 {
    let each = 2 * 3 * size_of::<Vec4>() + size_of::<Vec3>() + size_of::<Sums>();
    // And the texels' coordinates once more, as arrays.
    texels.saturating_mul((each + 2 * size_of::<Vec4>()) as u64)
}
