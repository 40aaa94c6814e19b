// Draws the item buffer from tessellated faces (the paper's Table 3): the ID of the nearest face in every
// pixel of the shooter's hemisphere. Depth is the distance along the pixel's own ray to the face's plane:
// tessellation moves outlines only.

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
    frame = shooter_frame();
    let parts = instance.y;
    let u = f32(index % (parts + 1u)) / f32(parts);
    let v = f32(index / (parts + 1u)) / f32(parts);
    let a = faces[instance.x].corners[0].xyz - frame.centre;
    let b = faces[instance.x].corners[1].xyz - frame.centre;
    let c = faces[instance.x].corners[2].xyz - frame.centre;
    let d = faces[instance.x].corners[3].xyz - frame.centre;
    let s = subdivide_edge(a, b, u) * (1.0 - v) + subdivide_edge(d, c, u) * v;
    let t = subdivide_edge(a, d, v) * (1.0 - u) + subdivide_edge(b, c, v) * u;
    let low = a * (1.0 - s) + b * s;
    let high = d * (1.0 - s) + c * s;
    // Table 3, line 3; lines 4 to 6 are `project_direction`; line 7, where v.z is negative in front, is `printed`.
    let local = rotate_to_local(low * (1.0 - t) + high * t);
    var depth = 0.5;
    if PROJECTION == PROJECTION_PAPER {
        let z = local.z * params.unit;
        let printed = (2.0 * z * PAPER_FAR_PLANE - PAPER_NEAR_PLANE) / (PAPER_FAR_PLANE - PAPER_NEAR_PLANE);
        depth = printed * 0.5 + 0.5;
    }
    let elevation = local.z / sqrt(dot(local, local));
    return Vertex(vec4f(project_direction(local), depth, 1.0), elevation, instance.x);
}

struct Fragment {
    @location(0) id: u32,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn fragment(vertex: Vertex) -> Fragment {
    frame = shooter_frame();
    let p = pixel_centre(u32(vertex.position.x), u32(vertex.position.y));
    if p.x * p.x + p.y * p.y > 1.0 {
        discard;
    }
    if PROJECTION == PROJECTION_PAPER {
        return Fragment(vertex.face + 1u, vertex.position.z);
    }
    if vertex.elevation < MIN_ELEVATION_SINE {
        discard;
    }
    let direction = to_world(unproject_point(p));
    let normal = faces[vertex.face].plane.xyz;
    let facing = dot(normal, direction);
    let t = dot(normal, faces[vertex.face].corners[0].xyz - frame.centre) / facing;
    if facing == 0.0 || t <= 0.0 {
        discard;
    }
    return Fragment(vertex.face + 1u, min(t * DEPTH_SCALE, MAX_DEPTH));
}
