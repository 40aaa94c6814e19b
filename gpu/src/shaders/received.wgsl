// One workgroup a cell and shot: Σ w·A that the one takes of the other; a tree sum in fixed order.
// Twin: cpu/src/twin/received.rs.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> cells: array<Cell>;
@group(0) @binding(2) var<storage, read> texels: array<Texel>;
@group(0) @binding(3) var<storage, read> links: array<f32>;
@group(0) @binding(4) var<storage, read> shots: array<Shot>;
@group(0) @binding(5) var<storage, read_write> taken: array<f32>;

var<workgroup> lane_taken: array<f32, LANES>;

@compute @workgroup_size(LANES)
fn received(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    slot = group.z;
    let cell = flat(group, groups);
    if cell >= params.cells {
        return;
    }
    var sum = 0.0;
    for (var k = lane; k < cells[cell].count; k += LANES) {
        let texel = cells[cell].first + k;
        sum += links[shots[slot].place * params.texels + texel] * texels[texel].area;
    }
    lane_taken[lane] = sum;
    for (var stride = LANES / 2u; stride > 0u; stride /= 2u) {
        workgroupBarrier();
        if lane < stride {
            lane_taken[lane] += lane_taken[lane + stride];
        }
    }
    if lane == 0u {
        taken[shots[slot].taken + cell] = lane_taken[0];
    }
}
