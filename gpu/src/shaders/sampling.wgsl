// Sample points on texels and patches: a shifted additive recurrence, the same on every adapter.

fn pcg_hash(x: u32) -> u32 {
    let state = x * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

fn sample_coordinate(s: u32, step: u32, shift: u32) -> f32 {
    let x = (s + 1u) * step + shift;
    let inside = select(STEP_OFFSET_V, STEP_OFFSET_U, step == STEP_U || step == STEP_PATCH_U);
    return (f32(x >> 22u) + inside) / 1024.0;
}

fn texel_uv(s: u32, texel: u32, patch_index: u32) -> vec2f {
    let first = pcg_hash(texel ^ pcg_hash(patch_index));
    let second = pcg_hash(first);
    return vec2f(sample_coordinate(s, STEP_U, first), sample_coordinate(s, STEP_V, second));
}

fn patch_uv(s: u32, patch_index: u32) -> vec2f {
    let first = pcg_hash(patch_index);
    let second = pcg_hash(first);
    return vec2f(sample_coordinate(s, STEP_PATCH_U, first), sample_coordinate(s, STEP_PATCH_V, second));
}

// Place number `place` of the even grid by which a near texel's form factor is averaged.
fn near_point_uv(place: u32, kind: u32) -> vec2f {
    let inset = select(NEAR_OFFSET_TRIANGLE, NEAR_OFFSET_QUAD, kind == TEXEL_QUAD);
    return vec2f(grid_coordinate(place % NEAR_POINTS_PER_SIDE, inset), grid_coordinate(place / NEAR_POINTS_PER_SIDE, inset));
}

fn grid_coordinate(k: u32, inset: f32) -> f32 {
    return (f32(k) + inset) / f32(NEAR_POINTS_PER_SIDE);
}

fn fold_triangle(u: f32, v: f32) -> vec2f {
    if u + v > 1.0 {
        return vec2f(1.0 - u, 1.0 - v);
    }
    return vec2f(u, v);
}
