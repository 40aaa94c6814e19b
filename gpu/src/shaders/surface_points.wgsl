// Points of nodes and of the spots of a block.

// Point (u, v) of spot `k`; w is the area that it represents, over the mean.
fn spot_point(k: u32, uv: vec2f) -> vec4f {
    let a = spots[k].corners[0].xyz;
    let b = spots[k].corners[1].xyz;
    let c = spots[k].corners[2].xyz;
    let d = spots[k].corners[3].xyz;
    if is_triangle(k) {
        let at = fold_triangle(uv.x, uv.y);
        return vec4f(a + (b - a) * at.x + (c - a) * at.y, 1.0);
    }
    let low = a * (1.0 - uv.x) + b * uv.x;
    let high = d * (1.0 - uv.x) + c * uv.x;
    let along_u = (b - a) * (1.0 - uv.y) + (c - d) * uv.y;
    let along_v = (d - a) * (1.0 - uv.x) + (c - b) * uv.x;
    let whole = cross(c - a, d - b);
    let area = sqrt(dot(whole, whole)) * 0.5;
    let own = cross(along_u, along_v);
    let weight = sqrt(dot(own, own)) / max(area, 1e-30);
    return vec4f(low * (1.0 - uv.y) + high * uv.y, weight);
}

fn is_triangle(k: u32) -> bool {
    return all(spots[k].corners[2].xyz == spots[k].corners[3].xyz);
}

// Coordinates of point `k` of a grid of n×n.
fn grid_uv(k: u32, n: u32, triangle: bool) -> vec2f {
    let inset = select(0.5, 1.0 / 3.0, triangle);
    return vec2f((f32(k % n) + inset) / f32(n), (f32(k / n) + inset) / f32(n));
}

// Point (u, v) of a node.
fn outline_point(node: u32, uv: vec2f) -> vec4f {
    let a = shots[node].corners[0].xyz;
    let b = shots[node].corners[1].xyz;
    let c = shots[node].corners[2].xyz;
    let d = shots[node].corners[3].xyz;
    if all(c == d) {
        let at = fold_triangle(uv.x, uv.y);
        return vec4f(a + (b - a) * at.x + (c - a) * at.y, 1.0);
    }
    let low = a * (1.0 - uv.x) + b * uv.x;
    let high = d * (1.0 - uv.x) + c * uv.x;
    let along_u = (b - a) * (1.0 - uv.y) + (c - d) * uv.y;
    let along_v = (d - a) * (1.0 - uv.x) + (c - b) * uv.x;
    let whole = cross(c - a, d - b);
    let area = sqrt(dot(whole, whole)) * 0.5;
    let own = cross(along_u, along_v);
    var weight = 1.0;
    if area > 0.0 {
        weight = sqrt(dot(own, own)) / area;
    }
    return vec4f(low * (1.0 - uv.y) + high * uv.y, weight);
}
