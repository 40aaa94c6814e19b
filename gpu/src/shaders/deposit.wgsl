// One texel under the shot: ΔH = F·V·B_shooter, ΔB = Δr = ρ·ΔH. Twins: cpu/src/deposit.rs and
// cpu/src/lookup.rs.

@group(0) @binding(0) var<storage, read> faces: array<Face>;
@group(0) @binding(1) var<storage, read> shot: Shot;
@group(0) @binding(2) var<uniform> params: Params;
@group(0) @binding(3) var<storage, read> texels: array<Texel>;
@group(0) @binding(4) var<storage, read_write> radiosity: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> residual: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> irradiance: array<vec4f>;
@group(0) @binding(7) var item_buffer: texture_2d<u32>;

// The nine pixels name the faces that may hide the texel; those are asked exactly.
fn visible(position: vec3f, face: u32) -> bool {
    let p = pixels(project(to_local(position)));
    let last = i32(SIZE) - 1;
    let x = clamp(i32(floor(p.x)), 0, last);
    let y = clamp(i32(floor(p.y)), 0, last);
    var found = false;
    var asked = 0u;
    for (var j = max(y - REACH, 0); j <= min(y + REACH, last); j++) {
        for (var i = max(x - REACH, 0); i <= min(x + REACH, last); i++) {
            let id = textureLoad(item_buffer, vec2i(i, j), 0).x;
            if id == face + 1u {
                found = true;
            } else if REACH > 0 && id != 0u && id != asked {
                if blocks(id - 1u, position, face) {
                    return false;
                }
                asked = id;
            }
        }
    }
    return found;
}

fn blocks(occluder: u32, position: vec3f, face: u32) -> bool {
    if faces[occluder].sheet == faces[face].sheet {
        return false;
    }
    let hit = intersect(occluder, shot.centre, position - shot.centre);
    return hit.t > 0.0 && hit.t < END && hit.inside >= -OUTLINE;
}

@compute @workgroup_size(LANES)
fn deposit(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let k = flat(group, groups) * LANES + lane;
    if k >= params.texels {
        return;
    }
    let texel = texels[k];
    irradiance[k].w = 0.0;
    if k >= shot.first && k < shot.first + shot.count {
        residual[k] = vec4f(0.0);
        return;
    }
    if texel.face == shot.face {
        return;
    }
    let f = form_factor(texel.position, faces[texel.face].plane.xyz, texel.area);
    if f <= 0.0 || !visible(texel.position, texel.face) {
        return;
    }
    let received = shot.radiosity * f;
    let reflected = texel.reflectance * received;
    irradiance[k] = vec4f(irradiance[k].xyz + received, f);
    radiosity[k] += vec4f(reflected, 0.0);
    residual[k] += vec4f(reflected, 0.0);
}
