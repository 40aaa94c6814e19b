// F of each spot of the pairs that are asked. Twins: cpu/src/hierarchy/link.rs, common/src/form_factor.rs.

@group(0) @binding(0) var<storage, read> shots: array<Shot>;
@group(0) @binding(1) var<storage, read> spots: array<Spot>;
@group(0) @binding(2) var<storage, read> blocks: array<Block>;
@group(0) @binding(3) var<storage, read> pairs: array<Pair>;
@group(0) @binding(4) var<storage, read_write> lanes: array<Lane>;
@group(0) @binding(5) var<storage, read> work: array<u32>;

// Lambert's sum of a node that lies above the horizon: nothing to clip.
fn polygon_above(position: vec3f, normal: vec3f) -> f32 {
    let a = shots[slot].corners[0].xyz - position;
    let b = shots[slot].corners[1].xyz - position;
    let c = shots[slot].corners[2].xyz - position;
    let d = shots[slot].corners[3].xyz - position;
    var sum = 0.0;
    sum += edge(a, b, normal, false);
    sum += edge(b, c, normal, false);
    sum += edge(c, d, normal, false);
    sum += edge(d, a, normal, false);
    return max(-sum / (2.0 * PI), 0.0);
}

fn lambert(position: vec3f, normal: vec3f) -> f32 {
    let d = position - shots[slot].middle;
    let height = dot(shots[slot].normal, d);
    let r2 = dot(d, d);
    let r = sqrt(r2);
    var f = polygon_above(position, normal);
    if remote(r2, shots[slot].radius) {
        f = disc(height / r, max(-dot(normal, d) / r, 0.0), r2, shots[slot].area, 0.0);
    }
    return select(f, 0.0, height <= CONTACT);
}

// The mean of F over `places`² of a spot, or F at its centre.
fn factor(spot: u32, places: u32, whole: bool) -> f32 {
    let normal = spots[spot].normal;
    let triangle = is_triangle(spot);
    var sum = 0.0;
    for (var place = 0u; place < places * places; place++) {
        var p = vec4f(spots[spot].centre, 1.0);
        if places > 1u {
            p = spot_point(spot, place_uv(place, places, triangle));
        }
        if whole {
            sum += lambert(p.xyz, normal) * p.w;
        } else {
            sum += form_factor(shots[slot].middle, p.xyz, normal, 0.0) * p.w;
        }
    }
    return sum / f32(places * places);
}

fn write(pair: u32, l: u32, whole: bool) {
    slot = pairs[pair].node;
    let block = pairs[pair].block;
    // The last spot stands for those that there are not.
    let f = factor(block * SPOTS + l, pairs[pair].places, whole);
    lanes[pair * SPOTS + l].factor = select(0.0, f, l < blocks[block].count);
}

// Those of pairs whose node lies above the horizon of every spot.
@compute @workgroup_size(LANES)
fn plain(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let at = flat(group, groups) * LANES + lane;
    if at / SPOTS < work[0] {
        write(work[2u + at / SPOTS], at % SPOTS, true);
    }
}

// Those of the others, at the end of the list.
@compute @workgroup_size(LANES)
fn clipped(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let at = flat(group, groups) * LANES + lane;
    if at / SPOTS < work[1] {
        write(work[arrayLength(&work) - 1u - at / SPOTS], at % SPOTS, false);
    }
}
