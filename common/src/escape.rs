//! Directions by which a shooter's escaped share is measured.
//!
//! A cosine-weighted, stratified set in the shooter's frame (x tangent, y bitangent, z normal):
//! the share of the set that meets no front is the share of a diffuse shooter's flux that
//! leaves. Both solvers use the same set, so their shares are equal, not only close.

use glam::Vec3;

/// Directions per shooter, a square number: standard error of a share ≲ 0.3 %.
pub const DIRECTIONS: usize = 1024;

/// The set: one direction in each of 32×32 equal strata of the projected hemisphere.
pub fn directions() -> Vec<Vec3> {
    let side = DIRECTIONS.isqrt();
    (0..DIRECTIONS)
        .map(|k| {
            // R2 sequence inside the strata: aligned rays would run along edges of aligned rooms.
            let jitter = |alpha: f64| (0.5 + alpha * (k + 1) as f64).fract();
            let x = ((k % side) as f64 + jitter(0.754_877_666_246_693)) / side as f64;
            let y = ((k / side) as f64 + jitter(0.569_840_290_998_053)) / side as f64;
            concentric(2.0 * x - 1.0, 2.0 * y - 1.0)
        })
        .collect()
}

/// Shirley & Chiu 1997: square to disc with equal areas, lifted to the hemisphere.
fn concentric(x: f64, y: f64) -> Vec3 {
    use std::f64::consts::FRAC_PI_4;
    let (r, phi) = if x.abs() > y.abs() {
        (x, FRAC_PI_4 * y / x)
    } else if y != 0.0 {
        (y, 2.0 * FRAC_PI_4 - FRAC_PI_4 * x / y)
    } else {
        (0.0, 0.0)
    };
    let (s, c) = phi.sin_cos();
    Vec3::new(
        (r * c) as f32,
        (r * s) as f32,
        (1.0 - r * r).max(0.0).sqrt() as f32,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;

    #[test]
    fn the_set_is_cosine_weighted() {
        let set = directions();
        let n = set.len() as f32;
        // E[z] = 2/3, E[x] = E[y] = 0, E[x²] = 1/4; stratified error ~ n^(−3/4).
        let bound = 3.0 * n.powf(-0.75);
        let mean: Vec3 = set.iter().sum::<Vec3>() / n;
        assert!(
            mean.abs_diff_eq(Vec3::new(0.0, 0.0, 2.0 / 3.0), bound),
            "{mean}"
        );
        let square = set.iter().map(|d| d.x * d.x).sum::<f32>() / n;
        assert!(abs_diff_eq!(square, 0.25, epsilon = bound));
        assert!(
            set.iter()
                .all(|d| abs_diff_eq!(d.length(), 1.0, epsilon = 1e-6) && d.z > 0.0)
        );
    }
}
