// Visibility between a point of the shooting patch and one of a texel, by a ray through the BVH.

@group(0) @binding(7) var<storage, read> nodes: array<Node>;
@group(0) @binding(8) var<storage, read> primitives: array<u32>;

fn blocks_segment(face: u32, origin: vec3f, position: vec3f, sheet: u32) -> bool {
    if faces[face].sheet == shots[slot].sheet || faces[face].sheet == sheet {
        return false;
    }
    let hit = intersect_face(face, origin, (position - origin) / RAY_REACH);
    return stops_ray(hit, RAY_REACH) && !touches_plane(face, origin) && !touches_plane(face, position);
}

// Visibility in one traversal; where captured shots are compared it continues through objects.
fn find_sight(origin: vec3f, position: vec3f, face: u32) -> u32 {
    let continues = (params.rule & CAPTURED_BIT) != 0u && face < params.room;
    var free = SIGHT_CLEAR;
    let sheet = faces[face].sheet;
    let ray = make_ray(origin, (position - origin) / RAY_REACH, SEGMENT_END_FRACTION * RAY_REACH);
    begin_traversal();
    // No node is visited twice.
    for (var visits = 0u; visits < arrayLength(&nodes); visits++) {
        let node = next_node();
        let hits = hit_children(node, ray);
        for (var leaves = hits & ~inner_children(node); leaves != 0u; leaves &= leaves - 1u) {
            let range = leaf_primitives(node, firstTrailingBit(leaves));
            for (var j = 0u; j < range.y; j++) {
                let primitive = primitives[range.x + j];
                if blocks_segment(primitive, origin, position, sheet) {
                    if !continues || primitive < params.room {
                        return SIGHT_BLOCKED;
                    }
                    free = SIGHT_HIDDEN_BY_OBJECT;
                }
            }
        }
        if !continue_traversal(node, hits) {
            return free;
        }
    }
    return free;
}
