// Draws the item buffer as the paper's Table 3 prints it: only the corners of faces are projected, edges are
// straight on the disc, and planar depth clips at half a unit.

struct Vertex {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat, either) face: vec2u,  // of which shot
}

// Two triangles a face; an instance a shot.
@vertex
fn draw_vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) shot: u32) -> Vertex {
    slot = shot;
    frame = shooter_frame();
    let face = index / 6u;
    if is_hidden_face(face) {
        // Outside the square.
        return Vertex(vec4f(2.0, 2.0, 0.5, 1.0), vec2u(face, slot));
    }
    // Corners 0 1 2 and 0 2 3, a digit each.
    let corner = (0x320210u >> (4u * (index % 6u))) & 3u;
    // Table 3, line 3; lines 4 to 6 are `project_direction`; line 7, where v.z is negative in front, is `printed`.
    let local = to_local(faces[face].corners[corner].xyz);
    let z = local.z * params.unit;
    let printed = (2.0 * z * PAPER_FAR_PLANE - PAPER_NEAR_PLANE) / (PAPER_FAR_PLANE - PAPER_NEAR_PLANE);
    return Vertex(vec4f(project_direction(local), printed * 0.5 + 0.5, 1.0), vec2u(face, slot));
}

@fragment
fn draw_fragment(vertex: Vertex) -> @location(0) u32 {
    slot = vertex.face.y;
    let pixel = vec2u(vertex.position.xy) - tile_index() * IMAGE_SIZE;
    if !is_covered(pixel_centre(pixel.x, pixel.y)) {
        discard;
    }
    return vertex.face.x + 1u;
}
