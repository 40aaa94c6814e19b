// The next samples of the shot, the frame at the first one's point on the cell, and how many
// faces its item buffer shows: first the room, then, where there are objects, everything.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> faces: array<Face>;
@group(0) @binding(2) var<storage, read> points: array<Point>;
@group(0) @binding(3) var<storage, read_write> shot: Shot;
@group(0) @binding(4) var<storage, read_write> rectangles: array<u32>;  // arguments of a draw

@compute @workgroup_size(1)
fn aim() {
    draw(select(0u, params.room, shot.face < params.room));
    if shot.shooting == 0u {
        return;
    }
    let face = shot.face;
    shot.sample = shot.next;
    shot.next = min(shot.next + params.step, params.samples);
    let point = min(shot.sample, params.samples - 1u);
    shot.centre = points[shot.cell * params.samples + point].position;
    shot.normal = faces[face].plane.xyz;
    shot.tangent = faces[face].tangent.xyz;
    shot.bitangent = cross(shot.normal, shot.tangent);
    shot.sheet = faces[face].sheet;
}

@compute @workgroup_size(1)
fn whole() {
    draw(params.faces);
}

// Six corners for each side of each face; nothing is drawn for links that are kept.
fn draw(count: u32) {
    shot.drawn = select(0u, count, shot.shooting == 1u && shot.fresh == 1u);
    rectangles[0] = 6u * SIDES * shot.drawn;
    rectangles[1] = 1u;
}
