// What is done about a node at a block: nothing, its parts, or a link; a thread per pair of them. Between
// its steps the spots ask. Twins: cpu/src/hierarchy/gather.rs, cpu/src/hierarchy/link.rs.

@group(0) @binding(0) var<storage, read> shots: array<Shot>;
@group(0) @binding(1) var<uniform> asked: Asked;
@group(0) @binding(2) var<storage, read> glows: array<Glow>;
@group(0) @binding(3) var<storage, read> blocks: array<Block>;
@group(0) @binding(4) var<storage, read> lanes: array<Lane>;
@group(0) @binding(5) var<storage, read_write> pairs: array<Pair>;
@group(0) @binding(6) var<storage, read> counts: array<u32>;
// Pairs of which every spot is asked next, in any order: how many from the front and from the end, and
// their numbers; and workgroups over their spots.
@group(0) @binding(7) var<storage, read_write> work: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> dispatches: array<atomic<u32>>;

fn is_dark(k: u32) -> bool {
    return all(glows[k].mean == vec3f(0.0)) && all(glows[k].slope_x == vec3f(0.0))
        && all(glows[k].slope_y == vec3f(0.0)) && all(glows[k].rest == vec3f(0.0));
}

// Of the RMS of the reflected light, what a block would reflect of `light` at F = 1.
fn share(light: vec3f, block: u32) -> f32 {
    let own = abs(light) * blocks[block].scale;
    return max(max(own.x, own.y), own.z);
}

// The share of the points that see each other.
fn seen_of(pair: u32) -> f32 {
    var of_seen = 0.0;
    var of_all = 0.0;
    for (var at = pair * SPOTS; at < (pair + 1u) * SPOTS; at++) {
        of_seen += lanes[at].weight;
        of_all += lanes[at].known;
    }
    if of_all <= 0.0 {
        return 0.0;
    }
    return of_seen / of_all;
}

// Whether a node lies above the horizon of every spot, well enough to sum it plainly.
fn is_above(node: u32, block: u32) -> bool {
    let plane = blocks[block].plane;
    var lowest = MISS;
    var highest = -MISS;
    for (var k = 0u; k < 4u; k++) {
        let height = dot(plane.xyz, shots[node].corners[k].xyz) - plane.w;
        lowest = min(lowest, height);
        highest = max(highest, height);
    }
    let d = shots[node].middle - blocks[block].middle;
    let farthest = sqrt(dot(d, d)) + blocks[block].reach;
    return lowest > -CONTACT / 2.0 && highest > 1.5 * CONTACT
        && highest - CONTACT > 1.01 * LOW * farthest;
}

fn append(pair: u32, last: bool) {
    let list = select(0u, 1u, last);
    let n = atomicAdd(&work[list], 1u);
    if n % (LANES / SPOTS) == 0u {
        atomicAdd(&dispatches[3u * list], 1u);
    }
    atomicStore(&work[select(2u + n, arrayLength(&work) - 1u - n, last)], pair);
}

fn whole(pair: u32) -> bool {
    return shots[pairs[pair].node].count == 0u;
}

@compute @workgroup_size(LANES)
fn weigh(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u, @builtin(local_invocation_index) lane: u32) {
    let pair = flat(group, groups) * LANES + lane;
    if pair >= counts[0] {
        return;
    }
    let node = pairs[pair].node;
    let block = pairs[pair].block;
    pairs[pair].samples = 0u;
    pairs[pair].known = 0u;
    pairs[pair].state = PAIR_NOTHING;
    if shots[node].area <= 0.0 || is_dark(node) {
        return;
    }
    var bound = vec4f(0.0);
    for (var at = pair * SPOTS; at < (pair + 1u) * SPOTS; at++) {
        bound = max(bound, lanes[at].bound);
    }
    if bound.x <= 0.0 {
        return;
    }
    let mean = share(glows[node].mean, block);
    let rest = share(glows[node].rest, block);
    let slope = max(share(glows[node].slope_x, block), share(glows[node].slope_y, block)) * shots[node].radius;
    let varies = rest * bound.y + slope * bound.z;
    if varies > asked.source && !whole(pair) {
        pairs[pair].state = PAIR_CUT;
        return;
    }
    pairs[pair].state = PAIR_ASKED;
    pairs[pair].factor = bound.x;
    pairs[pair].mean = mean;
    pairs[pair].rest = rest;
    pairs[pair].places = places(bound.w, mean + rest, asked.near);
    append(pair, !is_above(node, block));
}

@compute @workgroup_size(LANES)
fn first(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u, @builtin(local_invocation_index) lane: u32) {
    let pair = flat(group, groups) * LANES + lane;
    if pair >= counts[0] || pairs[pair].state != PAIR_ASKED {
        return;
    }
    var most = 0.0;
    for (var at = pair * SPOTS; at < (pair + 1u) * SPOTS; at++) {
        most = max(most, lanes[at].factor);
    }
    if most <= 0.0 {
        pairs[pair].state = PAIR_NOTHING;
        return;
    }
    pairs[pair].factor = min(pairs[pair].factor, EDGE * most);
    pairs[pair].samples = SAMPLES_FIRST;
    append(pair, false);
}

@compute @workgroup_size(LANES)
fn again(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u, @builtin(local_invocation_index) lane: u32) {
    let pair = flat(group, groups) * LANES + lane;
    if pair >= counts[0] || pairs[pair].state != PAIR_ASKED {
        return;
    }
    pairs[pair].known = SAMPLES_FIRST;
    let shines = pairs[pair].factor * (pairs[pair].mean + pairs[pair].rest);
    pairs[pair].samples = 0u;
    if needed(shines, seen_of(pair), asked.visibility) > LITTLE {
        pairs[pair].samples = SAMPLES_MORE;
        append(pair, false);
    }
}

@compute @workgroup_size(LANES)
fn enough(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u, @builtin(local_invocation_index) lane: u32) {
    let pair = flat(group, groups) * LANES + lane;
    if pair >= counts[0] || pairs[pair].state != PAIR_ASKED {
        return;
    }
    pairs[pair].known = max(pairs[pair].known, pairs[pair].samples);
    pairs[pair].samples = 0u;
    let shines = pairs[pair].factor * (pairs[pair].mean + pairs[pair].rest);
    let seen = seen_of(pair);
    let hides = pairs[pair].factor * pairs[pair].rest * max(mixed(seen), 0.125) / asked.source;
    let left = needed(shines, seen, asked.visibility);
    if !whole(pair) && (hides > 1.0 || left > f32(SAMPLES_CUT)) {
        pairs[pair].state = PAIR_CUT;
        return;
    }
    let edge = shines * mixed(seen) > asked.source;
    pairs[pair].state = select(PAIR_LINK, PAIR_EDGE, edge);
    if left > f32(SAMPLES_MORE) {
        pairs[pair].samples = u32(min(ceil(left), f32(SAMPLES_MOST)));
        append(pair, false);
    }
}
