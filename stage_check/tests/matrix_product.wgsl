// Product of square matrices, a workgroup for a tile of 8 × 8.

@group(0) @binding(0) var<uniform> side: u32;
@group(0) @binding(1) var<storage, read> a: array<f32>;
@group(0) @binding(2) var<storage, read> b: array<f32>;
@group(0) @binding(3) var<storage, read_write> product: array<f32>;

var<workgroup> tile_a: array<array<f32, 8>, 8>;
var<workgroup> tile_b: array<array<f32, 8>, 8>;

@compute @workgroup_size(8, 8)
fn multiply(@builtin(global_invocation_id) place: vec3u, @builtin(local_invocation_id) lane: vec3u) {
    var sum = 0.0;
    for (var tile = 0u; tile < side; tile += 8u) {
        let column = tile + lane.x;
        let row = tile + lane.y;
        tile_a[lane.y][lane.x] = select(0.0, a[min(place.y, side - 1u) * side + min(column, side - 1u)], column < side);
        tile_b[lane.y][lane.x] = select(0.0, b[min(row, side - 1u) * side + min(place.x, side - 1u)], row < side);
        workgroupBarrier();
        for (var k = 0u; k < 8u; k++) {
            sum += tile_a[lane.y][k] * tile_b[k][lane.x];
        }
        workgroupBarrier();
    }
    if place.x < side && place.y < side {
        product[place.y * side + place.x] = sum;
    }
}
