// What each texel takes of a shot's cell: form factor × part seen from pairs of points on the two. A
// dispatch adds `step` samples, the last one writes the link. Twin: cpu/src/twin/link.rs.

@group(0) @binding(0) var<storage, read> faces: array<Face>;
@group(0) @binding(1) var<storage, read> shots: array<Shot>;
@group(0) @binding(2) var<uniform> params: Params;
@group(0) @binding(3) var<storage, read> texels: array<Texel>;
@group(0) @binding(4) var<storage, read> points: array<Point>;
@group(0) @binding(5) var<storage, read_write> sums: array<vec4f>;   // F, Σ g·V, Σ g, Σ g·V before;
                                                                      // then subtracted, before
@group(0) @binding(6) var<storage, read_write> links: array<f32>;

struct Sums {
    form_factor: f32,
    seen: f32,
    all: f32,
    before: f32,
}

fn link(sums: Sums) -> f32 {
    return share(sums, sums.seen, shots[slot].open);
}

fn share(sums: Sums, seen: f32, open: f32) -> f32 {
    if seen <= 0.0 {
        return 0.0;
    }
    return sums.form_factor * (seen / (sums.all * open));
}

// What texel k had of the shot (Table 2, line 6): what is subtracted from its link, and the link
// without the objects; nothing where one of them is an object's.
fn baseline(sums: Sums, k: u32) -> vec2f {
    if texels[k].face >= params.room {
        return vec2f(0.0);
    }
    let object = shots[slot].face >= params.room;
    var before = 0.0;
    if !object {
        before = share(sums, sums.before, shots[slot].open_before);
    }
    var subtracted = 0.0;
    if (params.rule & CAPTURED) != 0u || object {
        switch params.rule & SUBTRACTED {
            case SUBTRACTED_BEFORE: { subtracted = before; }
            case SUBTRACTED_UNHIDDEN: { subtracted = sums.form_factor; }
            case SUBTRACTED_ALL: { subtracted = link(sums); }
            default: {}
        }
    }
    return vec2f(subtracted, before);
}

// F of texel k (Table 1, line 7): from its centre, and where the cell is near and looked at in
// several points, the mean over NEAR × NEAR places of the texel.
fn factor(k: u32) -> f32 {
    let face = texels[k].face;
    if face == shots[slot].face {
        return 0.0;
    }
    let normal = faces[face].plane.xyz;
    let middle = shots[slot].middle;
    let reach = shots[slot].radius + FAR * faces[face].tangent.w;
    if params.samples == 1u || far(texels[k].position, middle, reach) {
        return form_factor(middle, texels[k].position, normal, texels[k].area);
    }
    var sum = 0.0;
    for (var place = 0u; place < NEAR * NEAR; place++) {
        let p = point(k, near_uv(place, texels[k].kind));
        sum += form_factor(middle, p.xyz, normal, texels[k].area) * p.w;
    }
    return sum / f32(NEAR * NEAR);
}

fn sample(k: u32, s: u32, sums: Sums) -> Sums {
    if sums.form_factor <= 0.0 {
        return sums;
    }
    let face = texels[k].face;
    let q = points[shots[slot].cell * params.samples + s];
    let p = texel_point(k, shots[slot].cell, s);
    let normal = faces[face].plane.xyz;
    // The texel reaches behind the cell.
    if dot(shots[slot].normal, p.xyz - q.position) <= CONTACT {
        return sums;
    }
    let part = shots[slot].area / f32(params.samples);
    let g = weight(q.position, p.xyz, normal, part, sums.form_factor) * (p.w * q.weight);
    var next = Sums(sums.form_factor, sums.seen, sums.all + g, sums.before);
    // From below the texel's horizon a ray would come through the texel's own face.
    let below = dot(normal, p.xyz - q.position) >= CONTACT;
    if q.cover == COVER_ROOM || (below && params.samples > 1u) {
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
fn links_of(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    slot = group.z;
    let k = flat(group, groups) * LANES + lane;
    if k >= params.texels {
        return;
    }
    let at = slot * params.texels + k;
    var sum = Sums(0.0, 0.0, 0.0, 0.0);
    if shots[slot].sample == 0u {
        sum.form_factor = factor(k);
    } else {
        sum = Sums(sums[at].x, sums[at].y, sums[at].z, sums[at].w);
    }
    for (var s = shots[slot].sample; s < shots[slot].next; s++) {
        sum = sample(k, s, sum);
    }
    if shots[slot].next < params.samples {
        sums[at] = vec4f(sum.form_factor, sum.seen, sum.all, sum.before);
        return;
    }
    links[shots[slot].place * params.texels + k] = link(sum);
    if (params.rule & (CAPTURED | SUBTRACTED)) != 0u {
        sums[at] = vec4f(baseline(sum, k), 0.0, 0.0);
    }
}
