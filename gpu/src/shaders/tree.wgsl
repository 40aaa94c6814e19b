// A ray's way through the CPU's tree of eight quantised boxes a node (Ylitie, Karras & Laine 2017).
// What its leaves are asked, rays.wgsl and escape.wgsl say. Twin: obvhs.

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

// Groups of children yet to visit: the first one's number, and the hit ones over which of them are
// nodes.
var<private> waiting: array<vec2u, RAY_STACK>;
var<private> depth: u32;
var<private> siblings: vec2u;

fn ray(origin: vec3f, direction: vec3f, reach: f32) -> Ray {
    return Ray(origin, vec3f(inverse(direction.x), inverse(direction.y), inverse(direction.z)), reach);
}

fn inverse(x: f32) -> f32 {
    if abs(x) < 1e-30 {
        return select(1e30, -1e30, x < 0.0);
    }
    return 1.0 / x;
}

fn byte(words: vec2u, k: u32) -> u32 {
    return (words[k >> 2u] >> ((k & 3u) * 8u)) & 0xffu;
}

// Bounds of child k along one axis, near and far as the ray comes.
fn slab(bounds: vec4u, k: u32, scale: f32, start: f32) -> vec2f {
    let low = f32(byte(bounds.xy, k)) * scale + start;
    let high = f32(byte(bounds.zw, k)) * scale + start;
    return vec2f(min(low, high), max(low, high));
}

fn begin() {
    depth = 0u;
    siblings = vec2u(0u, 0x101u);
}

// The node to visit now; its siblings wait.
fn visit() -> u32 {
    let child = firstTrailingBit(siblings.y >> 8u);
    siblings.y &= ~(0x100u << child);
    let below = countOneBits(siblings.y & 0xffu & ((1u << child) - 1u));
    let node = siblings.x + below;
    if (siblings.y >> 8u) != 0u && depth < RAY_STACK {
        waiting[depth] = siblings;
        depth++;
    }
    return node;
}

fn inner(node: u32) -> u32 {
    return nodes[node].scale >> 24u;
}

// The children that the ray meets, a bit each.
fn met(node: u32, ray: Ray) -> u32 {
    let exponents = nodes[node].scale;
    let scale = vec3f(
        bitcast<f32>((exponents & 0xffu) << 23u),
        bitcast<f32>(((exponents >> 8u) & 0xffu) << 23u),
        bitcast<f32>(((exponents >> 16u) & 0xffu) << 23u),
    ) * ray.inverse;
    let start = (nodes[node].origin - ray.origin) * ray.inverse;
    var hits = 0u;
    for (var k = 0u; k < 8u; k++) {
        let x = slab(nodes[node].x, k, scale.x, start.x);
        let y = slab(nodes[node].y, k, scale.y, start.y);
        let z = slab(nodes[node].z, k, scale.z, start.z);
        let near = max(max(x.x, y.x), max(z.x, 0.0));
        let far = min(min(x.y, y.y), min(z.y, ray.reach));
        if near <= far && byte(nodes[node].kinds, k) != 0u {
            hits |= 1u << k;
        }
    }
    return hits;
}

// The primitives of a leaf, first and count: in unary over the offset of the first.
fn leaf(node: u32, child: u32) -> vec2u {
    let kind = byte(nodes[node].kinds, child);
    return vec2u(nodes[node].primitives + (kind & 31u), countOneBits(kind >> 5u));
}

// Goes on to the children that are nodes, or to who waits; false where nobody does.
fn descend(node: u32, hits: u32) -> bool {
    let nodes_hit = hits & inner(node);
    if nodes_hit != 0u {
        siblings = vec2u(nodes[node].children, nodes_hit << 8u | inner(node));
        return true;
    }
    if depth == 0u {
        return false;
    }
    depth--;
    siblings = waiting[depth];
    return true;
}
