// Intersection of a ray with a face: plane first, then its edges.

struct Crossing {
    t: f32,
    inside: f32,
    facing: f32,
}

// Whether the face stops a ray that runs to `end`, in units of t.
fn stops_ray(hit: Crossing, end: f32) -> bool {
    return hit.t > 0.0 && hit.t < SEGMENT_END_FRACTION * end && hit.inside >= -OUTLINE_MARGIN;
}

fn intersect_face(face: u32, origin: vec3f, direction: vec3f) -> Crossing {
    return intersect_planes(
        faces[face].plane,
        faces[face].edges[0],
        faces[face].edges[1],
        faces[face].edges[2],
        faces[face].edges[3],
        origin,
        direction,
    );
}

fn intersect_planes(
    plane: vec4f,
    edge0: vec4f,
    edge1: vec4f,
    edge2: vec4f,
    edge3: vec4f,
    origin: vec3f,
    direction: vec3f,
) -> Crossing {
    let facing = dot(plane.xyz, direction);
    if facing == 0.0 {
        return Crossing(MISS_DISTANCE, -MISS_DISTANCE, facing);
    }
    let t = (plane.w - dot(plane.xyz, origin)) / facing;
    let p = origin + direction * t;
    let one = min(inside_distance(edge0, p), inside_distance(edge1, p));
    let other = min(inside_distance(edge2, p), inside_distance(edge3, p));
    return Crossing(t, min(one, other), facing);
}

// Whether `point` lies on the plane of `face`: a ray that ends there cannot be cut by it.
fn touches_plane(face: u32, point: vec3f) -> bool {
    let plane = faces[face].plane;
    return abs(dot(plane.xyz, point) - plane.w) <= CONTACT_DISTANCE;
}

// The edge that a triangle lacks is (0, 0): it must not limit.
fn inside_distance(edge: vec4f, p: vec3f) -> f32 {
    return select(dot(edge.xyz, p) - edge.w, MISS_DISTANCE, all(edge.xyz == vec3f(0.0)));
}
