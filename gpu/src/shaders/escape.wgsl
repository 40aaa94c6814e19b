// The share of the shooter's cosine hemisphere that meets no front, counted once for each cell.
// Twin: cpu/src/escape.rs.

@group(0) @binding(0) var<storage, read> faces: array<Face>;
@group(0) @binding(1) var<storage, read> shot: Shot;
@group(0) @binding(2) var<uniform> params: Params;
@group(0) @binding(3) var<storage, read> directions: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> lost: array<atomic<u32>>;  // a cell's directions
@group(0) @binding(5) var<storage, read> points: array<Point>;

@compute @workgroup_size(LANES)
fn escape(@builtin(global_invocation_id) id: vec3u) {
    if id.x < DIRECTIONS && !meets_front(start(id.x), to_world(directions[id.x].xyz)) {
        atomicAdd(&lost[shot.cell], 1u);
    }
}

// Where direction `k` starts: the points take turns, but light leaves from open ones only.
fn start(k: u32) -> vec3f {
    let n = params.samples;
    let first = shot.cell * n;
    var at = k % n;
    for (var i = 0u; i < n && points[first + at].cover != COVER_OPEN; i++) {
        at = (at + 1u) % n;
    }
    return points[first + at].position;
}

fn meets_front(origin: vec3f, direction: vec3f) -> bool {
    var front = MISS;
    var back = MISS;
    for (var face = 0u; face < params.faces; face++) {
        if faces[face].sheet == shot.sheet {
            continue;
        }
        let hit = intersect(face, origin, direction);
        if hit.facing < 0.0 {
            if hit.t >= -CONTACT && hit.inside >= -OUTLINE {
                front = min(front, hit.t);
            }
        } else if hit.t > CONTACT && hit.inside >= OUTLINE {
            back = min(back, hit.t);
        }
    }
    // At a shared edge front and back are equally near: the front takes the light.
    return front < MISS && front <= back + CONTACT;
}
