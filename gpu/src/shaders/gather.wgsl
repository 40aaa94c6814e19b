// Gathers all shots at each texel: H = Σ w·B_shooter in the order of the patches, and then B = E + ρH with
// the patch's mean residual.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> patches: array<Patch>;
@group(0) @binding(2) var<storage, read> texels: array<Texel>;
@group(0) @binding(3) var<storage, read> shot: array<vec4f>;          // radiosity of each patch
@group(0) @binding(4) var<storage, read> links: array<f32>;
@group(0) @binding(5) var<storage, read_write> irradiance: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> radiosity: array<vec4f>;   // E before
@group(0) @binding(7) var<storage, read_write> residual: array<vec4f>;

// Adds the shots of the patches `first` to `end`.
@compute @workgroup_size(PATCH_SUM_LANES)
fn gather_irradiance(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let k = flat_index(group, groups) * PATCH_SUM_LANES + lane;
    if k >= params.texels {
        return;
    }
    var sum = irradiance[k].xyz;
    for (var i = params.first; i < params.end; i++) {
        let x = shot[i].xyz;
        if any(x != vec3f(0.0)) {
            sum += x * links[i % params.places * params.texels + k];
        }
    }
    irradiance[k] = vec4f(sum, 0.0);
}

// One workgroup a patch; `shot` holds the residual of each patch.
@compute @workgroup_size(PATCH_SUM_LANES)
fn update_radiosity(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let patch_index = flat_index(group, groups);
    if patch_index >= params.patches {
        return;
    }
    for (var n = lane; n < patches[patch_index].count; n += PATCH_SUM_LANES) {
        let k = patches[patch_index].first + n;
        let reflected = texels[k].reflectance * irradiance[k].xyz;
        radiosity[k] = vec4f(radiosity[k].xyz + reflected, 0.0);
        residual[k] = vec4f(shot[patch_index].xyz, 0.0);
    }
}
