// The next samples of each shot, the frame at the first one's point on the cell, and how many
// faces its item buffer shows: first the room, then, where there are objects, everything. Twin:
// cpu/src/twin/view.rs.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> faces: array<Face>;
@group(0) @binding(2) var<storage, read> points: array<Point>;
@group(0) @binding(3) var<storage, read_write> shots: array<Shot>;
@group(0) @binding(4) var<storage, read_write> rectangles: array<u32>;  // arguments of a draw

@compute @workgroup_size(1)
fn aim(@builtin(workgroup_id) group: vec3u) {
    slot = group.z;
    draw(select(0u, params.room, shots[slot].face < params.room));
    if shots[slot].shooting == 0u {
        return;
    }
    let face = shots[slot].face;
    shots[slot].sample = shots[slot].next;
    shots[slot].next = min(shots[slot].next + params.step, params.samples);
    let point = min(shots[slot].sample, params.samples - 1u);
    shots[slot].centre = points[shots[slot].cell * params.samples + point].position;
    shots[slot].normal = faces[face].plane.xyz;
    shots[slot].tangent = faces[face].tangent.xyz;
    shots[slot].bitangent = cross(shots[slot].normal, shots[slot].tangent);
    shots[slot].sheet = faces[face].sheet;
}

@compute @workgroup_size(1)
fn whole(@builtin(workgroup_id) group: vec3u) {
    slot = group.z;
    draw(params.faces);
}

// Six corners for each side of each face; nothing is drawn for links that are kept, nor where rays
// are asked: then there are no sides.
fn draw(count: u32) {
    shots[slot].drawn = select(0u, count, shots[slot].shooting == 1u && shots[slot].fresh == 1u);
    rectangles[0] = 6u * SIDES * shots[slot].drawn;
    rectangles[1] = 1u;
}
