// Visibility of the shooter from a texel, looked up in the shooter's item buffer, a tile of the texture.

@group(0) @binding(7) var with_objects: texture_2d<u32>;
@group(0) @binding(8) var without_objects: texture_2d<u32>;

// Visibility between the shooter's point and the texel: SIGHT_BLOCKED, SIGHT_HIDDEN_BY_OBJECT or SIGHT_CLEAR. Nothing of the
// room is visible with the objects that was not visible without them.
fn find_sight(centre: vec3f, position: vec3f, face: u32) -> u32 {
    frame = shooter_frame();
    let differ = params.room < params.faces && shots[slot].face < params.room;
    var before = true;
    if differ && face < params.room {
        before = is_visible(without_objects, position, face);
    }
    if !before {
        return SIGHT_BLOCKED;
    }
    if is_visible(with_objects, position, face) {
        return SIGHT_CLEAR;
    }
    return select(SIGHT_BLOCKED, SIGHT_HIDDEN_BY_OBJECT, differ);
}

// Table 1, line 6: the nine pixels name the faces that may occlude the texel; those are intersected.
fn is_visible(item_buffer: texture_2d<u32>, position: vec3f, face: u32) -> bool {
    let p = pixel_position(project_direction(to_local(position)));
    let last = i32(IMAGE_SIZE) - 1;
    let x = clamp(i32(floor(p.x)), 0, last);
    let y = clamp(i32(floor(p.y)), 0, last);
    let tile = vec2i(tile_index()) * i32(IMAGE_SIZE);
    var found = false;
    var tested = 0u;
    for (var j = max(y - LOOKUP_REACH, 0); j <= min(y + LOOKUP_REACH, last); j++) {
        for (var i = max(x - LOOKUP_REACH, 0); i <= min(x + LOOKUP_REACH, last); i++) {
            let id = textureLoad(item_buffer, tile + vec2i(i, j), 0).x;
            if id == face + 1u || lies_on_face(id, position) {
                found = true;
            } else if LOOKUP_REACH > 0 && id != 0u && id != tested {
                if blocks_segment(id - 1u, position, face) {
                    return false;
                }
                tested = id;
            }
        }
    }
    return found;
}

// The far side of a thin wall, drawn at the same depth.
fn lies_on_face(id: u32, position: vec3f) -> bool {
    return id != 0u && touches_plane(id - 1u, position);
}

fn blocks_segment(occluder: u32, position: vec3f, face: u32) -> bool {
    if faces[occluder].sheet == faces[face].sheet {
        return false;
    }
    let hit = intersect_face(occluder, frame.centre, position - frame.centre);
    return stops_ray(hit, 1.0) && !touches_plane(occluder, frame.centre) && !touches_plane(occluder, position);
}
