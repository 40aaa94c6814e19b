//! What all cells receive from a shot. Twin of `gpu/src/shaders/closure.wgsl`.

use common::constants::SELECT_LANES;
use common::reduce::tree_sum;

/// ΣF of a shooter of this `area`: what the cells take, over what it gives.
pub fn closure(received: &[f32], area: f32) -> f32 {
    let sum = tree_sum::<_, SELECT_LANES>(0.0, received.len(), |k| received[k]);
    if area > 0.0 { sum / area } else { 0.0 }
}
