// Share of the shooter's cosine hemisphere that meets no front, counted once for each patch.

@group(0) @binding(0) var<storage, read> faces: array<Face>;
@group(0) @binding(1) var<storage, read> shots: array<Shot>;
@group(0) @binding(2) var<uniform> params: Params;
@group(0) @binding(3) var<storage, read> directions: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> escape_counts: array<atomic<u32>>;  // a patch's directions
@group(0) @binding(5) var<storage, read> points: array<Point>;
@group(0) @binding(6) var<storage, read> nodes: array<Node>;
@group(0) @binding(7) var<storage, read> primitives: array<u32>;

struct Nearest {
    front: f32,
    back: f32,
}

@compute @workgroup_size(PATCH_SUM_LANES)
fn escaped_share(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    slot = group.z;
    frame = shooter_frame();
    let k = group.x * PATCH_SUM_LANES + lane;
    let counted = (atomicLoad(&escape_counts[shots[slot].patch_index]) & COUNTED_BIT) != 0u;
    if k < ESCAPE_DIRECTION_COUNT && !counted && !meets_front(ray_origin(k), to_world(directions[k].xyz)) {
        atomicAdd(&escape_counts[shots[slot].patch_index], 1u);
    }
}

// Origin of direction `k`: the open points take turns.
fn ray_origin(k: u32) -> vec3f {
    let n = params.samples;
    let first = shots[slot].patch_index * n;
    var at = k % n;
    for (var i = 0u; i < n && points[first + at].cover != COVER_OPEN; i++) {
        at = (at + 1u) % n;
    }
    return points[first + at].position;
}

// Tests whether the nearest face along the ray shows its front. The ray starts just behind the origin: a
// front may touch the shooter.
fn meets_front(origin: vec3f, direction: vec3f) -> bool {
    var nearest = Nearest(MISS_DISTANCE, MISS_DISTANCE);
    let ray = make_ray(origin - direction * (4.0 * CONTACT_DISTANCE), direction / RAY_REACH, MISS_DISTANCE);
    begin_traversal();
    // No node is visited twice.
    for (var visits = 0u; visits < arrayLength(&nodes); visits++) {
        let node = next_node();
        let hits = hit_children(node, ray);
        for (var leaves = hits & ~inner_children(node); leaves != 0u; leaves &= leaves - 1u) {
            let range = leaf_primitives(node, firstTrailingBit(leaves));
            for (var j = 0u; j < range.y; j++) {
                nearest = nearest_crossing(nearest, primitives[range.x + j], origin, direction);
            }
        }
        if !continue_traversal(node, hits) {
            break;
        }
    }
    // At a shared edge front and back are equally near: the front takes the light.
    return nearest.front < MISS_DISTANCE && nearest.front <= nearest.back + CONTACT_DISTANCE;
}

fn nearest_crossing(nearest: Nearest, face: u32, origin: vec3f, direction: vec3f) -> Nearest {
    var next = nearest;
    if faces[face].sheet == shots[slot].sheet {
        return next;
    }
    let hit = intersect_face(face, origin, direction);
    if hit.facing < 0.0 {
        if hit.t >= -CONTACT_DISTANCE && hit.inside >= -OUTLINE_MARGIN {
            next.front = min(next.front, hit.t);
        }
    } else if hit.t > CONTACT_DISTANCE && hit.inside >= OUTLINE_MARGIN {
        next.back = min(next.back, hit.t);
    }
    return next;
}
