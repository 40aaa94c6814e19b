// What a level's links send to each spot, in order; a thread per spot. Twin: cpu/src/hierarchy/link.rs.

@group(0) @binding(0) var<uniform> asked: Asked;
@group(0) @binding(1) var<storage, read> glows: array<Glow>;
@group(0) @binding(2) var<storage, read> pairs: array<Pair>;
@group(0) @binding(3) var<storage, read> lanes: array<Lane>;
@group(0) @binding(4) var<storage, read> offsets: array<vec2u>;
@group(0) @binding(5) var<storage, read> ranges: array<vec2u>;         // each block's pairs
@group(0) @binding(6) var<storage, read_write> next: array<vec2u>;
@group(0) @binding(7) var<storage, read_write> sums: array<vec4f>;     // H; 1 where a shadow's edge crosses
@group(0) @binding(8) var<storage, read> totals: array<u32>;

@compute @workgroup_size(LANES)
fn add(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let spot = flat(group, groups) * LANES + lane;
    let block = spot / SPOTS;
    if block >= asked.blocks {
        return;
    }
    let range = ranges[block];
    var received = sums[spot];
    for (var pair = range.x; pair < range.y; pair++) {
        let state = pairs[pair].state;
        if state != PAIR_LINK && state != PAIR_EDGE {
            continue;
        }
        let at = pair * SPOTS + spot % SPOTS;
        let node = pairs[pair].node;
        let sent = lanes[at].weight * glows[node].mean + lanes[at].along.x * glows[node].slope_x
            + lanes[at].along.y * glows[node].slope_y;
        received += vec4f(sent, 0.0);
        if state == PAIR_EDGE {
            received.w = 1.0;
        }
    }
    sums[spot] = received;
    if spot % SPOTS == 0u {
        // Where there was no room there is no next level.
        let own = vec2u(offsets[range.x].x, offsets[range.y].x);
        next[block] = select(own, vec2u(0u), totals[1] != 0u);
    }
}
