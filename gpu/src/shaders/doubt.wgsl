// How well a link must be known. Twin: cpu/src/hierarchy/choice.rs.

// Places a side on each spot, of which its factor is the mean.
fn places(within: f32, light: f32, near: f32) -> u32 {
    let left = within * light / near;
    if left < 1.0 {
        return 1u;
    }
    if left < 10.0 {
        return 2u;
    }
    if left < 100.0 {
        return 4u;
    }
    return 8u;
}

// x^(85/64) by roots.
fn power(x: f32) -> f32 {
    let fourth = sqrt(sqrt(x));
    let sixteenth = sqrt(sqrt(fourth));
    return x * fourth * sixteenth * sqrt(sqrt(sixteenth));
}

fn mixed(seen: f32) -> f32 {
    return sqrt(max(seen * (1.0 - seen), 0.0));
}

// What S stratified samples leave falls as S^(−3/4).
fn needed(shines: f32, seen: f32, visibility: f32) -> f32 {
    let doubt = shines * max(mixed(seen), 0.125) * 0.5 / visibility;
    return power(doubt);
}
