// Prefix sums over the pairs of a level, one workgroup: where each pair's children go in the next level,
// and its link among the links.

@group(0) @binding(0) var<storage, read> shots: array<Shot>;
@group(0) @binding(1) var<uniform> request: Request;
@group(0) @binding(2) var<storage, read> pairs: array<Pair>;
@group(0) @binding(3) var<storage, read> counts: array<u32>;
@group(0) @binding(4) var<storage, read_write> next: array<u32>;
@group(0) @binding(5) var<storage, read_write> offsets: array<vec2u>;
@group(0) @binding(6) var<storage, read_write> totals: array<u32>;   // links, 1 where pairs or links did not fit, most pairs
@group(0) @binding(7) var<storage, read_write> dispatches: array<u32>;

var<workgroup> sums: array<vec2u, SELECT_LANES>;

// Number of children and of links that a pair becomes.
fn pair_counts(pair: u32) -> vec2u {
    let state = pairs[pair].state;
    if state == PAIR_SUBDIVIDE {
        return vec2u(shots[pairs[pair].node].count, 0u);
    }
    return vec2u(0u, select(0u, 1u, state == PAIR_LINK || state == PAIR_EDGE));
}

@compute @workgroup_size(SELECT_LANES)
fn prefix_sum(@builtin(local_invocation_index) lane: u32) {
    let count = counts[0];
    let run = (count + SELECT_LANES - 1u) / SELECT_LANES;
    let end = min((lane + 1u) * run, count);
    var sum = vec2u(0u);
    for (var pair = lane * run; pair < end; pair++) {
        sum += pair_counts(pair);
    }
    sums[lane] = sum;
    workgroupBarrier();
    let links = totals[0];
    var before = vec2u(0u, links);
    for (var k = 0u; k < lane; k++) {
        before += sums[k];
    }
    for (var pair = lane * run; pair < end; pair++) {
        offsets[pair] = before;
        before += pair_counts(pair);
    }
    // All invocations have read the totals.
    storageBarrier();
    if lane != SELECT_LANES - 1u {
        return;
    }
    offsets[count] = before;
    var children = before.x;
    if children > request.pairs || before.y > request.links {
        totals[1] = 1u;
        children = 0u;
    }
    totals[0] = before.y;
    totals[2] = max(totals[2], children);
    next[0] = children;
    dispatches[0] = (children * BLOCK_SPOTS + PATCH_SUM_LANES - 1u) / PATCH_SUM_LANES;
    dispatches[1] = 1u;
    dispatches[2] = 1u;
    dispatches[3] = (children + PATCH_SUM_LANES - 1u) / PATCH_SUM_LANES;
    dispatches[4] = 1u;
    dispatches[5] = 1u;
}
