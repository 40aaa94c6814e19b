// Writes the children of subdivided nodes, at their blocks: the next level's pairs.

@group(0) @binding(0) var<storage, read> shots: array<Shot>;
@group(0) @binding(1) var<storage, read> pairs: array<Pair>;
@group(0) @binding(2) var<storage, read> counts: array<u32>;
@group(0) @binding(3) var<storage, read> offsets: array<vec2u>;
@group(0) @binding(4) var<storage, read> totals: array<u32>;
@group(0) @binding(5) var<storage, read_write> next: array<Pair>;

@compute @workgroup_size(PATCH_SUM_LANES)
fn subdivide_nodes(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let pair = flat_index(group, groups) * PATCH_SUM_LANES + lane;
    if pair >= counts[0] || pairs[pair].state != PAIR_SUBDIVIDE || totals[1] != 0u {
        return;
    }
    let node = pairs[pair].node;
    for (var k = 0u; k < shots[node].count; k++) {
        next[offsets[pair].x + k].block = pairs[pair].block;
        next[offsets[pair].x + k].node = shots[node].first + k;
    }
}
