// Closes a shot's links, one workgroup a shot: ΣF, and the factor that scales the links.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> transfers: array<f32>;
@group(0) @binding(2) var<storage, read_write> escape_counts: array<u32>;
@group(0) @binding(3) var<storage, read_write> rows: array<Row>;
@group(0) @binding(4) var<storage, read_write> shots: array<Shot>;

var<workgroup> lane_sums: array<f32, SELECT_LANES>;

// Factor by which the links are multiplied: 1, or what brings ΣF to 1 − escaped.
fn link_scale(conserve: bool, sum: f32, escaped: f32) -> f32 {
    if conserve && sum > 0.0 {
        return (1.0 - escaped) / sum;
    }
    return 1.0;
}

@compute @workgroup_size(SELECT_LANES)
fn sum_form_factors(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    slot = group.z;
    var sum = 0.0;
    for (var k = lane; k < params.patches; k += SELECT_LANES) {
        sum += transfers[shots[slot].transfer_start + k];
    }
    lane_sums[lane] = sum;
    for (var stride = SELECT_LANES / 2u; stride > 0u; stride /= 2u) {
        workgroupBarrier();
        if lane < stride {
            lane_sums[lane] += lane_sums[lane + stride];
        }
    }
    if lane == 0u && shots[slot].shooting == 1u {
        if shots[slot].fresh == 1u {
            rows[shots[slot].place].patch_index = shots[slot].patch_index + 1u;
            rows[shots[slot].place].sum = select(0.0, lane_sums[0] / shots[slot].area, shots[slot].area > 0.0);
        }
        escape_counts[shots[slot].patch_index] |= COUNTED_BIT;
        shots[slot].sum = rows[shots[slot].place].sum;
        shots[slot].escaped = f32(escape_counts[shots[slot].patch_index] - COUNTED_BIT) / f32(ESCAPE_DIRECTION_COUNT);
        shots[slot].scale =
            link_scale(params.conserve == 1u, shots[slot].sum, shots[slot].escaped);
    }
}
