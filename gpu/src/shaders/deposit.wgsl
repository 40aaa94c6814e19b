// Deposits the shot on one texel: ΔH = (w − subtracted)·B_shooter, ΔB = Δr = ρ·ΔH.

@group(0) @binding(0) var<storage, read> shot: Shot;
@group(0) @binding(1) var<uniform> params: Params;
@group(0) @binding(2) var<storage, read> texels: array<Texel>;
@group(0) @binding(3) var<storage, read> links: array<f32>;
@group(0) @binding(4) var<storage, read_write> radiosity: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> residual: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> irradiance: array<vec4f>;
@group(0) @binding(7) var<storage, read> sums: array<vec4f>;         // subtracted, before

@compute @workgroup_size(PATCH_SUM_LANES)
fn deposit(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let k = flat_index(group, groups) * PATCH_SUM_LANES + lane;
    if k >= params.texels {
        return;
    }
    let captured = (params.rule & CAPTURED_BIT) != 0u;
    var baseline = vec2f(0.0);
    if captured || (params.rule & SUBTRACTED_BITS) != 0u {
        baseline = sums[k].xy;
    }
    let f = links[shot.place * params.texels + k] * shot.scale - baseline.x;
    irradiance[k].w = f;
    if k >= shot.first && k < shot.first + shot.count {
        // Table 1, line 15; Table 2, line 22.
        residual[k] = vec4f(0.0);
        return;
    }
    if captured {
        radiosity[k] += vec4f(shot.radiosity * baseline.y, 0.0);
    }
    if f == 0.0 {
        return;
    }
    let received = shot.radiosity * f;
    irradiance[k] = vec4f(irradiance[k].xyz + received, f);
    if captured {
        return;
    }
    // Table 1, lines 8 to 10; Table 2, lines 8 and 9 (f < 0) and 15 to 17.
    let reflected = texels[k].reflectance * received;
    radiosity[k] += vec4f(reflected, 0.0);
    if (params.rule & KEEP_BIT) != 0u || texels[k].face >= params.room {
        residual[k] += vec4f(reflected, 0.0);
    }
}
