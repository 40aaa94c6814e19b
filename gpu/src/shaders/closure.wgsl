// One workgroup: ΣF of the shot, and what its links are multiplied by. Twins: `closure` in
// cpu/src/power.rs, `conserving` in cpu/src/solver.rs.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> taken: array<f32>;
@group(0) @binding(2) var<storage, read> lost: array<u32>;
@group(0) @binding(3) var<storage, read_write> rows: array<Row>;
@group(0) @binding(4) var<storage, read_write> shot: Shot;

var<workgroup> lane_taken: array<f32, SELECT_LANES>;

@compute @workgroup_size(SELECT_LANES)
fn closure(@builtin(local_invocation_index) lane: u32) {
    var sum = 0.0;
    for (var k = lane; k < params.cells; k += SELECT_LANES) {
        sum += taken[k];
    }
    lane_taken[lane] = sum;
    for (var stride = SELECT_LANES / 2u; stride > 0u; stride /= 2u) {
        workgroupBarrier();
        if lane < stride {
            lane_taken[lane] += lane_taken[lane + stride];
        }
    }
    if lane == 0u && shot.shooting == 1u {
        if shot.fresh == 1u {
            rows[shot.place].cell = shot.cell + 1u;
            rows[shot.place].sum = select(0.0, lane_taken[0] / shot.area, shot.area > 0.0);
        }
        let escaped = f32(lost[shot.cell] & 0x7fffffffu) / f32(DIRECTIONS);
        shot.scale = conserving(params.conserve == 1u, rows[shot.place].sum, escaped);
    }
}

fn conserving(asked: bool, sum: f32, escaped: f32) -> f32 {
    if asked && sum > 0.0 {
        return (1.0 - escaped) / sum;
    }
    return 1.0;
}
