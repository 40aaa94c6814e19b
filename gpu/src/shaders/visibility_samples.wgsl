// Number of visibility samples that a link needs, and of receiver points for its form factor.

// Points per side of a spot of which its form factor is the mean.
fn receiver_points_per_side(within: f32, light: f32, near: f32) -> u32 {
    let error = within * light / near;
    if error < 1.0 {
        return 1u;
    }
    if error < 10.0 {
        return 2u;
    }
    if error < 100.0 {
        return 4u;
    }
    return 8u;
}

// x^(85/64), near 4/3, by roots: they are exact on every adapter.
fn four_thirds_power(x: f32) -> f32 {
    let fourth = sqrt(sqrt(x));
    let sixteenth = sqrt(sqrt(fourth));
    return x * fourth * sixteenth * sqrt(sqrt(sixteenth));
}

// Standard deviation of the visibility of one sample.
fn visibility_deviation(seen: f32) -> f32 {
    return sqrt(max(seen * (1.0 - seen), 0.0));
}

// Number of samples: the error of S stratified samples falls as S^(−3/4).
fn required_samples(shines: f32, seen: f32, visibility: f32) -> f32 {
    let error = shines * max(visibility_deviation(seen), 0.125) * 0.5 / visibility;
    return four_thirds_power(error);
}
