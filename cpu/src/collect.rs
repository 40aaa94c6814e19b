//! What a texel has received after all shots, and what it then has. Twin of
//! `gpu/src/shaders/collect.wgsl`.

use common::mesh::Texel;
use glam::Vec3;

/// H = Σ w·B_shooter in the order of the cells, `link(i)` the texel's link to cell i.
pub fn collect(shot: &[Vec3], link: impl Fn(usize) -> f32) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for (i, x) in shot.iter().enumerate() {
        if *x != Vec3::ZERO {
            sum += *x * link(i);
        }
    }
    sum
}

/// B = E + ρH.
pub fn settle(texel: &Texel, reflectance: Vec3, irradiance: Vec3) -> Vec3 {
    let reflected = reflectance * irradiance;
    texel.emission + reflected
}
