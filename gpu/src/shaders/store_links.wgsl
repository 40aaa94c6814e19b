// Appends a level's links to those of the levels before.

@group(0) @binding(0) var<storage, read> pairs: array<Pair>;
@group(0) @binding(1) var<storage, read> lanes: array<Lane>;
@group(0) @binding(2) var<storage, read> counts: array<u32>;
@group(0) @binding(3) var<storage, read> offsets: array<vec2u>;
@group(0) @binding(4) var<storage, read> totals: array<u32>;
@group(0) @binding(5) var<storage, read_write> ends: array<vec2u>;     // block and node of each
@group(0) @binding(6) var<storage, read_write> links: array<vec4f>;    // w, w·o

@compute @workgroup_size(PATCH_SUM_LANES)
fn store_links(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let at = flat_index(group, groups) * PATCH_SUM_LANES + lane;
    let pair = at / BLOCK_SPOTS;
    if pair >= counts[0] || totals[1] != 0u {
        return;
    }
    let state = pairs[pair].state;
    if state != PAIR_LINK && state != PAIR_EDGE {
        return;
    }
    let link = offsets[pair].y;
    ends[link] = vec2u(pairs[pair].block, pairs[pair].node);
    links[link * BLOCK_SPOTS + at % BLOCK_SPOTS] = vec4f(lanes[at].weight, lanes[at].along, 0.0);
}
