// A level's links, put behind those of the levels before. Twin: none, the host's lists grow.

@group(0) @binding(0) var<storage, read> pairs: array<Pair>;
@group(0) @binding(1) var<storage, read> lanes: array<Lane>;
@group(0) @binding(2) var<storage, read> counts: array<u32>;
@group(0) @binding(3) var<storage, read> offsets: array<vec2u>;
@group(0) @binding(4) var<storage, read> totals: array<u32>;
@group(0) @binding(5) var<storage, read_write> ends: array<vec2u>;     // block and node of each
@group(0) @binding(6) var<storage, read_write> links: array<vec4f>;    // w, w·o

@compute @workgroup_size(LANES)
fn pack(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let at = flat(group, groups) * LANES + lane;
    let pair = at / SPOTS;
    if pair >= counts[0] || totals[1] != 0u {
        return;
    }
    let state = pairs[pair].state;
    if state != PAIR_LINK && state != PAIR_EDGE {
        return;
    }
    let link = offsets[pair].y;
    ends[link] = vec2u(pairs[pair].block, pairs[pair].node);
    links[link * SPOTS + at % SPOTS] = vec4f(lanes[at].weight, lanes[at].along, 0.0);
}
