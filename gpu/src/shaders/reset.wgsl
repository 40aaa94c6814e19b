// Empties the lists of pairs whose spots are asked. Twin: none, the host asks at once.

@group(0) @binding(0) var<storage, read_write> weighed: array<u32>;
@group(0) @binding(1) var<storage, read_write> first: array<u32>;
@group(0) @binding(2) var<storage, read_write> again: array<u32>;
@group(0) @binding(3) var<storage, read_write> enough: array<u32>;
@group(0) @binding(4) var<storage, read_write> for_weighed: array<u32>;
@group(0) @binding(5) var<storage, read_write> for_first: array<u32>;
@group(0) @binding(6) var<storage, read_write> for_again: array<u32>;
@group(0) @binding(7) var<storage, read_write> for_enough: array<u32>;

@compute @workgroup_size(2)
fn reset(@builtin(local_invocation_index) lane: u32) {
    weighed[lane] = 0u;
    first[lane] = 0u;
    again[lane] = 0u;
    enough[lane] = 0u;
    for (var k = 0u; k < 3u; k++) {
        let groups = select(1u, 0u, k == 0u);
        for_weighed[3u * lane + k] = groups;
        for_first[3u * lane + k] = groups;
        for_again[3u * lane + k] = groups;
        for_enough[3u * lane + k] = groups;
    }
}
