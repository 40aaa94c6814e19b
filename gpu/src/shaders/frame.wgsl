// Where the shooter stands and how it looks; `look` before anything is turned. Twin: cpu/src/twin/frame.rs.

struct Frame {
    centre: vec3f,
    tangent: vec3f,
    bitangent: vec3f,
    normal: vec3f,
}

var<private> frame: Frame;

fn look() {
    frame = Frame(shots[slot].centre, shots[slot].tangent, shots[slot].bitangent, shots[slot].normal);
}

fn to_local(point: vec3f) -> vec3f {
    return turn(point - frame.centre);
}

fn turn(d: vec3f) -> vec3f {
    return vec3f(dot(frame.tangent, d), dot(frame.bitangent, d), dot(frame.normal, d));
}

fn to_world(v: vec3f) -> vec3f {
    return frame.tangent * v.x + frame.bitangent * v.y + frame.normal * v.z;
}
