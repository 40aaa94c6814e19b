// Where on a texel the sight of a cell is asked. Twins: common/src/sampling.rs,
// cpu/src/twin/sampling.rs.

fn hash(x: u32) -> u32 {
    let state = x * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

fn coordinate(s: u32, step: u32, shift: u32) -> f32 {
    let x = (s + 1u) * step + shift;
    let inside = select(INSIDE_V, INSIDE_U, step == STEP_U);
    return (f32(x >> 22u) + inside) / 1024.0;
}

fn texel_uv(s: u32, texel: u32, cell: u32) -> vec2f {
    let first = hash(texel ^ hash(cell));
    let second = hash(first);
    return vec2f(coordinate(s, STEP_U, first), coordinate(s, STEP_V, second));
}

fn fold(u: f32, v: f32) -> vec2f {
    if u + v > 1.0 {
        return vec2f(1.0 - u, 1.0 - v);
    }
    return vec2f(u, v);
}

// Point `s` of texel `k` as `cell` sees it; w is the area that it stands for over the mean.
fn texel_point(k: u32, cell: u32, s: u32) -> vec4f {
    if params.samples == 1u {
        return vec4f(texels[k].position, 1.0);
    }
    return point(k, texel_uv(s, k, cell));
}

// Place number `place` of the even grid by which a near texel's form factor is averaged.
fn near_uv(place: u32, kind: u32) -> vec2f {
    let inset = select(NEAR_TRIANGLE, NEAR_QUAD, kind == QUAD);
    return vec2f(along(place % NEAR, inset), along(place / NEAR, inset));
}

fn along(k: u32, inset: f32) -> f32 {
    return (f32(k) + inset) / f32(NEAR);
}

// Point `at` of texel `k`.
fn point(k: u32, at: vec2f) -> vec4f {
    let face = texels[k].face;
    let a = faces[face].corners[0].xyz;
    let b = faces[face].corners[1].xyz;
    let c = faces[face].corners[2].xyz;
    let d = faces[face].corners[3].xyz;
    var uv = at;
    let place = vec2f(texels[k].place);
    let size = vec2f(faces[face].resolution);
    if texels[k].kind != QUAD {
        uv = fold(uv.x, uv.y);
        if texels[k].kind == INVERTED {
            uv = vec2f(1.0 - uv.x, 1.0 - uv.y);
        }
        let u = (place.x + uv.x) / size.x;
        let v = (place.y + uv.y) / size.y;
        return vec4f(a + (b - a) * u + (c - a) * v, 1.0);
    }
    let u = (place.x + uv.x) / size.x;
    let v = (place.y + uv.y) / size.y;
    let low = a * (1.0 - u) + b * u;
    let high = d * (1.0 - u) + c * u;
    let along_u = (b - a) * (1.0 - v) + (c - d) * v;
    let along_v = (d - a) * (1.0 - u) + (c - b) * u;
    let normal = cross(along_u, along_v);
    let weight = sqrt(dot(normal, normal)) / (size.x * size.y * max(texels[k].area, 1e-30));
    return vec4f(low * (1.0 - v) + high * v, weight);
}
