//! Spacing of the vertices along the edges of a tessellated face.

use glam::Vec3;

/// Returns the parameter on the edge from `a` to `b` at which the share `u` of its parts ends, as seen from the
/// origin: each half of the edge's angle is cut evenly along the tangent at its middle.
pub fn subdivide_edge(a: Vec3, b: Vec3, u: f32) -> f32 {
    let length_a = a.dot(a).max(1e-24).sqrt();
    let length_b = b.dot(b).max(1e-24).sqrt();
    // The bisector of the angle divides the edge in the ratio of the two sides.
    let middle = length_a / (length_a + length_b);
    let m = a * (1.0 - middle) + b * middle;
    let length_m = m.dot(m).max(1e-24).sqrt();
    if u < 0.5 {
        let w = 2.0 * u;
        return middle * (w * length_a / ((1.0 - w) * length_m + w * length_a));
    }
    let w = 2.0 * u - 1.0;
    middle + (1.0 - middle) * (w * length_m / ((1.0 - w) * length_b + w * length_m))
}
