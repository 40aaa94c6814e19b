// Transfer between patches, one workgroup a patch and shot: T = Σ w·A over the texels of the receiving
// patch, a tree sum in fixed order.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> patches: array<Patch>;
@group(0) @binding(2) var<storage, read> texels: array<Texel>;
@group(0) @binding(3) var<storage, read> links: array<f32>;
@group(0) @binding(4) var<storage, read> shots: array<Shot>;
@group(0) @binding(5) var<storage, read_write> transfers: array<f32>;

var<workgroup> lane_sums: array<f32, PATCH_SUM_LANES>;

@compute @workgroup_size(PATCH_SUM_LANES)
fn patch_transfer(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    slot = group.z;
    let patch_index = flat_index(group, groups);
    if patch_index >= params.patches {
        return;
    }
    var sum = 0.0;
    for (var k = lane; k < patches[patch_index].count; k += PATCH_SUM_LANES) {
        let texel = patches[patch_index].first + k;
        sum += links[shots[slot].place * params.texels + texel] * texels[texel].area;
    }
    lane_sums[lane] = sum;
    for (var stride = PATCH_SUM_LANES / 2u; stride > 0u; stride /= 2u) {
        workgroupBarrier();
        if lane < stride {
            lane_sums[lane] += lane_sums[lane + stride];
        }
    }
    if lane == 0u {
        transfers[shots[slot].transfer_start + patch_index] = lane_sums[0];
    }
}
