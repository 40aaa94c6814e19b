// A pair's link at one spot, from as many pairs of points as are asked for now. Twin:
// cpu/src/hierarchy/link.rs.

@group(0) @binding(0) var<storage, read> faces: array<Face>;
@group(0) @binding(1) var<storage, read> shots: array<Shot>;
@group(0) @binding(2) var<uniform> params: Params;
@group(0) @binding(3) var<storage, read> spots: array<Spot>;
@group(0) @binding(4) var<storage, read> pairs: array<Pair>;
@group(0) @binding(5) var<storage, read_write> lanes: array<Lane>;
@group(0) @binding(6) var<storage, read> work: array<u32>;

// Whether something stops the light from q to p, or it comes from below.
fn stopped(q: vec3f, p: vec3f, spot: u32, g: f32) -> bool {
    if dot(spots[spot].normal, p - q) >= CONTACT {
        return true;
    }
    return g > 0.0 && sight(q, p, spots[spot].face) != CLEAR;
}

@compute @workgroup_size(LANES)
fn sampled(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let thread = flat(group, groups) * LANES + lane;
    if thread / SPOTS >= work[0] {
        return;
    }
    let pair = work[2u + thread / SPOTS];
    let at = pair * SPOTS + thread % SPOTS;
    let samples = pairs[pair].samples;
    let node = pairs[pair].node;
    slot = node;
    let spot = pairs[pair].block * SPOTS + at % SPOTS;
    let factor = lanes[at].factor;
    let part = shots[node].area / f32(samples);
    var bits = lanes[at].stopped;
    var seen = 0.0;
    var all = 0.0;
    var along = vec2f(0.0);
    for (var s = 0u; s < samples && factor > 0.0; s++) {
        let q = outline_point(node, cell_uv(s, node));
        let p = spot_point(spot, texel_uv(s, spots[spot].lit, node));
        var g = weight(q.xyz, p.xyz, spots[spot].normal, part, factor) * (p.w * q.w);
        if dot(shots[node].normal, p.xyz - q.xyz) <= CONTACT {
            g = 0.0;
        }
        let bit = 1u << (s & 31u);
        if s >= pairs[pair].known {
            bits[s >> 5u] &= ~bit;
            if stopped(q.xyz, p.xyz, spot, g) {
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
    lanes[at].stopped = bits;
    lanes[at].known = select(0.0, factor, all > 0.0);
    lanes[at].weight = link.x;
    lanes[at].along = link.yz;
}
