// Inclusive prefix sums of blocks of 64 values (Hillis and Steele), and the total of each block.

struct Sums {
    inclusive: vec2f,
}

@group(0) @binding(0) var<storage, read> values: array<vec2f>;
@group(0) @binding(1) var<storage, read_write> sums: array<Sums>;
@group(1) @binding(0) var<storage, read_write> totals: array<vec2f>;

var<workgroup> partial: array<vec2f, 64>;

@compute @workgroup_size(64)
fn block_sums(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = group.y * groups.x + group.x;
    let k = block * 64u + lane;
    partial[lane] = select(vec2f(0.0), values[min(k, arrayLength(&values) - 1u)], k < arrayLength(&values));
    for (var step = 1u; step < 64u; step *= 2u) {
        workgroupBarrier();
        let before = select(vec2f(0.0), partial[(lane + 64u - step) % 64u], lane >= step);
        workgroupBarrier();
        partial[lane] += before;
    }
    if k < arrayLength(&values) {
        sums[k].inclusive = partial[lane];
    }
    if lane == 63u && block < arrayLength(&totals) {
        totals[block] = partial[lane];
    }
}
