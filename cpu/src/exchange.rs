//! What cells give each other. Twin of `gpu/src/shaders/exchange.wgsl`.

use glam::Vec3;

/// The flux that a cell receives when each cell i shoots the radiosity `shot[i]`, of which it takes
/// `taken(i)`: Σ w·A over its texels.
pub fn exchange(shot: &[Vec3], taken: impl Fn(usize) -> f32) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for (i, x) in shot.iter().enumerate() {
        if *x != Vec3::ZERO {
            sum += *x * taken(i);
        }
    }
    sum
}
