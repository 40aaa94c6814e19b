// The flux that each cell receives of all that shoot at once: what it takes of each, in the order
// of the cells. Twin: cpu/src/twin/accumulate.rs.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> shot: array<vec4f>;          // radiosity of each cell
@group(0) @binding(2) var<storage, read> taken: array<f32>;           // cells × cells: Σ w·A
@group(0) @binding(3) var<storage, read_write> flux: array<vec4f>;    // w: 1 where it is written

@compute @workgroup_size(LANES)
fn exchange(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let c = flat(group, groups) * LANES + lane;
    if c >= params.cells {
        return;
    }
    var sum = vec3f(0.0);
    for (var i = 0u; i < params.cells; i++) {
        let x = shot[i].xyz;
        if any(x != vec3f(0.0)) {
            sum += x * taken[i * params.cells + c];
        }
    }
    flux[c] = vec4f(sum, 1.0);
}
