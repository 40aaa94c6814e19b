// The shooter's frame: origin at its point, z along its normal.

struct Frame {
    centre: vec3f,
    tangent: vec3f,
    bitangent: vec3f,
    normal: vec3f,
}

var<private> frame: Frame;

// Frame of the shot in `slot`, of which `frame` is the copy that the others use.
fn shooter_frame() -> Frame {
    return Frame(shots[slot].centre, shots[slot].tangent, shots[slot].bitangent, shots[slot].normal);
}

fn to_local(point: vec3f) -> vec3f {
    return rotate_to_local(point - frame.centre);
}

fn rotate_to_local(d: vec3f) -> vec3f {
    return vec3f(dot(frame.tangent, d), dot(frame.bitangent, d), dot(frame.normal, d));
}

fn to_world(v: vec3f) -> vec3f {
    return frame.tangent * v.x + frame.bitangent * v.y + frame.normal * v.z;
}
