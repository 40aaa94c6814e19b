// Form factors from the spots of a block to a node, for the pairs that may be linked.

@group(0) @binding(0) var<storage, read> shots: array<Shot>;
@group(0) @binding(1) var<storage, read> spots: array<Spot>;
@group(0) @binding(2) var<storage, read> blocks: array<Block>;
@group(0) @binding(3) var<storage, read> pairs: array<Pair>;
@group(0) @binding(4) var<storage, read_write> lanes: array<Lane>;
@group(0) @binding(5) var<storage, read> work: array<u32>;

// Mean of F over `places`² points of spot `l`, or F at its centre. `above`: the node lies above the horizon
// of every spot.
fn mean_factor(pair: u32, l: u32, above: bool) {
    slot = pairs[pair].node;
    let block = pairs[pair].block;
    let places = pairs[pair].places;
    // The last spot stands for absent ones.
    let spot = block * BLOCK_SPOTS + l;
    let normal = spots[spot].normal;
    let triangle = is_triangle(spot);
    var sum = 0.0;
    for (var place = 0u; place < places * places; place++) {
        var p = vec4f(spots[spot].centre, 1.0);
        if places > 1u {
            p = spot_point(spot, grid_uv(place, places, triangle));
        }
        if above {
            sum += lambert_factor(p.xyz, normal) * p.w;
        } else {
            sum += form_factor(shots[slot].middle, p.xyz, normal, 0.0) * p.w;
        }
    }
    let f = sum / f32(places * places);
    lanes[pair * BLOCK_SPOTS + l].factor = select(0.0, f, l < blocks[block].count);
}

// Pairs whose node lies above the horizon of every spot.
@compute @workgroup_size(PATCH_SUM_LANES)
fn unclipped_factors(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let at = flat_index(group, groups) * PATCH_SUM_LANES + lane;
    if at / BLOCK_SPOTS < work[0] {
        mean_factor(work[2u + at / BLOCK_SPOTS], at % BLOCK_SPOTS, true);
    }
}

// The other pairs, at the end of the list.
@compute @workgroup_size(PATCH_SUM_LANES)
fn clipped_factors(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let at = flat_index(group, groups) * PATCH_SUM_LANES + lane;
    if at / BLOCK_SPOTS < work[1] {
        mean_factor(work[arrayLength(&work) - 1u - at / BLOCK_SPOTS], at % BLOCK_SPOTS, false);
    }
}

// Lambert's form factor of a node above the horizon, of a point where it is remote.
fn lambert_factor(position: vec3f, normal: vec3f) -> f32 {
    let d = position - shots[slot].middle;
    let height = dot(shots[slot].normal, d);
    let r2 = dot(d, d);
    let r = sqrt(r2);
    var f = polygon_factor_above(position, normal);
    if is_remote(r2, shots[slot].radius) {
        f = disc_factor(height / r, max(-dot(normal, d) / r, 0.0), r2, shots[slot].area, 0.0);
    }
    return select(f, 0.0, height <= CONTACT_DISTANCE);
}

// Lambert's sum over the edges of a node above the horizon: nothing to clip.
fn polygon_factor_above(position: vec3f, normal: vec3f) -> f32 {
    let a = shots[slot].corners[0].xyz - position;
    let b = shots[slot].corners[1].xyz - position;
    let c = shots[slot].corners[2].xyz - position;
    let d = shots[slot].corners[3].xyz - position;
    var sum = 0.0;
    sum += edge_term(a, b, normal, false);
    sum += edge_term(b, c, normal, false);
    sum += edge_term(c, d, normal, false);
    sum += edge_term(d, a, normal, false);
    return max(-sum / (2.0 * PI), 0.0);
}
