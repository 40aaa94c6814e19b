// What each texel takes of the shot's cell: form factor × seen part, from pairs of points on the
// two. A dispatch adds `step` samples, the last one writes the link. Twin: cpu/src/link.rs.

@group(0) @binding(0) var<storage, read> faces: array<Face>;
@group(0) @binding(1) var<storage, read> shot: Shot;
@group(0) @binding(2) var<uniform> params: Params;
@group(0) @binding(3) var<storage, read> texels: array<Texel>;
@group(0) @binding(4) var<storage, read> points: array<Point>;
@group(0) @binding(5) var<storage, read_write> sums: array<vec4f>;   // Σ F, Σ g·V, Σ g, Σ g·V before;
                                                                      // then had, before
@group(0) @binding(6) var<storage, read_write> links: array<f32>;

struct Sums {
    form_factor: f32,
    seen: f32,
    all: f32,
    before: f32,
}

fn link(sums: Sums) -> f32 {
    return share(sums, sums.seen, shot.open);
}

fn share(sums: Sums, seen: f32, open: f32) -> f32 {
    if seen <= 0.0 {
        return 0.0;
    }
    return sums.form_factor / f32(params.samples) * (seen / (sums.all * open));
}

// What texel k had of the shot: what is subtracted from its link, and the link without the
// objects; nothing where one of them is an object's.
fn past(sums: Sums, k: u32) -> vec2f {
    if texels[k].face >= params.room {
        return vec2f(0.0);
    }
    let object = shot.face >= params.room;
    var before = 0.0;
    if !object {
        before = share(sums, sums.before, shot.open_before);
    }
    var had = 0.0;
    if (params.rule & CAPTURED) != 0u || object {
        switch params.rule & HAD {
            case HAD_BEFORE: { had = before; }
            case HAD_UNHIDDEN: { had = sums.form_factor / f32(params.samples); }
            case HAD_ALL: { had = link(sums); }
            default: {}
        }
    }
    return vec2f(had, before);
}

fn sample(k: u32, s: u32, sums: Sums) -> Sums {
    let face = texels[k].face;
    if face == shot.face {
        return sums;
    }
    let q = points[shot.cell * params.samples + s];
    let p = texel_point(k, shot.cell, s);
    let normal = faces[face].plane.xyz;
    let f = form_factor(q.position, p.xyz, normal, texels[k].area);
    if f <= 0.0 {
        return sums;
    }
    let part = shot.area / f32(params.samples);
    let g = weight(q.position, p.xyz, normal, part, f) * (p.w * q.weight);
    var next = Sums(sums.form_factor + f * p.w, sums.seen, sums.all + g, sums.before);
    if q.cover == COVER_ROOM {
        return next;
    }
    let sight = sight(q.position, p.xyz, face);
    if sight != BLOCKED {
        next.before += g;
    }
    if sight == CLEAR && q.cover == COVER_OPEN {
        next.seen += g;
    }
    return next;
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
    var sum = Sums(0.0, 0.0, 0.0, 0.0);
    if shot.sample > 0u {
        sum = Sums(sums[k].x, sums[k].y, sums[k].z, sums[k].w);
    }
    for (var s = shot.sample; s < shot.next; s++) {
        sum = sample(k, s, sum);
    }
    sums[k] = vec4f(sum.form_factor, sum.seen, sum.all, sum.before);
    if shot.next == params.samples {
        links[shot.place * params.texels + k] = link(sum);
        sums[k] = vec4f(past(sum, k), 0.0, 0.0);
    }
}
