// Refines pairs of a node and a block: skip, subdivide or link; a thread per pair. Between its four steps
// the spots of the pairs in the work lists compute form factors and visibility.

@group(0) @binding(0) var<storage, read> shots: array<Shot>;
@group(0) @binding(1) var<uniform> request: Request;
@group(0) @binding(2) var<storage, read> radiosity: array<Radiosity>;
@group(0) @binding(3) var<storage, read> blocks: array<Block>;
@group(0) @binding(4) var<storage, read> lanes: array<Lane>;
@group(0) @binding(5) var<storage, read_write> pairs: array<Pair>;
@group(0) @binding(6) var<storage, read> counts: array<u32>;
// Work list of the next stage, in any order: number of pairs from the front and from the end, and their
// indices; and workgroups over their spots.
@group(0) @binding(7) var<storage, read_write> work: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> dispatches: array<atomic<u32>>;

// Appends a pair to the work list, at its front or at its end.
fn append_work(pair: u32, last: bool) {
    let list = select(0u, 1u, last);
    let n = atomicAdd(&work[list], 1u);
    if n % (PATCH_SUM_LANES / BLOCK_SPOTS) == 0u {
        atomicAdd(&dispatches[3u * list], 1u);
    }
    atomicStore(&work[select(2u + n, arrayLength(&work) - 1u - n, last)], pair);
}

// Tests whether a node lies above the horizon of every spot by so much that nothing is to be clipped.
fn is_above_horizon(node: u32, block: u32) -> bool {
    let plane = blocks[block].plane;
    var lowest = MISS_DISTANCE;
    var highest = -MISS_DISTANCE;
    for (var k = 0u; k < 4u; k++) {
        let height = dot(plane.xyz, shots[node].corners[k].xyz) - plane.w;
        lowest = min(lowest, height);
        highest = max(highest, height);
    }
    let d = shots[node].middle - blocks[block].middle;
    let farthest = sqrt(dot(d, d)) + blocks[block].reach;
    return lowest > -CONTACT_DISTANCE / 2.0 && highest > 1.5 * CONTACT_DISTANCE
        && highest - CONTACT_DISTANCE > 1.01 * MAX_GRAZING_HEIGHT_RATIO * farthest;
}

// Visible fraction of a pair, over its spots.
fn visible_fraction(pair: u32) -> f32 {
    var visible = 0.0;
    var all = 0.0;
    for (var at = pair * BLOCK_SPOTS; at < (pair + 1u) * BLOCK_SPOTS; at++) {
        visible += lanes[at].weight;
        all += lanes[at].known;
    }
    if all <= 0.0 {
        return 0.0;
    }
    return visible / all;
}

// Tests whether a node has no radiosity.
fn is_dark(k: u32) -> bool {
    return all(radiosity[k].mean == vec3f(0.0)) && all(radiosity[k].slope_x == vec3f(0.0))
        && all(radiosity[k].slope_y == vec3f(0.0)) && all(radiosity[k].rest == vec3f(0.0));
}

// Light that a block would reflect of `light` at F = 1, over the RMS of the reflected light.
fn reflected_light(light: vec3f, block: u32) -> f32 {
    let own = abs(light) * blocks[block].scale;
    return max(max(own.x, own.y), own.z);
}

// Tests whether a pair's node has no children.
fn is_leaf(pair: u32) -> bool {
    return shots[pairs[pair].node].count == 0u;
}

// Step 1: skips or subdivides nodes by the variation of their radiosity; the others need form factors.
@compute @workgroup_size(PATCH_SUM_LANES)
fn refine_by_source(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u, @builtin(local_invocation_index) lane: u32) {
    let pair = flat_index(group, groups) * PATCH_SUM_LANES + lane;
    if pair >= counts[0] {
        return;
    }
    let node = pairs[pair].node;
    let block = pairs[pair].block;
    pairs[pair].samples = 0u;
    pairs[pair].known = 0u;
    pairs[pair].state = PAIR_SKIP;
    if shots[node].area <= 0.0 || is_dark(node) {
        return;
    }
    var bound = vec4f(0.0);
    for (var at = pair * BLOCK_SPOTS; at < (pair + 1u) * BLOCK_SPOTS; at++) {
        bound = max(bound, lanes[at].bound);
    }
    if bound.x <= 0.0 {
        return;
    }
    let mean = reflected_light(radiosity[node].mean, block);
    let rest = reflected_light(radiosity[node].rest, block);
    let slope = max(reflected_light(radiosity[node].slope_x, block), reflected_light(radiosity[node].slope_y, block)) * shots[node].radius;
    let varies = rest * bound.y + slope * bound.z;
    if varies > request.source && !is_leaf(pair) {
        pairs[pair].state = PAIR_SUBDIVIDE;
        return;
    }
    pairs[pair].state = PAIR_PENDING;
    pairs[pair].factor = bound.x;
    pairs[pair].mean = mean;
    pairs[pair].rest = rest;
    pairs[pair].places = receiver_points_per_side(bound.w, mean + rest, request.near);
    append_work(pair, !is_above_horizon(node, block));
}

// Step 2: limits the bound by the form factors, and requests the first samples.
@compute @workgroup_size(PATCH_SUM_LANES)
fn start_sampling(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u, @builtin(local_invocation_index) lane: u32) {
    let pair = flat_index(group, groups) * PATCH_SUM_LANES + lane;
    if pair >= counts[0] || pairs[pair].state != PAIR_PENDING {
        return;
    }
    var most = 0.0;
    for (var at = pair * BLOCK_SPOTS; at < (pair + 1u) * BLOCK_SPOTS; at++) {
        most = max(most, lanes[at].factor);
    }
    if most <= 0.0 {
        pairs[pair].state = PAIR_SKIP;
        return;
    }
    pairs[pair].factor = min(pairs[pair].factor, MAX_PEAK_TO_MEAN * most);
    pairs[pair].samples = SAMPLES_FIRST;
    append_work(pair, false);
}

// Step 3: requests more samples where one is not enough.
@compute @workgroup_size(PATCH_SUM_LANES)
fn request_samples(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u, @builtin(local_invocation_index) lane: u32) {
    let pair = flat_index(group, groups) * PATCH_SUM_LANES + lane;
    if pair >= counts[0] || pairs[pair].state != PAIR_PENDING {
        return;
    }
    pairs[pair].known = SAMPLES_FIRST;
    let shines = pairs[pair].factor * (pairs[pair].mean + pairs[pair].rest);
    pairs[pair].samples = 0u;
    if required_samples(shines, visible_fraction(pair), request.visibility) > ONE_SAMPLE_LIMIT {
        pairs[pair].samples = SAMPLES_SECOND;
        append_work(pair, false);
    }
}

// Step 4: subdivides nodes by their visibility; links the others, with as many samples as they need.
@compute @workgroup_size(PATCH_SUM_LANES)
fn refine_by_visibility(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u, @builtin(local_invocation_index) lane: u32) {
    let pair = flat_index(group, groups) * PATCH_SUM_LANES + lane;
    if pair >= counts[0] || pairs[pair].state != PAIR_PENDING {
        return;
    }
    pairs[pair].known = max(pairs[pair].known, pairs[pair].samples);
    pairs[pair].samples = 0u;
    let shines = pairs[pair].factor * (pairs[pair].mean + pairs[pair].rest);
    let seen = visible_fraction(pair);
    let hides = pairs[pair].factor * pairs[pair].rest * max(visibility_deviation(seen), 0.125) / request.near;
    let samples = required_samples(shines, seen, request.visibility);
    if !is_leaf(pair) && (hides > 1.0 || samples > f32(SAMPLES_SUBDIVIDE)) {
        pairs[pair].state = PAIR_SUBDIVIDE;
        return;
    }
    let edge = shines * visibility_deviation(seen) > request.edge;
    pairs[pair].state = select(PAIR_LINK, PAIR_EDGE, edge);
    if samples > f32(SAMPLES_SECOND) {
        pairs[pair].samples = u32(min(ceil(samples), f32(SAMPLES_MAX)));
        append_work(pair, false);
    }
}
