// Tessellation levels for the rasteriser, one workgroup: a level for every face, and for each level the
// list of its faces in face order with the arguments of its draw.

@group(0) @binding(0) var<storage, read> faces: array<Face>;
@group(0) @binding(1) var<storage, read> shots: array<Shot>;
@group(0) @binding(2) var<uniform> params: Params;
@group(0) @binding(3) var<storage, read_write> instances: array<vec2u>;  // face, parts
@group(0) @binding(4) var<storage, read_write> draws: array<u32>;        // see grids.rs

var<workgroup> levels: array<u32, SELECT_LANES>;

fn tessellation_level(face: u32) -> u32 {
    if is_hidden_face(face) {
        return HIDDEN_LEVEL;
    }
    if PROJECTION == PROJECTION_PAPER {
        return 0u;
    }
    let parts = widest_edge(face) * sqrt(f32(IMAGE_SIZE) / 16.0);
    var level = 0u;
    while level + 1u < TESSELLATION_LEVELS && f32(1u << level) < parts {
        level++;
    }
    return level;
}

fn widest_edge(face: u32) -> f32 {
    var largest = 0.0;
    for (var k = 0u; k < 4u; k++) {
        let a = unit_vector(faces[face].corners[k].xyz - frame.centre);
        let b = unit_vector(faces[face].corners[(k + 1u) & 3u].xyz - frame.centre);
        let d = b - a;
        let sine = sqrt(dot(d, d)) * 0.5;
        let cosine = sqrt(max(1.0 - sine * sine, 0.0));
        largest = max(largest, 4.0 * sine / (1.0 + cosine));
    }
    return largest;
}

@compute @workgroup_size(SELECT_LANES)
fn tessellate(@builtin(local_invocation_index) lane: u32) {
    frame = shooter_frame();
    var count = 0u;
    for (var base = 0u; base < shots[slot].drawn; base += SELECT_LANES) {
        levels[lane] = HIDDEN_LEVEL;
        if base + lane < shots[slot].drawn {
            levels[lane] = tessellation_level(base + lane);
        }
        workgroupBarrier();
        // One lane a level lists its faces: they keep their order without atomics.
        for (var k = 0u; k < SELECT_LANES && lane < TESSELLATION_LEVELS; k++) {
            if levels[k] == lane {
                instances[lane * params.faces + count] = vec2u(base + k, 1u << lane);
                count++;
            }
        }
        workgroupBarrier();
    }
    if lane < TESSELLATION_LEVELS {
        draws[lane * DRAW_WORDS + DRAW_INSTANCES] = count;
    }
}
