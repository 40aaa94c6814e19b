// Measures the machine: bytes copied, and multiplications and additions, a second.

@group(0) @binding(0) var<storage, read> source: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> sink: array<vec4f>;

@compute @workgroup_size(PATCH_SUM_LANES)
fn copy_values(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let k = flat_index(group, groups) * PATCH_SUM_LANES + lane;
    sink[k] = source[k];
}

// Four independent chains of vec4: 32 operations a round.
@compute @workgroup_size(PATCH_SUM_LANES)
fn multiply_values(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let k = flat_index(group, groups) * PATCH_SUM_LANES + lane;
    let x = source[k];
    var a = x;
    var b = x + 1.0;
    var c = x + 2.0;
    var d = x + 3.0;
    for (var n = 0u; n < MULTIPLY_ROUNDS; n++) {
        a = a * x + b;
        b = b * x + c;
        c = c * x + d;
        d = d * x + a;
    }
    sink[k] = a + b + c + d;
}
