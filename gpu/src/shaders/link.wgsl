// What each texel takes of the shot's cell: form factor × seen part, from pairs of points on the
// two. A dispatch adds `step` samples, the last one writes the link. Twin: cpu/src/link.rs.

@group(0) @binding(0) var<storage, read> faces: array<Face>;
@group(0) @binding(1) var<storage, read> shot: Shot;
@group(0) @binding(2) var<uniform> params: Params;
@group(0) @binding(3) var<storage, read> texels: array<Texel>;
@group(0) @binding(4) var<storage, read> points: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> sums: array<vec4f>;   // Σ F, Σ g·V, Σ g
@group(0) @binding(6) var<storage, read_write> links: array<f32>;

struct Sums {
    form_factor: f32,
    seen: f32,
    all: f32,
}

fn link(sums: Sums) -> f32 {
    if sums.seen <= 0.0 {
        return 0.0;
    }
    return sums.form_factor / f32(params.samples) * (sums.seen / (sums.all * shot.open));
}

fn sample(k: u32, s: u32, sums: Sums) -> Sums {
    let face = texels[k].face;
    if face == shot.face {
        return sums;
    }
    let q = points[shot.cell * params.samples + s];
    let p = texel_point(k, shot.cell, s);
    let normal = faces[face].plane.xyz;
    let f = form_factor(q.xyz, p.xyz, normal, texels[k].area);
    if f <= 0.0 {
        return sums;
    }
    let part = shot.area / f32(params.samples);
    let g = weight(q.xyz, p.xyz, normal, part, f) * (p.w * abs(q.w));
    var seen = sums.seen;
    if q.w > 0.0 && visible(q.xyz, p.xyz, face) {
        seen += g;
    }
    return Sums(sums.form_factor + f * p.w, seen, sums.all + g);
}

@compute @workgroup_size(LANES)
fn gather(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let k = flat(group, groups) * LANES + lane;
    if k >= params.texels {
        return;
    }
    var sum = Sums(0.0, 0.0, 0.0);
    if shot.sample > 0u {
        sum = Sums(sums[k].x, sums[k].y, sums[k].z);
    }
    for (var s = shot.sample; s < shot.next; s++) {
        sum = sample(k, s, sum);
    }
    sums[k] = vec4f(sum.form_factor, sum.seen, sum.all, 0.0);
    if shot.next == params.samples {
        links[shot.place * params.texels + k] = link(sum);
    }
}
