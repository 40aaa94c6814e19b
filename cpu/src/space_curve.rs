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

#[cfg(test)]
mod tests {
    use super::*;

    /// Eight corners of a box beside the origin come octant by octant, x first; places in one cell keep their order.
    #[test]
    fn corners_of_a_box_follow_the_curve() {
        let corner = |k: u32| {
            let [x, y, z] = [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { 3.0 } else { -5.0 });
            Vec3::new(x, y, z)
        };
        let shuffled = [6, 3, 0, 7, 5, 1, 4, 2];
        let places = shuffled.map(corner);
        let found: Vec<u32> = sort_along_curve(&places)
            .into_iter()
            .map(|k| shuffled[k as usize])
            .collect();
        assert_eq!(found, [0, 1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(sort_along_curve(&[Vec3::ONE; 3]), [0, 1, 2]);
    }

    /// Along one axis the order is that of the coordinate, to a thousandth of the extent.
    #[test]
    fn places_along_an_axis_are_in_order() {
        let places: Vec<Vec3> = (0..1024).rev().map(|k| Vec3::new(2.0, -7.0 + k as f32, 1.0)).collect();
        assert!(sort_along_curve(&places).into_iter().eq((0..1024).rev()));
    }
}
