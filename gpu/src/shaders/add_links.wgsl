// Adds to each spot the light that a level's links carry, in order; a thread per spot.

@group(0) @binding(0) var<uniform> request: Request;
@group(0) @binding(1) var<storage, read> radiosity: array<Radiosity>;
@group(0) @binding(2) var<storage, read> pairs: array<Pair>;
@group(0) @binding(3) var<storage, read> lanes: array<Lane>;
@group(0) @binding(4) var<storage, read> offsets: array<vec2u>;
@group(0) @binding(5) var<storage, read> ranges: array<vec2u>;         // each block's pairs
@group(0) @binding(6) var<storage, read_write> next: array<vec2u>;
@group(0) @binding(7) var<storage, read_write> sums: array<vec4f>;     // H; 1 where a shadow's edge crosses
@group(0) @binding(8) var<storage, read> totals: array<u32>;

@compute @workgroup_size(PATCH_SUM_LANES)
fn add_irradiance(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let spot = flat_index(group, groups) * PATCH_SUM_LANES + lane;
    let block = spot / BLOCK_SPOTS;
    if block >= request.blocks {
        return;
    }
    let range = ranges[block];
    var received = sums[spot];
    for (var pair = range.x; pair < range.y; pair++) {
        let state = pairs[pair].state;
        if state != PAIR_LINK && state != PAIR_EDGE {
            continue;
        }
        let at = pair * BLOCK_SPOTS + spot % BLOCK_SPOTS;
        let node = pairs[pair].node;
        let sent = lanes[at].weight * radiosity[node].mean + lanes[at].along.x * radiosity[node].slope_x
            + lanes[at].along.y * radiosity[node].slope_y;
        received += vec4f(sent, 0.0);
        if state == PAIR_EDGE {
            received.w = 1.0;
        }
    }
    sums[spot] = received;
    if spot % BLOCK_SPOTS == 0u {
        // Where pairs or links did not fit there is no next level.
        let own = vec2u(offsets[range.x].x, offsets[range.y].x);
        next[block] = select(own, vec2u(0u), totals[1] != 0u);
    }
}
