// The ID of the nearest face in every pixel of the shooter's hemisphere (the paper's Table 3).
// Depth is the distance along the pixel's own ray to the face's plane: tessellation moves
// outlines only. Twin: cpu/src/twin/item_buffer_tessellated.rs.

@group(0) @binding(0) var<storage, read> faces: array<Face>;
@group(0) @binding(1) var<storage, read> shots: array<Shot>;
@group(0) @binding(2) var<uniform> params: Params;

struct Vertex {
    @builtin(position) position: vec4f,
    @location(0) elevation: f32,
    @location(1) @interpolate(flat, either) face: u32,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, @location(0) instance: vec2u) -> Vertex {
    look();
    let parts = instance.y;
    let u = f32(index % (parts + 1u)) / f32(parts);
    let v = f32(index / (parts + 1u)) / f32(parts);
    let a = faces[instance.x].corners[0].xyz - frame.centre;
    let b = faces[instance.x].corners[1].xyz - frame.centre;
    let c = faces[instance.x].corners[2].xyz - frame.centre;
    let d = faces[instance.x].corners[3].xyz - frame.centre;
    let s = spread(a, b, u) * (1.0 - v) + spread(d, c, u) * v;
    let t = spread(a, d, v) * (1.0 - u) + spread(b, c, v) * u;
    let low = a * (1.0 - s) + b * s;
    let high = d * (1.0 - s) + c * s;
    // Table 3, line 3; lines 4 to 6 are `project`; line 7, where v.z is negative in front, is `printed`.
    let local = turn(low * (1.0 - t) + high * t);
    var depth = 0.5;
    if PROJECTION == PROJECTION_PAPER {
        let z = local.z * params.unit;
        let printed = (2.0 * z * PAPER_FAR - PAPER_NEAR) / (PAPER_FAR - PAPER_NEAR);
        depth = printed * 0.5 + 0.5;
    }
    let elevation = local.z / sqrt(dot(local, local));
    return Vertex(vec4f(project(local), depth, 1.0), elevation, instance.x);
}

// Where on the edge from a to b (seen from the origin) the share u of its parts ends. Twin:
// cpu/src/twin/tessellate.rs.
fn spread(a: vec3f, b: vec3f, u: f32) -> f32 {
    let length_a = sqrt(max(dot(a, a), 1e-24));
    let length_b = sqrt(max(dot(b, b), 1e-24));
    // The bisector of the angle divides the edge in the ratio of the two sides.
    let middle = length_a / (length_a + length_b);
    let m = a * (1.0 - middle) + b * middle;
    let length_m = sqrt(max(dot(m, m), 1e-24));
    if u < 0.5 {
        let w = 2.0 * u;
        return middle * (w * length_a / ((1.0 - w) * length_m + w * length_a));
    }
    let w = 2.0 * u - 1.0;
    return middle + (1.0 - middle) * (w * length_m / ((1.0 - w) * length_b + w * length_m));
}

struct Fragment {
    @location(0) id: u32,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn fragment(vertex: Vertex) -> Fragment {
    look();
    let p = pixel_centre(u32(vertex.position.x), u32(vertex.position.y));
    if p.x * p.x + p.y * p.y > 1.0 {
        discard;
    }
    if PROJECTION == PROJECTION_PAPER {
        return Fragment(vertex.face + 1u, vertex.position.z);
    }
    if vertex.elevation < BELOW {
        discard;
    }
    let direction = to_world(unproject(p));
    let normal = faces[vertex.face].plane.xyz;
    let facing = dot(normal, direction);
    let t = dot(normal, faces[vertex.face].corners[0].xyz - frame.centre) / facing;
    if facing == 0.0 || t <= 0.0 {
        discard;
    }
    return Fragment(vertex.face + 1u, min(t * DEPTH_SCALE, DEPTH_MAX));
}
