// Form factor from a texel to the shooting patch.

fn form_factor(centre: vec3f, position: vec3f, normal: vec3f, texel_area: f32) -> f32 {
    let d = position - centre;
    let height = dot(shots[slot].normal, d);
    if height <= CONTACT_DISTANCE {
        return 0.0;
    }
    let r2 = dot(d, d);
    let r = sqrt(r2);
    // Each cosine is clamped on its own: two negative ones would multiply to light.
    let cos_i = height / r;
    let cos_j = max(-dot(normal, d) / r, 0.0);
    if FORM_FACTOR == FORM_FACTOR_PAPER {
        return disc_factor(cos_i, cos_j, r2, shots[slot].area, texel_area);
    }
    if FORM_FACTOR == FORM_FACTOR_DISC {
        return disc_factor(cos_i, cos_j, r2, shots[slot].area, shots[slot].area);
    }
    if is_remote(r2, shots[slot].radius) {
        return disc_factor(cos_i, cos_j, r2, shots[slot].area, 0.0);
    }
    return polygon_factor(position, normal);
}

fn is_remote(r2: f32, radius: f32) -> bool {
    let reach = POINT_SOURCE_RADII * radius;
    return r2 > reach * reach;
}

fn is_far(position: vec3f, centre: vec3f, reach: f32) -> bool {
    let d = position - centre;
    return dot(d, d) > reach * reach;
}

// The weight of one point of the patch; never 0 where `f` is not.
fn point_weight(centre: vec3f, position: vec3f, normal: vec3f, part: f32, f: f32) -> f32 {
    let d = position - centre;
    let r2 = dot(d, d);
    let r = sqrt(r2);
    let cos_i = max(dot(shots[slot].normal, d) / r, 0.0);
    let cos_j = max(-dot(normal, d) / r, 0.0);
    return disc_factor(cos_i, cos_j, r2, part, part) + f * 1e-6;
}

// Equation 2 of the paper: `disc_area` is the texel's there, the shooter's in Wallace.
fn disc_factor(cos_i: f32, cos_j: f32, r2: f32, shooter_area: f32, disc_area: f32) -> f32 {
    return shooter_area * cos_i * cos_j / (PI * r2 + disc_area);
}

// The part of the patch above the texel's plane, corner by corner: no list of corners, which a GPU would keep
// in memory.
struct Outline {
    first: vec3f,
    last: vec3f,
    count: u32,
    sum: f32,
    low: bool,
}

fn add_corner(outline: Outline, corner: vec3f, normal: vec3f) -> Outline {
    if outline.count == 0u {
        return Outline(corner, corner, 1u, 0.0, outline.low);
    }
    let sum = outline.sum + edge_term(outline.last, corner, normal, outline.low);
    return Outline(outline.first, corner, outline.count + 1u, sum, outline.low);
}

fn polygon_factor(position: vec3f, normal: vec3f) -> f32 {
    var lowest = MISS_DISTANCE;
    var highest = -MISS_DISTANCE;
    for (var k = 0u; k < 4u; k++) {
        let height = dot(normal, shots[slot].corners[k].xyz - position);
        lowest = min(lowest, height);
        highest = max(highest, height);
    }
    // What only touches the horizon shines into a texel by its rounding alone.
    if highest <= CONTACT_DISTANCE {
        return 0.0;
    }
    let low = is_low(position, highest);
    // Nothing to clip: all corners count.
    let whole = lowest > -CONTACT_DISTANCE;
    var outline = Outline(vec3f(0.0), vec3f(0.0), 0u, 0.0, low);
    var a = shots[slot].corners[3].xyz - position;
    var height_a = dot(normal, a);
    for (var k = 0u; k < 4u; k++) {
        let b = shots[slot].corners[k].xyz - position;
        let height_b = dot(normal, b);
        if !whole && (height_a > 0.0) != (height_b > 0.0) {
            let crossing = a + (b - a) * (height_a / (height_a - height_b));
            outline = add_corner(outline, crossing, normal);
        }
        if whole || height_b > 0.0 {
            outline = add_corner(outline, b, normal);
        }
        a = b;
        height_a = height_b;
    }
    if outline.count < 3u {
        return 0.0;
    }
    let sum = outline.sum + edge_term(outline.last, outline.first, normal, low);
    return max(-sum / (2.0 * PI), 0.0);
}

fn is_low(position: vec3f, highest: f32) -> bool {
    let d = position - shots[slot].middle;
    let beyond = sqrt(dot(d, d)) - shots[slot].radius;
    return highest <= MAX_GRAZING_HEIGHT_RATIO * max(dot(shots[slot].normal, d), beyond);
}

fn edge_term(a: vec3f, b: vec3f, normal: vec3f, low: bool) -> f32 {
    if low {
        return low_edge_term(a, b, normal);
    }
    let c = cross(a, b);
    let s = sqrt(dot(c, c));
    if s == 0.0 {
        return 0.0;
    }
    return vector_angle(s, dot(a, b)) / s * dot(c, normal);
}

fn low_edge_term(a: vec3f, b: vec3f, normal: vec3f) -> f32 {
    let height_a = dot(normal, a);
    let height_b = dot(normal, b);
    let foot_a = a - normal * height_a;
    let foot_b = b - normal * height_b;
    let turn = dot(cross(foot_a, foot_b), normal);
    let x = abs(turn);
    let w = foot_b * height_a - foot_a * height_b;
    let w2 = dot(w, w);
    let s = sqrt(x * x + w2);
    if s == 0.0 {
        return 0.0;
    }
    let less = w2 / (s + x);
    let c = dot(foot_a, foot_b);
    let rise = height_a * height_b;
    let sine = c * less - rise * x;
    let cosine = c * (c + rise) + x * s;
    var wider = vector_angle(abs(sine), cosine);
    if sine < 0.0 {
        wider = -wider;
    }
    let difference = (wider * x - vector_angle(x, c) * less) / s;
    return select(difference, -difference, turn < 0.0);
}

// WGSL allows its own atan2 an error of 4096 ulp.
fn vector_angle(s: f32, c: f32) -> f32 {
    let x = abs(c);
    let q = min(s, x) / max(s, x);
    var a = arc_tangent(q);
    if s > x {
        a = PI / 2.0 - a;
    }
    if c < 0.0 {
        a = PI - a;
    }
    return a;
}

fn arc_tangent(q: f32) -> f32 {
    var x = q;
    var offset = 0.0;
    if q > 0.41421357 {
        x = (q - 1.0) / (q + 1.0);
        offset = PI / 4.0;
    }
    let z = x * x;
    let p = ((0.08053745 * z - 0.13877685) * z + 0.19977711) * z - 0.3333295;
    return offset + (p * z * x + x);
}
