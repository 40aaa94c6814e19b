// Exchanges flux between all patches at once: Σ_i T_ci B_i for each receiver c, in the order of the patches.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> shot: array<vec4f>;          // radiosity of each patch
@group(0) @binding(2) var<storage, read> transfers: array<f32>;           // patches × patches: Σ w·A
@group(0) @binding(3) var<storage, read_write> flux: array<vec4f>;    // w: 1 where it is written

@compute @workgroup_size(PATCH_SUM_LANES)
fn exchange_flux(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let c = flat_index(group, groups) * PATCH_SUM_LANES + lane;
    if c >= params.patches {
        return;
    }
    var sum = vec3f(0.0);
    for (var i = 0u; i < params.patches; i++) {
        let x = shot[i].xyz;
        if any(x != vec3f(0.0)) {
            sum += x * transfers[i * params.patches + c];
        }
    }
    flux[c] = vec4f(sum, 1.0);
}
