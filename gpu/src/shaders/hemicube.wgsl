// The hemicube unfolded: its top (side 0) is the inner half of the square, the four half sides (1 to
// 4: x, −x, y, −y) adjoin it, the square's corners stay empty.

fn facing_side(p: vec2f) -> u32 {
    if abs(p.x) >= abs(p.y) {
        return select(2u, 1u, p.x >= 0.0);
    }
    return select(4u, 3u, p.y >= 0.0);
}

// The direction in which a side lies.
fn side_axis(side: u32) -> vec2f {
    let sign = select(-1.0, 1.0, (side & 1u) == 1u);
    return select(vec2f(0.0, sign), vec2f(sign, 0.0), side <= 2u);
}

// p turned so that the axis e is x.
fn rotate_to_axis(e: vec2f, p: vec2f) -> vec2f {
    return vec2f(e.x * p.x + e.y * p.y, e.x * p.y - e.y * p.x);
}

fn rotate_from_axis(e: vec2f, q: vec2f) -> vec2f {
    return vec2f(e.x * q.x - e.y * q.y, e.x * q.y + e.y * q.x);
}

// Height above the plane that a side (or the disc) is parallel to: where it is positive, rays go there.
fn side_height(side: u32, v: vec3f) -> f32 {
    if side == 0u {
        return v.z;
    }
    return rotate_to_axis(side_axis(side), v.xy).x;
}

// The image of v on the plane of a side, as if the side lay to the right.
fn project_to_side(side: u32, v: vec3f, height: f32) -> vec2f {
    if side == 0u {
        return v.xy / (2.0 * height);
    }
    let y = rotate_to_axis(side_axis(side), v.xy).y;
    return vec2f(1.0 - v.z / (2.0 * height), y / (2.0 * height));
}

// From the plane of a side to the square.
fn unfold_side(side: u32, q: vec2f) -> vec2f {
    if side == 0u {
        return q;
    }
    return rotate_from_axis(side_axis(side), q);
}

// The part (low, high) of its plane that a side fills; all of the square for a disc.
fn side_extent(side: u32) -> vec4f {
    if PROJECTION != PROJECTION_HEMICUBE {
        return vec4f(-1.0, -1.0, 1.0, 1.0);
    }
    if side == 0u {
        return vec4f(-0.5, -0.5, 0.5, 0.5);
    }
    let y = 0.5 + 2.0 * GUTTER_PIXELS / f32(IMAGE_SIZE);
    return vec4f(0.5, -y, 1.0, y);
}
