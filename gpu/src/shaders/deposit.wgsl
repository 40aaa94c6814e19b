// One texel under the shot: ΔH = F·V·B_shooter, ΔB = Δr = ρ·ΔH. Twin: cpu/src/deposit.rs.

@group(0) @binding(0) var<storage, read> faces: array<Face>;
@group(0) @binding(1) var<storage, read> shot: Shot;
@group(0) @binding(2) var<uniform> params: Params;
@group(0) @binding(3) var<storage, read> texels: array<Texel>;
@group(0) @binding(4) var<storage, read_write> radiosity: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> residual: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> irradiance: array<vec4f>;
@group(0) @binding(7) var item_buffer: texture_2d<u32>;

@compute @workgroup_size(LANES)
fn deposit(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let k = flat(group, groups) * LANES + lane;
    if k >= params.texels {
        return;
    }
    let texel = texels[k];
    irradiance[k].w = 0.0;
    if k >= shot.first && k < shot.first + shot.count {
        residual[k] = vec4f(0.0);
        return;
    }
    if texel.face == shot.face {
        return;
    }
    let f = form_factor(texel.position, faces[texel.face].plane.xyz, texel.area);
    if f <= 0.0 || !visible(texel.position, texel.face) {
        return;
    }
    let received = shot.radiosity * f;
    let reflected = texel.reflectance * received;
    irradiance[k] = vec4f(irradiance[k].xyz + received, f);
    radiosity[k] += vec4f(reflected, 0.0);
    residual[k] += vec4f(reflected, 0.0);
}
