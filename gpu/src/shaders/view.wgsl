// Prepares the next samples of each shot: the frame at the first one's point on the patch, and the number
// of faces that its item buffer shows. The room is drawn first, then, where there are objects, all faces.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> faces: array<Face>;
@group(0) @binding(2) var<storage, read> points: array<Point>;
@group(0) @binding(3) var<storage, read_write> shots: array<Shot>;
@group(0) @binding(4) var<storage, read_write> rectangles: array<u32>;  // arguments of a draw

// Moves on to the next sample and sets its frame.
@compute @workgroup_size(1)
fn view_sample(@builtin(workgroup_id) group: vec3u) {
    slot = group.z;
    select_faces(select(0u, params.room, shots[slot].face < params.room));
    if shots[slot].shooting == 0u {
        return;
    }
    let face = shots[slot].face;
    shots[slot].sample = shots[slot].next;
    shots[slot].next = min(shots[slot].next + params.step, params.samples);
    let point = min(shots[slot].sample, params.samples - 1u);
    shots[slot].centre = points[shots[slot].patch_index * params.samples + point].position;
    shots[slot].normal = faces[face].plane.xyz;
    shots[slot].tangent = faces[face].tangent.xyz;
    shots[slot].bitangent = cross(shots[slot].normal, shots[slot].tangent);
    shots[slot].sheet = faces[face].sheet;
}

// Draws all faces from the same sample.
@compute @workgroup_size(1)
fn view_all_faces(@builtin(workgroup_id) group: vec3u) {
    slot = group.z;
    select_faces(params.faces);
}

// Sets the number of faces to draw, six vertices for each side of each face. Nothing is drawn for links
// that are kept, nor where visibility is by rays: then there are no sides.
fn select_faces(count: u32) {
    shots[slot].drawn = select(0u, count, shots[slot].shooting == 1u && shots[slot].fresh == 1u);
    rectangles[0] = 6u * IMAGE_PLANES * shots[slot].drawn;
    rectangles[1] = 1u;
}
