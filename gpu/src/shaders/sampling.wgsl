// Where on a texel the sight of a cell is asked. Twin: common/src/sampling.rs.

fn hash(x: u32) -> u32 {
    let state = x * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

fn coordinate(s: u32, step: u32, shift: u32) -> f32 {
    let x = (s + 1u) * step + shift;
    let inside = select(INSIDE_V, INSIDE_U, step == STEP_U || step == STEP_CELL_U);
    return (f32(x >> 22u) + inside) / 1024.0;
}

fn texel_uv(s: u32, texel: u32, cell: u32) -> vec2f {
    let first = hash(texel ^ hash(cell));
    let second = hash(first);
    return vec2f(coordinate(s, STEP_U, first), coordinate(s, STEP_V, second));
}

fn cell_uv(s: u32, cell: u32) -> vec2f {
    let first = hash(cell);
    let second = hash(first);
    return vec2f(coordinate(s, STEP_CELL_U, first), coordinate(s, STEP_CELL_V, second));
}

fn fold(u: f32, v: f32) -> vec2f {
    if u + v > 1.0 {
        return vec2f(1.0 - u, 1.0 - v);
    }
    return vec2f(u, v);
}

// Place number `place` of the even grid by which a near texel's form factor is averaged.
fn near_uv(place: u32, kind: u32) -> vec2f {
    let inset = select(NEAR_TRIANGLE, NEAR_QUAD, kind == QUAD);
    return vec2f(along(place % NEAR, inset), along(place / NEAR, inset));
}

fn along(k: u32, inset: f32) -> f32 {
    return (f32(k) + inset) / f32(NEAR);
}
