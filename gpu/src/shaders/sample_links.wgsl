// Samples a pair's link at one spot, from `samples` pairs of points.

@group(0) @binding(0) var<storage, read> faces: array<Face>;
@group(0) @binding(1) var<storage, read> shots: array<Shot>;
@group(0) @binding(2) var<uniform> params: Params;
@group(0) @binding(3) var<storage, read> spots: array<Spot>;
@group(0) @binding(4) var<storage, read> pairs: array<Pair>;
@group(0) @binding(5) var<storage, read_write> lanes: array<Lane>;
@group(0) @binding(6) var<storage, read> work: array<u32>;

// Tests whether light from q to p is occluded, or comes from below the spot's horizon.
fn test_occlusion(q: vec3f, p: vec3f, spot: u32, g: f32) -> bool {
    if dot(spots[spot].normal, p - q) >= CONTACT_DISTANCE {
        return true;
    }
    return g > 0.0 && find_sight(q, p, spots[spot].face) != SIGHT_CLEAR;
}

@compute @workgroup_size(PATCH_SUM_LANES)
fn sample_links(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let thread = flat_index(group, groups) * PATCH_SUM_LANES + lane;
    if thread / BLOCK_SPOTS >= work[0] {
        return;
    }
    let pair = work[2u + thread / BLOCK_SPOTS];
    let at = pair * BLOCK_SPOTS + thread % BLOCK_SPOTS;
    let samples = pairs[pair].samples;
    let node = pairs[pair].node;
    slot = node;
    let spot = pairs[pair].block * BLOCK_SPOTS + at % BLOCK_SPOTS;
    let factor = lanes[at].factor;
    let part = shots[node].area / f32(samples);
    var bits = lanes[at].blocked;
    var seen = 0.0;
    var all = 0.0;
    var along = vec2f(0.0);
    for (var s = 0u; s < samples && factor > 0.0; s++) {
        let q = outline_point(node, patch_uv(s, node));
        let p = spot_point(spot, texel_uv(s, spots[spot].lit, node));
        var g = point_weight(q.xyz, p.xyz, spots[spot].normal, part, factor) * (p.w * q.w);
        if dot(shots[node].normal, p.xyz - q.xyz) <= CONTACT_DISTANCE {
            g = 0.0;
        }
        let bit = 1u << (s & 31u);
        if s >= pairs[pair].known {
            bits[s >> 5u] &= ~bit;
            if test_occlusion(q.xyz, p.xyz, spot, g) {
                bits[s >> 5u] |= bit;
            }
        }
        all += g;
        if (bits[s >> 5u] & bit) == 0u {
            let offset = q.xyz - shots[node].middle;
            seen += g;
            along += g * vec2f(dot(offset, shots[node].tangent), dot(offset, shots[node].bitangent));
        }
    }
    var link = vec3f(0.0);
    if all > 0.0 {
        let f = factor / all;
        link = vec3f(f * seen, f * along.x, f * along.y);
    }
    lanes[at].blocked = bits;
    lanes[at].known = select(0.0, factor, all > 0.0);
    lanes[at].weight = link.x;
    lanes[at].along = link.yz;
}
