// Empties the lists of pairs that the next four steps of refinement fill.

@group(0) @binding(0) var<storage, read_write> source_work: array<u32>;
@group(0) @binding(1) var<storage, read_write> start_work: array<u32>;
@group(0) @binding(2) var<storage, read_write> more_work: array<u32>;
@group(0) @binding(3) var<storage, read_write> visibility_work: array<u32>;
@group(0) @binding(4) var<storage, read_write> source_dispatches: array<u32>;
@group(0) @binding(5) var<storage, read_write> start_dispatches: array<u32>;
@group(0) @binding(6) var<storage, read_write> more_dispatches: array<u32>;
@group(0) @binding(7) var<storage, read_write> visibility_dispatches: array<u32>;

@compute @workgroup_size(2)
fn clear_work_lists(@builtin(local_invocation_index) lane: u32) {
    source_work[lane] = 0u;
    start_work[lane] = 0u;
    more_work[lane] = 0u;
    visibility_work[lane] = 0u;
    for (var k = 0u; k < 3u; k++) {
        let groups = select(1u, 0u, k == 0u);
        source_dispatches[3u * lane + k] = groups;
        start_dispatches[3u * lane + k] = groups;
        more_dispatches[3u * lane + k] = groups;
        visibility_dispatches[3u * lane + k] = groups;
    }
}
