// Projection of the shooter's hemisphere to the square of the item buffer, and back.

// Column and row of the shot's item buffer: those of several shots lie side by side in one texture.
fn tile_index() -> vec2u {
    return vec2u(slot % params.tiles, slot / params.tiles);
}

// For PROJECTION_PAPER, Table 3, lines 4 to 6.
fn project_direction(v: vec3f) -> vec2f {
    if PROJECTION == PROJECTION_HEMICUBE {
        let side = select(facing_side(v.xy), 0u, v.z >= max(abs(v.x), abs(v.y)));
        return unfold_side(side, project_to_side(side, v, side_height(side, v)));
    }
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

// A direction, not always of length 1.
fn unproject_point(p: vec2f) -> vec3f {
    let q = p.x * p.x + p.y * p.y;
    if PROJECTION == PROJECTION_HEMICUBE {
        if max(abs(p.x), abs(p.y)) <= 0.5 {
            return vec3f(p * 2.0, 1.0);
        }
        let e = side_axis(facing_side(p));
        let side = rotate_to_axis(e, p);
        return vec3f(rotate_from_axis(e, vec2f(1.0, 2.0 * side.y)), 2.0 - 2.0 * side.x);
    }
    if PROJECTION == PROJECTION_STEREOGRAPHIC {
        let z = (1.0 - q) / (1.0 + q);
        return vec3f(p * (1.0 + z), z);
    }
    return vec3f(p, sqrt(max(1.0 - q, 0.0)));
}

// Whether a point of the square shows anything. The hemicube's sides go on a little beyond their
// folds, so that a lookup finds all neighbours of its pixel.
fn is_covered(p: vec2f) -> bool {
    if PROJECTION == PROJECTION_HEMICUBE {
        return min(abs(p.x), abs(p.y)) <= 0.5 + 2.0 * GUTTER_PIXELS / f32(IMAGE_SIZE);
    }
    return p.x * p.x + p.y * p.y <= 1.0;
}

fn pixel_position(p: vec2f) -> vec2f {
    let n = f32(IMAGE_SIZE);
    return vec2f((p.x * 0.5 + 0.5) * n, (0.5 - p.y * 0.5) * n);
}

fn pixel_centre(x: u32, y: u32) -> vec2f {
    let n = f32(IMAGE_SIZE);
    return vec2f((f32(x) + 0.5) / n * 2.0 - 1.0, 1.0 - (f32(y) + 0.5) / n * 2.0);
}
