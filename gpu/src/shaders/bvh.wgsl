// Traversal of the BVH, eight quantised boxes a node (Ylitie, Karras & Laine 2017). rays.wgsl and
// escape.wgsl intersect the primitives of the leaves.

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

// From origin, as far as reach × direction; inverse is 1/direction.
struct Ray {
    origin: vec3f,
    inverse: vec3f,
    reach: f32,
}

// Groups of children yet to visit: the number of the first, and two bit masks, the hit ones over those that
// are nodes.
var<private> waiting: array<vec2u, RAY_STACK_LEVELS>;
var<private> depth: u32;
var<private> siblings: vec2u;

// Ray from `origin` to origin + reach × direction.
fn make_ray(origin: vec3f, direction: vec3f, reach: f32) -> Ray {
    return Ray(origin, vec3f(safe_inverse(direction.x), safe_inverse(direction.y), safe_inverse(direction.z)), reach);
}

// 1/x, finite for every x.
fn safe_inverse(x: f32) -> f32 {
    if abs(x) < 1e-30 {
        return select(1e30, -1e30, x < 0.0);
    }
    return 1.0 / x;
}

// Byte `k` of eight.
fn packed_byte(words: vec2u, k: u32) -> u32 {
    return (words[k >> 2u] >> ((k & 3u) * 8u)) & 0xffu;
}

// Bounds of child k along one axis, near and far as the ray comes.
fn slab_interval(bounds: vec4u, k: u32, scale: f32, start: f32) -> vec2f {
    let low = f32(packed_byte(bounds.xy, k)) * scale + start;
    let high = f32(packed_byte(bounds.zw, k)) * scale + start;
    return vec2f(min(low, high), max(low, high));
}

// Starts at the root.
fn begin_traversal() {
    depth = 0u;
    siblings = vec2u(0u, 0x101u);
}

// Takes the next node of the current group; its siblings wait.
fn next_node() -> u32 {
    let child = firstTrailingBit(siblings.y >> 8u);
    siblings.y &= ~(0x100u << child);
    let below = countOneBits(siblings.y & 0xffu & ((1u << child) - 1u));
    let node = siblings.x + below;
    if (siblings.y >> 8u) != 0u && depth < RAY_STACK_LEVELS {
        waiting[depth] = siblings;
        depth++;
    }
    return node;
}

// Children that are nodes, a bit each.
fn inner_children(node: u32) -> u32 {
    return nodes[node].scale >> 24u;
}

// Children whose boxes the ray meets, a bit each.
fn hit_children(node: u32, ray: Ray) -> u32 {
    let exponents = nodes[node].scale;
    let scale = vec3f(
        bitcast<f32>((exponents & 0xffu) << 23u),
        bitcast<f32>(((exponents >> 8u) & 0xffu) << 23u),
        bitcast<f32>(((exponents >> 16u) & 0xffu) << 23u),
    ) * ray.inverse;
    let start = (nodes[node].origin - ray.origin) * ray.inverse;
    var hits = 0u;
    for (var k = 0u; k < 8u; k++) {
        let x = slab_interval(nodes[node].x, k, scale.x, start.x);
        let y = slab_interval(nodes[node].y, k, scale.y, start.y);
        let z = slab_interval(nodes[node].z, k, scale.z, start.z);
        let near = max(max(x.x, y.x), max(z.x, 0.0));
        let far = min(min(x.y, y.y), min(z.y, ray.reach));
        if near <= far && packed_byte(nodes[node].kinds, k) != 0u {
            hits |= 1u << k;
        }
    }
    return hits;
}

// The primitives of a leaf, first and count: in unary over the offset of the first.
fn leaf_primitives(node: u32, child: u32) -> vec2u {
    let kind = packed_byte(nodes[node].kinds, child);
    return vec2u(nodes[node].primitives + (kind & 31u), countOneBits(kind >> 5u));
}

// Continues with the hit children that are nodes, or with the groups that wait; false when none is left.
fn continue_traversal(node: u32, hits: u32) -> bool {
    let nodes_hit = hits & inner_children(node);
    if nodes_hit != 0u {
        siblings = vec2u(nodes[node].children, (nodes_hit << 8u) | inner_children(node));
        return true;
    }
    if depth == 0u {
        return false;
    }
    depth--;
    siblings = waiting[depth];
    return true;
}
