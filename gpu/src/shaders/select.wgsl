// One workgroup: closes the record of the shot just done and chooses the next shooter (Table 1,
// lines 2 and 14, and the choice that it leaves out; Table 2, line 1): the cell with most unshot
// power, the lowest of equals (the paper's §3.3 without its 1×1 depth buffer, whose threshold
// depends on the units). Twin: common/src/shooting.rs.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> cells: array<Cell>;
@group(0) @binding(2) var<storage, read> sums: array<vec4f>;
@group(0) @binding(3) var<storage, read> script: array<u32>;
@group(0) @binding(4) var<storage, read> rows: array<Row>;
@group(0) @binding(5) var<storage, read_write> shot: Shot;
@group(0) @binding(6) var<storage, read_write> log: Log;
@group(0) @binding(7) var<storage, read_write> dispatches: array<u32>;  // see dispatches.rs
@group(0) @binding(8) var<storage, read> lost: array<u32>;           // per cell

struct Log {
    count: u32,
    records: array<Record>,
}

var<workgroup> lane_total: array<f32, SELECT_LANES>;
var<workgroup> lane_power: array<f32, SELECT_LANES>;
var<workgroup> lane_cell: array<u32, SELECT_LANES>;

// The first choice of a run: there is no shot to record.
@compute @workgroup_size(SELECT_LANES)
fn first(@builtin(local_invocation_index) lane: u32) {
    reduce(lane);
    if lane == 0u {
        choose(0u);
    }
}

@compute @workgroup_size(SELECT_LANES)
fn next(@builtin(local_invocation_index) lane: u32) {
    reduce(lane);
    if lane == 0u && shot.shooting == 1u {
        record();
        choose(log.count);
    }
}

fn reduce(lane: u32) {
    var total = 0.0;
    var best = -1.0;
    var cell = 0xffffffffu;
    for (var k = lane; k < params.cells; k += SELECT_LANES) {
        let power = sums[k].w;
        total += power;
        if power > best {
            best = power;
            cell = k;
        }
    }
    lane_total[lane] = total;
    lane_power[lane] = best;
    lane_cell[lane] = cell;
    for (var stride = SELECT_LANES / 2u; stride > 0u; stride /= 2u) {
        workgroupBarrier();
        if lane < stride {
            lane_total[lane] += lane_total[lane + stride];
            let power = lane_power[lane + stride];
            let other = lane_cell[lane + stride];
            if power > lane_power[lane] || (power == lane_power[lane] && other < lane_cell[lane]) {
                lane_power[lane] = power;
                lane_cell[lane] = other;
            }
        }
    }
}

fn record() {
    log.records[log.count] =
        Record(shot.flux, shot.cell, shot.sum * shot.scale, shot.escaped, lane_total[0], 0u);
    log.count++;
}

fn choose(done: u32) {
    var cell = lane_cell[0];
    var shooting = lane_total[0] > params.threshold;
    if params.replay == 1u {
        cell = script[done];
        shooting = cell < params.cells;
    }
    shot.shooting = u32(shooting);
    if shooting {
        load(cell);
    }
    let fresh = shooting && shot.fresh == 1u;
    let known = shooting && lost[cell] >= KNOWN;
    dispatch(COUNTED_DEPOSIT, params.groups[0], shooting);
    dispatch(COUNTED_ESCAPE, params.groups[1], shooting && !known);
    dispatch(COUNTED_POWER, params.groups[2], shooting);
    dispatch(COUNTED_LINKS, params.groups[0], fresh);
    dispatch(COUNTED_RECEIVED, params.groups[2], fresh);
}

// Workgroups of a stage, none where it has nothing to do.
fn dispatch(stage: u32, groups: vec4u, needed: bool) {
    let some = select(vec2u(0u), groups.xy, needed);
    dispatches[stage * DISPATCH_WORDS] = some.x;
    dispatches[stage * DISPATCH_WORDS + 1u] = some.y;
    dispatches[stage * DISPATCH_WORDS + 2u] = 1u;
}

fn load(cell: u32) {
    shot.area = cells[cell].area;
    shot.middle = cells[cell].centre;
    shot.radius = cells[cell].radius;
    shot.open = cells[cell].open;
    shot.open_before = cells[cell].open_before;
    shot.face = cells[cell].face;
    shot.corners = cells[cell].corners;
    shot.flux = sums[cell].xyz;
    shot.radiosity = shot.flux / shot.area;
    shot.cell = cell;
    shot.first = cells[cell].first;
    shot.count = cells[cell].count;
    shot.place = cell % params.places;
    // What the room had of a shot is not kept: those links are made anew.
    let compares = (params.rule & (CAPTURED | SUBTRACTED)) != 0u;
    shot.fresh = u32(compares || rows[shot.place].cell != cell + 1u);
    shot.next = 0u;
}
