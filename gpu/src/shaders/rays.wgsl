// What lies between a point of the shot's cell and one of a texel. Twin: common/src/rays.rs.

@group(0) @binding(7) var<storage, read> nodes: array<Node>;
@group(0) @binding(8) var<storage, read> primitives: array<u32>;

fn blocks(face: u32, origin: vec3f, position: vec3f, sheet: u32) -> bool {
    if faces[face].sheet == shots[slot].sheet || faces[face].sheet == sheet {
        return false;
    }
    let hit = intersect(face, origin, (position - origin) / RAY_REACH);
    return between(hit, RAY_REACH) && !touches(face, origin) && !touches(face, position);
}

// One traversal, which objects do not end where the texel asks how it was without them.
fn sight(origin: vec3f, position: vec3f, face: u32) -> u32 {
    let through = (params.rule & CAPTURED) != 0u && face < params.room;
    var free = CLEAR;
    let sheet = faces[face].sheet;
    let ray = ray(origin, (position - origin) / RAY_REACH, END * RAY_REACH);
    begin();
    loop {
        let node = visit();
        let hits = met(node, ray);
        for (var leaves = hits & ~inner(node); leaves != 0u; leaves &= leaves - 1u) {
            let range = leaf(node, firstTrailingBit(leaves));
            for (var j = 0u; j < range.y; j++) {
                let primitive = primitives[range.x + j];
                if blocks(primitive, origin, position, sheet) {
                    if !through || primitive < params.room {
                        return BLOCKED;
                    }
                    free = HIDDEN_BY_OBJECT;
                }
            }
        }
        if !descend(node, hits) {
            return free;
        }
    }
    return free;
}
