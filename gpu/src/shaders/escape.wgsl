// The share of the shooter's cosine hemisphere that meets no front, counted once for each cell.
// Twin: cpu/src/twin/escape.rs.

@group(0) @binding(0) var<storage, read> faces: array<Face>;
@group(0) @binding(1) var<storage, read> shots: array<Shot>;
@group(0) @binding(2) var<uniform> params: Params;
@group(0) @binding(3) var<storage, read> directions: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> lost: array<atomic<u32>>;  // a cell's directions
@group(0) @binding(5) var<storage, read> points: array<Point>;
@group(0) @binding(6) var<storage, read> nodes: array<Node>;
@group(0) @binding(7) var<storage, read> primitives: array<u32>;

struct Nearest {
    front: f32,
    back: f32,
}

@compute @workgroup_size(LANES)
fn escape(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    slot = group.z;
    look();
    let k = group.x * LANES + lane;
    let counted = (atomicLoad(&lost[shots[slot].cell]) & KNOWN) != 0u;
    if k < DIRECTIONS && !counted && !meets_front(start(k), to_world(directions[k].xyz)) {
        atomicAdd(&lost[shots[slot].cell], 1u);
    }
}

// Where direction `k` starts: the points take turns, but light leaves from open ones only.
fn start(k: u32) -> vec3f {
    let n = params.samples;
    let first = shots[slot].cell * n;
    var at = k % n;
    for (var i = 0u; i < n && points[first + at].cover != COVER_OPEN; i++) {
        at = (at + 1u) % n;
    }
    return points[first + at].position;
}

// From just behind the origin: a front may touch the shooter.
fn meets_front(origin: vec3f, direction: vec3f) -> bool {
    var nearest = Nearest(MISS, MISS);
    let ray = ray(origin - direction * (4.0 * CONTACT), direction / RAY_REACH, MISS);
    begin();
    loop {
        let node = visit();
        let hits = met(node, ray);
        for (var leaves = hits & ~inner(node); leaves != 0u; leaves &= leaves - 1u) {
            let range = leaf(node, firstTrailingBit(leaves));
            for (var j = 0u; j < range.y; j++) {
                nearest = nearer(nearest, primitives[range.x + j], origin, direction);
            }
        }
        if !descend(node, hits) {
            break;
        }
    }
    // At a shared edge front and back are equally near: the front takes the light.
    return nearest.front < MISS && nearest.front <= nearest.back + CONTACT;
}

fn nearer(nearest: Nearest, face: u32, origin: vec3f, direction: vec3f) -> Nearest {
    var next = nearest;
    if faces[face].sheet == shots[slot].sheet {
        return next;
    }
    let hit = intersect(face, origin, direction);
    if hit.facing < 0.0 {
        if hit.t >= -CONTACT && hit.inside >= -OUTLINE {
            next.front = min(next.front, hit.t);
        }
    } else if hit.t > CONTACT && hit.inside >= OUTLINE {
        next.back = min(next.back, hit.t);
    }
    return next;
}
