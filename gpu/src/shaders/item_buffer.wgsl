// Draws the item buffer (Table 1, line 3): the ID of the nearest face in every pixel. A rectangle that
// holds the image of the face is drawn, and each of its pixels intersects its own ray with the face.
// Depth is the distance along that ray.

struct Vertex {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat, either) face: vec2u,  // of which shot
    @location(1) @interpolate(flat, either) plane: vec4f,
    @location(2) @interpolate(flat, either) edge0: vec4f,
    @location(3) @interpolate(flat, either) edge1: vec4f,
    @location(4) @interpolate(flat, either) edge2: vec4f,
    @location(5) @interpolate(flat, either) edge3: vec4f,
    @location(6) @interpolate(flat, either) centre: vec3f,
    @location(7) @interpolate(flat, either) tangent: vec3f,
    @location(8) @interpolate(flat, either) bitangent: vec3f,
    @location(9) @interpolate(flat, either) normal: vec3f,
}

// Two triangles a rectangle, a rectangle for each side of each face; an instance a shot.
@vertex
fn draw_vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) shot: u32) -> Vertex {
    slot = shot;
    frame = shooter_frame();
    let face = index / 6u / IMAGE_PLANES;
    let side = index / 6u % IMAGE_PLANES;
    let limits = image_bound(face, side);
    // Lower left 0, lower right 1, upper left 2, upper right 3: corners 0 1 2 and 2 1 3, as bits.
    let right = ((0x32u >> (index % 6u)) & 1u) == 1u;
    let upper = ((0x2cu >> (index % 6u)) & 1u) == 1u;
    let p = vec2f(select(limits.x, limits.z, right), select(limits.y, limits.w, upper));
    // An empty rectangle lies outside the square.
    let empty = any(limits.xy >= limits.zw);
    let corner = select(unfold_side(side, p), vec2f(2.0), empty);
    // Planes and frame are handed on: reading them from the buffer in each pixel is slower.
    return Vertex(
        vec4f(corner, 0.5, 1.0),
        vec2u(face, slot),
        faces[face].plane,
        faces[face].edges[0],
        faces[face].edges[1],
        faces[face].edges[2],
        faces[face].edges[3],
        frame.centre,
        frame.tangent,
        frame.bitangent,
        frame.normal,
    );
}

struct Fragment {
    @location(0) id: u32,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn draw_fragment(vertex: Vertex) -> Fragment {
    slot = vertex.face.y;
    frame = Frame(vertex.centre, vertex.tangent, vertex.bitangent, vertex.normal);
    let pixel = vec2u(vertex.position.xy) - tile_index() * IMAGE_SIZE;
    let p = pixel_centre(pixel.x, pixel.y);
    if !is_covered(p) {
        discard;
    }
    let ray = to_world(unproject_point(p));
    let v = vertex;
    let hit = intersect_planes(v.plane, v.edge0, v.edge1, v.edge2, v.edge3, frame.centre, ray);
    if hit.t <= 0.0 || hit.inside < -OUTLINE_MARGIN {
        discard;
    }
    return Fragment(vertex.face.x + 1u, min(hit.t * DEPTH_SCALE, MAX_DEPTH));
}
