// Whether a texel sees the shooter, asked of its item buffer, a tile of the texture. Twin:
// cpu/src/twin/lookup.rs.

@group(0) @binding(7) var with_objects: texture_2d<u32>;
@group(0) @binding(8) var without_objects: texture_2d<u32>;

// How the texel sees the point: nothing of the room is seen now that was not seen without the
// objects.
fn sight(centre: vec3f, position: vec3f, face: u32) -> u32 {
    look();
    let differ = params.room < params.faces && shots[slot].face < params.room;
    var before = true;
    if differ && face < params.room {
        before = visible(without_objects, position, face);
    }
    if !before {
        return BLOCKED;
    }
    if visible(with_objects, position, face) {
        return CLEAR;
    }
    return select(BLOCKED, HIDDEN_BY_OBJECT, differ);
}

// Table 1, line 6: the nine pixels name the faces that may hide the texel; those are asked exactly.
fn visible(item_buffer: texture_2d<u32>, position: vec3f, face: u32) -> bool {
    let p = pixels(project(to_local(position)));
    let last = i32(SIZE) - 1;
    let x = clamp(i32(floor(p.x)), 0, last);
    let y = clamp(i32(floor(p.y)), 0, last);
    let tile = vec2i(tile()) * i32(SIZE);
    var found = false;
    var asked = 0u;
    for (var j = max(y - REACH, 0); j <= min(y + REACH, last); j++) {
        for (var i = max(x - REACH, 0); i <= min(x + REACH, last); i++) {
            let id = textureLoad(item_buffer, tile + vec2i(i, j), 0).x;
            if id == face + 1u || lies_on(id, position) {
                found = true;
            } else if REACH > 0 && id != 0u && id != asked {
                if blocks(id - 1u, position, face) {
                    return false;
                }
                asked = id;
            }
        }
    }
    return found;
}

// The far side of a thin wall, drawn at the same depth.
fn lies_on(id: u32, position: vec3f) -> bool {
    return id != 0u && touches(id - 1u, position);
}

fn blocks(occluder: u32, position: vec3f, face: u32) -> bool {
    if faces[occluder].sheet == faces[face].sheet {
        return false;
    }
    let hit = intersect(occluder, frame.centre, position - frame.centre);
    return between(hit, 1.0) && !touches(occluder, frame.centre) && !touches(occluder, position);
}
