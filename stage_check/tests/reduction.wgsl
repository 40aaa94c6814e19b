// Largest value, its first index, and the number of values: one workgroup, whose lanes stride through the values.

struct Params {
    count: u32,
    floor: i32,
}

struct Result {
    largest: i32,
    index: u32,
    counted: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> keys: array<i32>;
@group(0) @binding(2) var<storage, read_write> result: Result;

var<workgroup> best: array<vec2i, 128>;
var<workgroup> counted: atomic<u32>;

@compute @workgroup_size(128)
fn find_largest(@builtin(local_invocation_index) lane: u32) {
    var own = vec2i(params.floor, i32(params.count));
    for (var k = lane; k < params.count; k += 128u) {
        if keys[k] > own.x {
            own = vec2i(keys[k], i32(k));
        }
        atomicAdd(&counted, 1u);
    }
    best[lane] = own;
    for (var half = 64u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            let other = best[lane + half];
            if other.x > best[lane].x || (other.x == best[lane].x && other.y < best[lane].y) {
                best[lane] = other;
            }
        }
    }
    if lane == 0u {
        result = Result(best[0].x, u32(best[0].y), atomicLoad(&counted));
    }
}
