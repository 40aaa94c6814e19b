// Selects the next shooter, one workgroup: records the shot just done (Table 1, lines 2 and 14, and the
// choice that it leaves out; Table 2, line 1) and chooses the patch with most unshot power, the lowest of
// equals. The paper's §3.3 without its 1×1 depth buffer, whose threshold depends on the units.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> patches: array<Patch>;
@group(0) @binding(2) var<storage, read> sums: array<vec4f>;
@group(0) @binding(3) var<storage, read> script: array<u32>;
@group(0) @binding(4) var<storage, read> rows: array<Row>;
@group(0) @binding(5) var<storage, read_write> shot: Shot;
@group(0) @binding(6) var<storage, read_write> log: Log;
@group(0) @binding(7) var<storage, read_write> dispatches: array<u32>;  // see dispatches.rs
@group(0) @binding(8) var<storage, read> escape_counts: array<u32>;           // per patch

struct Log {
    count: u32,
    records: array<Record>,
}

var<workgroup> lane_total: array<f32, SELECT_LANES>;
var<workgroup> lane_power: array<f32, SELECT_LANES>;
var<workgroup> lane_patch: array<u32, SELECT_LANES>;

// Workgroups of a stage, none where it has nothing to do.
fn count_workgroups(stage: u32, groups: vec4u, needed: bool) {
    let some = select(vec2u(0u), groups.xy, needed);
    dispatches[stage * DISPATCH_WORDS] = some.x;
    dispatches[stage * DISPATCH_WORDS + 1u] = some.y;
    dispatches[stage * DISPATCH_WORDS + 2u] = 1u;
}

// The first choice of a run: there is no shot to record.
@compute @workgroup_size(SELECT_LANES)
fn select_first(@builtin(local_invocation_index) lane: u32) {
    reduce_power(lane);
    if lane == 0u {
        choose_shooter(0u);
    }
}

@compute @workgroup_size(SELECT_LANES)
fn select_next(@builtin(local_invocation_index) lane: u32) {
    reduce_power(lane);
    if lane == 0u && shot.shooting == 1u {
        record_shot();
        choose_shooter(log.count);
    }
}

fn choose_shooter(done: u32) {
    var patch_index = lane_patch[0];
    var shooting = lane_total[0] > params.threshold;
    if params.replay == 1u {
        patch_index = script[done];
        shooting = patch_index < params.patches;
    }
    shot.shooting = u32(shooting);
    if shooting {
        load_shot(patch_index);
    }
    let fresh = shooting && shot.fresh == 1u;
    let known = shooting && escape_counts[patch_index] >= COUNTED_BIT;
    count_workgroups(COUNTED_DEPOSIT, params.groups[0], shooting);
    count_workgroups(COUNTED_ESCAPE, params.groups[1], shooting && !known);
    count_workgroups(COUNTED_POWER, params.groups[2], shooting);
    count_workgroups(COUNTED_LINKS, params.groups[0], fresh);
    count_workgroups(COUNTED_TRANSFER, params.groups[2], fresh);
}

fn reduce_power(lane: u32) {
    var total = 0.0;
    var best = -1.0;
    var patch_index = 0xffffffffu;
    for (var k = lane; k < params.patches; k += SELECT_LANES) {
        let power = sums[k].w;
        total += power;
        if power > best {
            best = power;
            patch_index = k;
        }
    }
    lane_total[lane] = total;
    lane_power[lane] = best;
    lane_patch[lane] = patch_index;
    for (var stride = SELECT_LANES / 2u; stride > 0u; stride /= 2u) {
        workgroupBarrier();
        if lane < stride {
            lane_total[lane] += lane_total[lane + stride];
            let power = lane_power[lane + stride];
            let other = lane_patch[lane + stride];
            if power > lane_power[lane] || (power == lane_power[lane] && other < lane_patch[lane]) {
                lane_power[lane] = power;
                lane_patch[lane] = other;
            }
        }
    }
}

fn record_shot() {
    log.records[log.count] =
        Record(shot.flux, shot.patch_index, shot.sum * shot.scale, shot.escaped, lane_total[0], 0u);
    log.count++;
}

fn load_shot(patch_index: u32) {
    shot.area = patches[patch_index].area;
    shot.middle = patches[patch_index].centre;
    shot.radius = patches[patch_index].radius;
    shot.open = patches[patch_index].open;
    shot.open_before = patches[patch_index].open_before;
    shot.face = patches[patch_index].face;
    shot.corners = patches[patch_index].corners;
    shot.flux = sums[patch_index].xyz;
    shot.radiosity = shot.flux / shot.area;
    shot.patch_index = patch_index;
    shot.first = patches[patch_index].first;
    shot.count = patches[patch_index].count;
    shot.place = patch_index % params.places;
    // The baseline of a shot is not kept: where links are compared they are made again.
    let compares = (params.rule & (CAPTURED_BIT | SUBTRACTED_BITS)) != 0u;
    shot.fresh = u32(compares || rows[shot.place].patch_index != patch_index + 1u);
    shot.next = 0u;
}
