// Bounds the image of a face: a rectangle (low, high) that holds every pixel whose ray meets the face. Declares what both
// shaders that draw item buffers read.

@group(0) @binding(0) var<storage, read> faces: array<Face>;
@group(0) @binding(1) var<storage, read> shots: array<Shot>;
@group(0) @binding(2) var<uniform> params: Params;

const EMPTY_BOUND = vec4f(9.0, 9.0, -9.0, -9.0);
const FULL_BOUND = vec4f(-9.0, -9.0, 9.0, 9.0);

// Below the horizon, the shooter itself, or the far side of a two-sided sheet.
fn is_hidden_face(face: u32) -> bool {
    let a = faces[face].corners[0].xyz - frame.centre;
    let normal = faces[face].plane.xyz;
    let away = faces[face].two_sided == 1u && dot(normal, a) >= 0.0;
    if faces[face].sheet == shots[slot].sheet || all(normal == vec3f(0.0)) || away {
        return true;
    }
    var highest = -1.0;
    for (var k = 0u; k < 4u; k++) {
        highest = max(highest, to_local(faces[face].corners[k].xyz).z);
    }
    return highest <= CONTACT_DISTANCE;
}

fn image_bound(face: u32, side: u32) -> vec4f {
    if is_hidden_face(face) {
        return EMPTY_BOUND;
    }
    var limits = EMPTY_BOUND;
    var rises = vec3f(0.0);
    var sets = vec3f(0.0);
    var last = to_local(faces[face].corners[3].xyz);
    for (var k = 0u; k < 4u; k++) {
        var a = last;
        var b = to_local(faces[face].corners[k].xyz);
        last = b;
        let height_a = side_height(side, a);
        let height_b = side_height(side, b);
        if height_a < 0.0 && height_b < 0.0 {
            continue;
        }
        let near = edge_distance(a, b);
        let crossing = a + (b - a) * (height_a / (height_a - height_b));
        if height_a < 0.0 {
            a = crossing;
            rises = crossing;
        } else if height_b < 0.0 {
            b = crossing;
            sets = crossing;
        }
        if near < CONTACT_DISTANCE {
            limits = FULL_BOUND;
        } else if PROJECTION == PROJECTION_HEMICUBE {
            limits = bound_corner(bound_corner(limits, side, a, near), side, b, near);
        } else {
            limits = bound_arc(limits, a, b, 4.0 * OUTLINE_MARGIN / near);
        }
    }
    // A face that crosses the horizon ends on the rim.
    if PROJECTION != PROJECTION_HEMICUBE && any(rises != sets) {
        limits = bound_arc(limits, sets, rises, 0.0);
    }
    // Roundings, and rasterisers that snap to 1/256 pixel.
    let pixel = 2.0 / f32(IMAGE_SIZE);
    let most = side_extent(side);
    let low = max(limits.xy - pixel, most.xy - pixel);
    let high = min(limits.zw + pixel, most.zw + pixel);
    return vec4f(low, high);
}

// Distance of the edge from the shooter: the nearer an edge, the wider its image and its outline's margin.
fn edge_distance(a: vec3f, b: vec3f) -> f32 {
    let d = b - a;
    let p = a + d * clamp(-dot(a, d) / max(dot(d, d), 1e-24), 0.0, 1.0);
    return sqrt(dot(p, p));
}

// Bound of an edge's image on the hemisphere, in arcs that are near their chords.
fn bound_arc(limits: vec4f, from_a: vec3f, to_b: vec3f, margin: f32) -> vec4f {
    let a = unit_vector(from_a);
    let b = unit_vector(to_b);
    let cosine = dot(a, b);
    if cosine > 0.995 {
        return bound_chord(limits, a, b, margin);
    }
    if cosine < -0.999 {
        return FULL_BOUND;
    }
    let m = unit_vector(a + b);
    let n = unit_vector(a + m);
    let o = unit_vector(m + b);
    return bound_chord(bound_chord(bound_chord(bound_chord(limits, a, n, margin), n, m, margin), m, o, margin), o, b, margin);
}

// Both images of an arc of γ ≤ π/4 bend less than a unit circle: the sagitta is below γ²/8, and
// that below chord²/7.
fn bound_chord(limits: vec4f, a: vec3f, b: vec3f, margin: f32) -> vec4f {
    let d = b - a;
    let bulge = dot(d, d) / 7.0 + margin;
    let p = project_direction(a);
    let q = project_direction(b);
    return include_rectangle(limits, min(p, q) - bulge, max(p, q) + bulge);
}

// A side of the hemicube is a plane: straight edges stay straight. A corner at height 0 is far out.
fn bound_corner(limits: vec4f, side: u32, v: vec3f, near: f32) -> vec4f {
    let p = project_to_side(side, v, max(side_height(side, v), 1e-12));
    let margin = 4.0 * OUTLINE_MARGIN / near;
    return include_rectangle(limits, p - margin, p + margin);
}

fn include_rectangle(limits: vec4f, p: vec2f, q: vec2f) -> vec4f {
    return vec4f(min(limits.xy, p), max(limits.zw, q));
}

fn unit_vector(v: vec3f) -> vec3f {
    return v / sqrt(max(dot(v, v), 1e-24));
}
