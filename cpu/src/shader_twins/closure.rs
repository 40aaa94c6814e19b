//! Closure of a shot's links: ΣF, and the factor that scales the links ([`PatchClosure::link_scale`]).

pub use common::passes::PatchClosure;

use common::constants::SELECT_LANES;
use common::reduce::tree_sum;

/// Returns ΣF of a shooter of this `area`: the sum of its transfers over its area.
pub fn sum_form_factors(received: &[f32], area: f32) -> f32 {
    let sum = tree_sum::<_, SELECT_LANES>(0.0, received.len(), |k| received[k]);
    if area > 0.0 { sum / area } else { 0.0 }
}
