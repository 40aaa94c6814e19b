// One workgroup: closes the record of the shot just done and chooses the next shooter, the cell
// with most unshot power, the lowest of equals (the paper's §3.3 without its 1×1 depth buffer,
// whose threshold depends on the units). Twin: select and total in common/src/shooting.rs.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> faces: array<Face>;
@group(0) @binding(2) var<storage, read> cells: array<Cell>;
@group(0) @binding(3) var<storage, read> sums: array<CellSum>;
@group(0) @binding(4) var<storage, read> script: array<u32>;
@group(0) @binding(5) var<storage, read_write> shot: Shot;
@group(0) @binding(6) var<storage, read_write> log: Log;
@group(0) @binding(7) var<storage, read_write> dispatches: array<u32>;  // deposit, escape, power
@group(0) @binding(8) var<storage, read_write> lost: array<u32>;     // per cell; KNOWN once counted

const KNOWN = 0x80000000u;

struct Log {
    count: u32,
    records: array<Record>,
}

var<workgroup> lane_total: array<f32, SELECT_LANES>;
var<workgroup> lane_received: array<f32, SELECT_LANES>;
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
    var received = 0.0;
    var best = -1.0;
    var cell = 0xffffffffu;
    for (var k = lane; k < params.cells; k += SELECT_LANES) {
        let power = sums[k].residual.w;
        total += power;
        received += sums[k].received;
        if power > best {
            best = power;
            cell = k;
        }
    }
    lane_total[lane] = total;
    lane_received[lane] = received;
    lane_power[lane] = best;
    lane_cell[lane] = cell;
    for (var stride = SELECT_LANES / 2u; stride > 0u; stride /= 2u) {
        workgroupBarrier();
        if lane < stride {
            lane_total[lane] += lane_total[lane + stride];
            lane_received[lane] += lane_received[lane + stride];
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
    lost[shot.cell] |= KNOWN;
    let escaped = f32(lost[shot.cell] - KNOWN) / f32(DIRECTIONS);
    let form_factor_sum = select(0.0, lane_received[0] / shot.area, shot.area > 0.0);
    log.records[log.count] = Record(shot.flux, shot.cell, form_factor_sum, escaped, lane_total[0], 0u);
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
        aim(cell);
    }
    let known = shooting && lost[cell] >= KNOWN;
    for (var k = 0u; k < 3u; k++) {
        let needed = shooting && !(known && k == 1u);
        let groups = select(vec2u(0u), params.groups[k].xy, needed);
        dispatches[k * 3u] = groups.x;
        dispatches[k * 3u + 1u] = groups.y;
        dispatches[k * 3u + 2u] = 1u;
    }
}

fn aim(cell: u32) {
    let face = cells[cell].face;
    shot.centre = cells[cell].centre;
    shot.area = cells[cell].area;
    shot.normal = faces[face].plane.xyz;
    shot.tangent = faces[face].tangent.xyz;
    shot.bitangent = cross(shot.normal, shot.tangent);
    shot.sheet = faces[face].sheet;
    shot.face = face;
    shot.corners = cells[cell].corners;
    shot.flux = sums[cell].residual.xyz;
    shot.radiosity = shot.flux / shot.area;
    shot.cell = cell;
    shot.first = cells[cell].first;
    shot.count = cells[cell].count;
}
