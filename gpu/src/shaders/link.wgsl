// Links a shooting patch to the texels: form factor × the part of the patch that is visible, from pairs of
// points on the two. A dispatch adds `step` samples, the last one writes the link.

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

fn link_weight(sums: Sums) -> f32 {
    return visible_factor(sums, sums.seen, shots[slot].open);
}

fn visible_factor(sums: Sums, seen: f32, open: f32) -> f32 {
    if seen <= 0.0 {
        return 0.0;
    }
    return sums.form_factor * (seen / (sums.all * open));
}

// Baseline of texel k (Table 2, line 6): the part that is subtracted from its link, and the link without the
// objects. Both are 0 if the texel is an object's, and the latter is 0 if the patch is.
fn link_baseline(sums: Sums, k: u32) -> vec2f {
    if texels[k].face >= params.room {
        return vec2f(0.0);
    }
    let object = shots[slot].face >= params.room;
    var before = 0.0;
    if !object {
        before = visible_factor(sums, sums.before, shots[slot].open_before);
    }
    var subtracted = 0.0;
    if (params.rule & CAPTURED_BIT) != 0u || object {
        switch params.rule & SUBTRACTED_BITS {
            case SUBTRACTED_BEFORE: { subtracted = before; }
            case SUBTRACTED_UNHIDDEN: { subtracted = sums.form_factor; }
            case SUBTRACTED_ALL: { subtracted = link_weight(sums); }
            default: {}
        }
    }
    return vec2f(subtracted, before);
}

// F of texel k (Table 1, line 7): at its centre, or where the patch is near and has several sample points the
// mean over NEAR_POINTS_PER_SIDE × NEAR_POINTS_PER_SIDE points of the texel.
fn texel_form_factor(k: u32) -> f32 {
    let face = texels[k].face;
    if face == shots[slot].face {
        return 0.0;
    }
    let normal = faces[face].plane.xyz;
    let middle = shots[slot].middle;
    let reach = shots[slot].radius + FAR_DISTANCE_RADII * faces[face].tangent.w;
    if params.samples == 1u || is_far(texels[k].position, middle, reach) {
        return form_factor(middle, texels[k].position, normal, texels[k].area);
    }
    var sum = 0.0;
    for (var place = 0u; place < NEAR_POINTS_PER_SIDE * NEAR_POINTS_PER_SIDE; place++) {
        let p = point_on_texel(k, near_point_uv(place, texels[k].kind));
        sum += form_factor(middle, p.xyz, normal, texels[k].area) * p.w;
    }
    return sum / f32(NEAR_POINTS_PER_SIDE * NEAR_POINTS_PER_SIDE);
}

fn add_sample(k: u32, s: u32, sums: Sums) -> Sums {
    if sums.form_factor <= 0.0 {
        return sums;
    }
    let face = texels[k].face;
    let q = points[shots[slot].patch_index * params.samples + s];
    let p = texel_point(k, shots[slot].patch_index, s);
    let normal = faces[face].plane.xyz;
    // The texel reaches behind the patch.
    if dot(shots[slot].normal, p.xyz - q.position) <= CONTACT_DISTANCE {
        return sums;
    }
    let part = shots[slot].area / f32(params.samples);
    let g = point_weight(q.position, p.xyz, normal, part, sums.form_factor) * (p.w * q.weight);
    var next = Sums(sums.form_factor, sums.seen, sums.all + g, sums.before);
    // From below the texel's horizon a ray would come through the texel's own face.
    let below = dot(normal, p.xyz - q.position) >= CONTACT_DISTANCE;
    if q.cover == COVER_ROOM || (below && params.samples > 1u) {
        return next;
    }
    let sight = find_sight(q.position, p.xyz, face);
    if sight != SIGHT_BLOCKED {
        next.before += g;
    }
    if sight == SIGHT_CLEAR && q.cover == COVER_OPEN {
        next.seen += g;
    }
    return next;
}

@compute @workgroup_size(PATCH_SUM_LANES)
fn link_texel(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    slot = group.z;
    let k = flat_index(group, groups) * PATCH_SUM_LANES + lane;
    if k >= params.texels {
        return;
    }
    let at = slot * params.texels + k;
    var sum = Sums(0.0, 0.0, 0.0, 0.0);
    if shots[slot].sample == 0u {
        sum.form_factor = texel_form_factor(k);
    } else {
        sum = Sums(sums[at].x, sums[at].y, sums[at].z, sums[at].w);
    }
    for (var s = shots[slot].sample; s < shots[slot].next; s++) {
        sum = add_sample(k, s, sum);
    }
    let last = shots[slot].next >= params.samples;
    if !last || (params.rule & PROBE_BIT) != 0u {
        sums[at] = vec4f(sum.form_factor, sum.seen, sum.all, sum.before);
    }
    if !last {
        return;
    }
    links[shots[slot].place * params.texels + k] = link_weight(sum);
    if (params.rule & (CAPTURED_BIT | SUBTRACTED_BITS)) != 0u {
        sums[at] = vec4f(link_baseline(sum, k), 0.0, 0.0);
    }
}
