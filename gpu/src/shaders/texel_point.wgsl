// Points of a texel.

// Point `s` of texel `k` for the shooting patch; w is the area that it represents, over the mean.
fn texel_point(k: u32, patch_index: u32, s: u32) -> vec4f {
    if params.samples == 1u {
        return vec4f(texels[k].position, 1.0);
    }
    return point_on_texel(k, texel_uv(s, k, patch_index));
}

// Point `at` of texel `k`.
fn point_on_texel(k: u32, at: vec2f) -> vec4f {
    let face = texels[k].face;
    let a = faces[face].corners[0].xyz;
    let b = faces[face].corners[1].xyz;
    let c = faces[face].corners[2].xyz;
    let d = faces[face].corners[3].xyz;
    var uv = at;
    let place = vec2f(texels[k].place);
    let size = vec2f(faces[face].resolution);
    if texels[k].kind != TEXEL_QUAD {
        uv = fold_triangle(uv.x, uv.y);
        if texels[k].kind == TEXEL_INVERTED {
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
