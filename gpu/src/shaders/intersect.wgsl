// A ray and a face: plane first, then its edges. Twin: cpu/src/intersect.rs.

struct Crossing {
    t: f32,
    inside: f32,
    facing: f32,
}

fn intersect(face: u32, origin: vec3f, direction: vec3f) -> Crossing {
    let plane = faces[face].plane;
    let facing = dot(plane.xyz, direction);
    if facing == 0.0 {
        return Crossing(MISS, -MISS, facing);
    }
    let t = (plane.w - dot(plane.xyz, origin)) / facing;
    let p = origin + direction * t;
    var inside = MISS;
    for (var k = 0u; k < 4u; k++) {
        let edge = faces[face].edges[k];
        // The edge that a triangle lacks is (0, 0): it must not limit.
        let distance = dot(edge.xyz, p) - edge.w;
        inside = min(inside, select(distance, MISS, all(edge.xyz == vec3f(0.0))));
    }
    return Crossing(t, inside, facing);
}
