// Spacing of the vertices along the edges of a tessellated face.

// Parameter on the edge from a to b at which the share u of its parts ends, as seen from the origin.
fn subdivide_edge(a: vec3f, b: vec3f, u: f32) -> f32 {
    let length_a = sqrt(max(dot(a, a), 1e-24));
    let length_b = sqrt(max(dot(b, b), 1e-24));
    // The bisector of the angle divides the edge in the ratio of the two sides.
    let middle = length_a / (length_a + length_b);
    let m = a * (1.0 - middle) + b * middle;
    let length_m = sqrt(max(dot(m, m), 1e-24));
    if u < 0.5 {
        let w = 2.0 * u;
        return middle * (w * length_a / ((1.0 - w) * length_m + w * length_a));
    }
    let w = 2.0 * u - 1.0;
    return middle + (1.0 - middle) * (w * length_m / ((1.0 - w) * length_b + w * length_m));
}
