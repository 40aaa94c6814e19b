// What lies between a point of the shot's cell and one of a texel: the CPU's tree of
// eight quantised boxes a node (Ylitie, Karras & Laine 2017), traversed. Twin: cpu/src/rays.rs.

struct Node {
    origin: vec3f,
    scale: u32,              // exponents of the boxes' grid x, y, z; which children are nodes
    children: u32,           // first child node
    primitives: u32,         // first primitive
    kinds: vec2u,            // a byte a child
    x: vec4u,                // low and high bounds, a byte a child
    y: vec4u,
    z: vec4u,
}

@group(0) @binding(7) var<storage, read> nodes: array<Node>;
@group(0) @binding(8) var<storage, read> primitives: array<u32>;

fn byte(words: vec2u, k: u32) -> u32 {
    return (words[k >> 2u] >> ((k & 3u) * 8u)) & 0xffu;
}

// Bounds of child k along one axis, near and far as the ray comes.
fn slab(bounds: vec4u, k: u32, scale: f32, start: f32) -> vec2f {
    let low = f32(byte(bounds.xy, k)) * scale + start;
    let high = f32(byte(bounds.zw, k)) * scale + start;
    return vec2f(min(low, high), max(low, high));
}

fn inverse(x: f32) -> f32 {
    if abs(x) < 1e-30 {
        return select(1e30, -1e30, x < 0.0);
    }
    return 1.0 / x;
}

fn blocks(face: u32, origin: vec3f, position: vec3f, sheet: u32) -> bool {
    if faces[face].sheet == shot.sheet || faces[face].sheet == sheet {
        return false;
    }
    let hit = intersect(face, origin, (position - origin) / RAY_REACH);
    let between = hit.t > 0.0 && hit.t < END * RAY_REACH && hit.inside >= -OUTLINE;
    return between && !touches(face, origin) && !touches(face, position);
}

// One traversal, which objects do not end where the texel asks how it was without them.
fn sight(origin: vec3f, position: vec3f, face: u32) -> u32 {
    let through = (params.rule & CAPTURED) != 0u && face < params.room;
    var free = CLEAR;
    let sheet = faces[face].sheet;
    let direction = (position - origin) / RAY_REACH;
    let inv = vec3f(inverse(direction.x), inverse(direction.y), inverse(direction.z));
    var stack: array<vec2u, RAY_STACK>;
    var depth = 0u;
    // A group: the first child's number, and the hit children over which children are nodes.
    var group = vec2u(0u, 0x101u);
    loop {
        let slot = firstTrailingBit(group.y >> 8u);
        group.y &= ~(0x100u << slot);
        let below = countOneBits(group.y & 0xffu & ((1u << slot) - 1u));
        let node = group.x + below;
        if (group.y >> 8u) != 0u && depth < RAY_STACK {
            stack[depth] = group;
            depth++;
        }
        let inner = nodes[node].scale >> 24u;
        var hits = 0u;
        let scale = vec3f(
            bitcast<f32>((nodes[node].scale & 0xffu) << 23u),
            bitcast<f32>(((nodes[node].scale >> 8u) & 0xffu) << 23u),
            bitcast<f32>(((nodes[node].scale >> 16u) & 0xffu) << 23u),
        ) * inv;
        let start = (nodes[node].origin - origin) * inv;
        for (var k = 0u; k < 8u; k++) {
            let kind = byte(nodes[node].kinds, k);
            if kind == 0u {
                continue;
            }
            let x = slab(nodes[node].x, k, scale.x, start.x);
            let y = slab(nodes[node].y, k, scale.y, start.y);
            let z = slab(nodes[node].z, k, scale.z, start.z);
            let near = max(max(x.x, y.x), max(z.x, 0.0));
            let far = min(min(x.y, y.y), min(z.y, END * RAY_REACH));
            if near > far {
                continue;
            }
            if (inner >> k & 1u) == 1u {
                hits |= 1u << k;
                continue;
            }
            // A leaf: its primitives' count in unary over the first one's offset.
            let first = nodes[node].primitives + (kind & 31u);
            let count = countOneBits(kind >> 5u);
            for (var j = 0u; j < count; j++) {
                let primitive = primitives[first + j];
                if blocks(primitive, origin, position, sheet) {
                    if !through || primitive < params.room {
                        return BLOCKED;
                    }
                    free = HIDDEN_BY_OBJECT;
                }
            }
        }
        if hits != 0u {
            group = vec2u(nodes[node].children, hits << 8u | inner);
        } else if depth > 0u {
            depth--;
            group = stack[depth];
        } else {
            return free;
        }
    }
    return free;
}
