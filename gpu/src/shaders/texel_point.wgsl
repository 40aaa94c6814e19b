// The points of a texel. Twin: cpu/src/twin/texel_point.rs.

// Point `s` of texel `k` as `cell` sees it; w is the area that it stands for over the mean.
fn texel_point(k: u32, cell: u32, s: u32) -> vec4f {
    if params.samples == 1u {
        return vec4f(texels[k].position, 1.0);
    }
    return point(k, texel_uv(s, k, cell));
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
