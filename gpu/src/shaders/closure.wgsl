// One workgroup a shot: ΣF, and what its links are multiplied by. Twins: cpu/src/twin/closure.rs,
// common/src/passes/mod.rs.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> taken: array<f32>;
@group(0) @binding(2) var<storage, read_write> lost: array<u32>;
@group(0) @binding(3) var<storage, read_write> rows: array<Row>;
@group(0) @binding(4) var<storage, read_write> shots: array<Shot>;

var<workgroup> lane_taken: array<f32, SELECT_LANES>;

@compute @workgroup_size(SELECT_LANES)
fn closure(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    slot = group.z;
    var sum = 0.0;
    for (var k = lane; k < params.cells; k += SELECT_LANES) {
        sum += taken[shots[slot].taken + k];
    }
    lane_taken[lane] = sum;
    for (var stride = SELECT_LANES / 2u; stride > 0u; stride /= 2u) {
        workgroupBarrier();
        if lane < stride {
            lane_taken[lane] += lane_taken[lane + stride];
        }
    }
    if lane == 0u && shots[slot].shooting == 1u {
        if shots[slot].fresh == 1u {
            rows[shots[slot].place].cell = shots[slot].cell + 1u;
            rows[shots[slot].place].sum = select(0.0, lane_taken[0] / shots[slot].area, shots[slot].area > 0.0);
        }
        lost[shots[slot].cell] |= KNOWN;
        shots[slot].sum = rows[shots[slot].place].sum;
        shots[slot].escaped = f32(lost[shots[slot].cell] - KNOWN) / f32(DIRECTIONS);
        shots[slot].scale =
            scale(params.conserve == 1u, shots[slot].sum, shots[slot].escaped);
    }
}

fn scale(asked: bool, sum: f32, escaped: f32) -> f32 {
    if asked && sum > 0.0 {
        return (1.0 - escaped) / sum;
    }
    return 1.0;
}
