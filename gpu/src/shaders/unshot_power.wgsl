// Unshot flux of each patch, one workgroup a patch: a tree sum in fixed order.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> patches: array<Patch>;
@group(0) @binding(2) var<storage, read> texels: array<Texel>;
@group(0) @binding(3) var<storage, read> residual: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> sums: array<vec4f>;   // Σ r·A; w: Σ|r|·A

var<workgroup> lane_residual: array<vec4f, PATCH_SUM_LANES>;

@compute @workgroup_size(PATCH_SUM_LANES)
fn unshot_power(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let patch_index = flat_index(group, groups);
    if patch_index >= params.patches {
        return;
    }
    var unshot = vec4f(0.0);
    for (var k = lane; k < patches[patch_index].count; k += PATCH_SUM_LANES) {
        let texel = patches[patch_index].first + k;
        let area = texels[texel].area;
        let r = residual[texel].xyz;
        unshot += vec4f(r * area, (abs(r.x) + abs(r.y) + abs(r.z)) * area);
    }
    lane_residual[lane] = unshot;
    for (var stride = PATCH_SUM_LANES / 2u; stride > 0u; stride /= 2u) {
        workgroupBarrier();
        if lane < stride {
            lane_residual[lane] += lane_residual[lane + stride];
        }
    }
    if lane == 0u {
        sums[patch_index] = lane_residual[0];
    }
}
