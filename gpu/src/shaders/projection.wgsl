// The shooter's hemisphere on the unit disc, and back. Twin: cpu/src/projection.rs.

fn to_local(point: vec3f) -> vec3f {
    return turn(point - shot.centre);
}

fn turn(d: vec3f) -> vec3f {
    return vec3f(dot(shot.tangent, d), dot(shot.bitangent, d), dot(shot.normal, d));
}

fn to_world(v: vec3f) -> vec3f {
    return shot.tangent * v.x + shot.bitangent * v.y + shot.normal * v.z;
}

fn project(v: vec3f) -> vec2f {
    let u = v / sqrt(dot(v, v));
    if PROJECTION == PROJECTION_STEREOGRAPHIC {
        return u.xy / max(1.0 + u.z, 1e-3);
    }
    if PROJECTION == PROJECTION_HEMISPHERE {
        let s = sqrt(u.x * u.x + u.y * u.y);
        if u.z >= 0.0 {
            return u.xy;
        }
        if s > 0.0 {
            return u.xy * ((2.0 - s) / s);
        }
        return vec2f(2.0, 0.0);
    }
    return u.xy;
}

fn unproject(p: vec2f) -> vec3f {
    let q = p.x * p.x + p.y * p.y;
    if PROJECTION == PROJECTION_STEREOGRAPHIC {
        let z = (1.0 - q) / (1.0 + q);
        return vec3f(p * (1.0 + z), z);
    }
    return vec3f(p, sqrt(max(1.0 - q, 0.0)));
}

fn pixels(p: vec2f) -> vec2f {
    let n = f32(SIZE);
    return vec2f((p.x * 0.5 + 0.5) * n, (0.5 - p.y * 0.5) * n);
}

fn pixel_centre(x: u32, y: u32) -> vec2f {
    let n = f32(SIZE);
    return vec2f((f32(x) + 0.5) / n * 2.0 - 1.0, 1.0 - (f32(y) + 0.5) / n * 2.0);
}
