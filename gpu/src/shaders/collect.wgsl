// What a texel has received after all shots, H = Σ w·B_shooter in the order of the cells, and what
// it then has: B = E + ρH, its cell's mean unshot. Twin: cpu/src/twin/accumulate.rs.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> cells: array<Cell>;
@group(0) @binding(2) var<storage, read> texels: array<Texel>;
@group(0) @binding(3) var<storage, read> shot: array<vec4f>;          // radiosity of each cell
@group(0) @binding(4) var<storage, read> links: array<f32>;
@group(0) @binding(5) var<storage, read_write> irradiance: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> radiosity: array<vec4f>;   // E before
@group(0) @binding(7) var<storage, read_write> residual: array<vec4f>;

// Adds the shots of some of the cells.
@compute @workgroup_size(LANES)
fn collect(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let k = flat(group, groups) * LANES + lane;
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

// One workgroup a cell; `shot` is what is left to shoot.
@compute @workgroup_size(LANES)
fn settle(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let cell = flat(group, groups);
    if cell >= params.cells {
        return;
    }
    for (var n = lane; n < cells[cell].count; n += LANES) {
        let k = cells[cell].first + n;
        let reflected = texels[k].reflectance * irradiance[k].xyz;
        radiosity[k] = vec4f(radiosity[k].xyz + reflected, 0.0);
        residual[k] = vec4f(shot[cell].xyz, 0.0);
    }
}
