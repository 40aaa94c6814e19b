//! Morton's curve through space, on which neighbours are near each other.

use glam::Vec3;

/// Cells of the curve along each axis.
const CELL_COUNT: f32 = 1024.0;

/// Returns the numbers of `places` in their order along the curve.
pub fn sort_along_curve(places: &[Vec3]) -> Vec<u32> {
    let low = places.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = places.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let scale = (CELL_COUNT - 1.0) / (high - low).max_element().max(f32::MIN_POSITIVE);
    let key = |k: &u32| {
        let cell = (places[*k as usize] - low) * scale;
        let bits = |x: f32, axis: u32| (0..10).map(|b| ((x as u32 >> b) & 1) << (3 * b + axis)).sum::<u32>();
        bits(cell.x, 0) + bits(cell.y, 1) + bits(cell.z, 2)
    };
    let mut order: Vec<u32> = (0..places.len() as u32).collect();
    order.sort_by_cached_key(key);
    order
}
