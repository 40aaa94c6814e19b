// One workgroup a cell: what it has yet to shoot, and what it took from the shot; a tree sum in
// fixed order. Twins: cpu/src/power.rs, common/src/reduce.rs.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> cells: array<Cell>;
@group(0) @binding(2) var<storage, read> texels: array<Texel>;
@group(0) @binding(3) var<storage, read> residual: array<vec4f>;
@group(0) @binding(4) var<storage, read> irradiance: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> sums: array<CellSum>;

var<workgroup> lane_residual: array<vec4f, LANES>;
var<workgroup> lane_received: array<f32, LANES>;

@compute @workgroup_size(LANES)
fn power(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let cell = flat(group, groups);
    if cell >= params.cells {
        return;
    }
    var unshot = vec4f(0.0);
    var received = 0.0;
    for (var k = lane; k < cells[cell].count; k += LANES) {
        let texel = cells[cell].first + k;
        let area = texels[texel].area;
        let r = residual[texel].xyz;
        unshot += vec4f(r * area, (abs(r.x) + abs(r.y) + abs(r.z)) * area);
        received += irradiance[texel].w * area;
    }
    lane_residual[lane] = unshot;
    lane_received[lane] = received;
    for (var stride = LANES / 2u; stride > 0u; stride /= 2u) {
        workgroupBarrier();
        if lane < stride {
            lane_residual[lane] += lane_residual[lane + stride];
            lane_received[lane] += lane_received[lane + stride];
        }
    }
    if lane == 0u {
        sums[cell].residual = lane_residual[0];
        sums[cell].received = lane_received[0];
    }
}
