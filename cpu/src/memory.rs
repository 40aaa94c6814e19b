//! Memory of a shooting solve on the host, computed before anything is allocated.

use crate::rows::texel_link::Sums;
use common::constants::MAX_LINK_BYTES;
use common::settings::Iteration;
use glam::{Vec3, Vec4};

/// Returns the bytes of the link cache and of the exchange matrix, if this iteration uses one.
pub fn link_bytes(patches: u64, texels: u64, iteration: Iteration) -> u64 {
    let row = 4 * texels.max(1);
    let slots = (MAX_LINK_BYTES / row).clamp(1, patches.max(1));
    let matrix = patches.saturating_mul(patches).saturating_mul(4);
    let exchanges = iteration != Iteration::Southwell && matrix <= MAX_LINK_BYTES;
    slots
        .saturating_mul(row)
        .saturating_add(if exchanges { matrix } else { 0 })
}

/// Returns the bytes of the texels' state: B, r and H twice (state and result), ρ, and the sums of one shooter.
pub fn state_bytes(texels: u64) -> u64 {
    let each = 2 * 3 * size_of::<Vec4>() + size_of::<Vec3>() + size_of::<Sums>();
    // The texels' coordinates once more, as arrays.
    texels.saturating_mul((each + 2 * size_of::<Vec4>()) as u64)
}
