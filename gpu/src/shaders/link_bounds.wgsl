// Bounds what each spot of a block and a node exchange.

@group(0) @binding(0) var<storage, read> shots: array<Shot>;
@group(0) @binding(1) var<storage, read> spots: array<Spot>;
@group(0) @binding(2) var<storage, read> blocks: array<Block>;
@group(0) @binding(3) var<storage, read> pairs: array<Pair>;
@group(0) @binding(4) var<storage, read_write> lanes: array<Lane>;
@group(0) @binding(5) var<storage, read> counts: array<u32>;

// Height above a plane; 0 for contact.
fn height_above(height: f32) -> f32 {
    return select(0.0, height, height > CONTACT_DISTANCE);
}

// Disc form factor at a distance, from the heights `out` and `up` above the planes of source and receiver.
fn disc_factor_at(area: f32, out: f32, up: f32, distance: f32) -> f32 {
    let leaves = clamp(out / distance, 0.0, 1.0);
    let arrives = clamp(up / distance, 0.0, 1.0);
    return min(area * leaves * arrives / (PI * distance * distance), 1.0);
}

// Form factor of a disc as large as the node, to a spot whose foot on the node's plane lies within it.
fn facing_disc_factor(node: u32, normal: vec3f, d: vec3f, r: f32) -> f32 {
    let height = dot(shots[node].normal, d);
    let square = shots[node].radius * shots[node].radius;
    let facing = -dot(normal, shots[node].normal);
    if height <= 0.0 || facing <= 0.0 || r * r - height * height >= square {
        return 0.0;
    }
    return facing * square / (square + height * height);
}

// Bound of the form factor of the part of a long quad that is nearest to `place`, whatever the cosines; 0 of other nodes.
fn long_quad_factor(node: u32, place: vec3f) -> f32 {
    let area = shots[node].area;
    let own = shots[node].radius;
    let a = shots[node].corners[0].xyz;
    let b = shots[node].corners[1].xyz;
    let c = shots[node].corners[2].xyz;
    let d = shots[node].corners[3].xyz;
    if area >= MIN_COMPACT_AREA * own * own || all(c == d) {
        return 0.0;
    }
    let u = (b - a + c - d) * 0.5;
    let v = (d - a + c - b) * 0.5;
    let axis = select(v, u, dot(u, u) > dot(v, v));
    let square = max(dot(axis, axis), 1e-12);
    let offset = place - shots[node].middle;
    let to = offset - axis * clamp(dot(offset, axis) / square, -0.5, 0.5);
    let distance = max(sqrt(dot(to, to)), 1e-6);
    let length = sqrt(square);
    return min(area / length * min(distance, length) / (PI * distance * distance), 1.0);
}

// Bounds of a node and one spot: F, F·r/d, F·(r/d)² and F·(s/d)²/2.
fn bound_link(node: u32, spot: u32, radius: f32) -> vec4f {
    let area = shots[node].area;
    let own = shots[node].radius;
    let centre = shots[node].middle;
    let place = spots[spot].centre;
    let normal = spots[spot].normal;
    let d = place - centre;
    let r = max(sqrt(dot(d, d)), 1e-6);
    // Radii bound neighbours that are nearly coplanar too loosely: their highest corners bound them.
    var highest_out = 0.0;
    var highest_up = 0.0;
    for (var k = 0u; k < 4u; k++) {
        highest_out = max(highest_out, dot(shots[node].normal, spots[spot].corners[k].xyz - centre));
        highest_up = max(highest_up, dot(normal, shots[node].corners[k].xyz - place));
    }
    let nearest = max(r - 0.5 * (own + radius), 0.5 * r);
    let factor = disc_factor_at(area, height_above(highest_out), height_above(highest_up), nearest);
    // Variation depends on the range of the cosines.
    let out = dot(shots[node].normal, d) + radius;
    let up = own - dot(normal, d);
    let kernel = disc_factor_at(area, out, up, r);
    let ratio = min(own / r, 1.0);
    let gap = max(r - own, radius);
    let size = radius / gap;
    // Where the node is beside the spot's centre but above a part of it, the centre gives no bound.
    let most = select(factor, kernel, r < own + radius);
    let within = max(most, factor) * size * size * 0.5;
    // Of a node that is much wider than the gap, the part before the spot sends all the light.
    let before = max(facing_disc_factor(node, normal, d, r), long_quad_factor(node, place));
    let most_kernel = max(kernel, before);
    let most_factor = select(0.0, max(factor, before), factor > 0.0);
    return vec4f(most_factor, most_kernel * ratio, most_kernel * ratio * ratio, within);
}

@compute @workgroup_size(PATCH_SUM_LANES)
fn bound_links(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let at = flat_index(group, groups) * PATCH_SUM_LANES + lane;
    let pair = at / BLOCK_SPOTS;
    if pair >= counts[0] {
        return;
    }
    let block = pairs[pair].block;
    lanes[at].bound = bound_link(pairs[pair].node, block * BLOCK_SPOTS + at % BLOCK_SPOTS, blocks[block].radius);
}
