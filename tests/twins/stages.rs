//! Each stage has a check of its own: a fault planted in a WGSL function fails that stage and no other, for every
//! visibility and number of samples; without a fault none fails.

use common::cover::sampled_mesh;
use common::form_factor::FormFactor;
use common::rays::Rays;
use common::settings::{ItemBufferProjection, Meshing, Raster, Settings, Transport, Visibility};
use gpu::{Gpu, GpuSolver, ShaderFault};
use oracle::compare::stages::check_stages;
use radiosity_tests::box_in_room;
use radiosity_tests::shader_faults::shader_fault;

/// Settings by which links are made.
#[derive(Clone, Copy, Debug, PartialEq)]
enum By {
    Rays,
    Pixels,
    Triangles,
    Hemicube,
    /// One sample a pair, whole faces, discs.
    Paper,
}
use By::{Hemicube, Paper, Pixels, Triangles};

fn settings_for(by: By) -> Settings {
    let drawn = |projection| Visibility::with_item_buffer(projection, 128);
    let visibility = match by {
        By::Rays => Visibility::Rays,
        Pixels | Paper => drawn(ItemBufferProjection::Stereographic(Raster::Pixel)),
        Triangles => drawn(ItemBufferProjection::Stereographic(Raster::Tessellated)),
        Hemicube => drawn(ItemBufferProjection::Hemicube),
    };
    let whole = by == Paper;
    Settings {
        meshing: Meshing {
            texels: 6,
            patches: if whole { 1 } else { 2 },
            samples: if whole { 1 } else { 3 },
        },
        transport: Transport {
            form_factor: if whole { FormFactor::Disc } else { FormFactor::Polygon },
            visibility,
            conserve: true,
        },
        ..Settings::default()
    }
}

/// Returns the stages that fail.
fn failing_stages(gpu: &Gpu, by: By, faults: &[ShaderFault]) -> Vec<String> {
    let settings = settings_for(by);
    let mesh = sampled_mesh(&box_in_room(), &settings.meshing).unwrap();
    let solver = GpuSolver::with_faults(gpu, &mesh, &settings.transport, faults);
    let judged = solver.and_then(|mut s| check_stages(&mesh, &settings.transport, &Rays::new(&mesh), &mut s));
    let stages = match judged {
        Ok(stages) => stages,
        Err(error) => return vec![error.to_string()],
    };
    let red = stages.into_iter().filter(|stage| !stage.agree);
    red.map(|stage| stage.name).collect()
}

fn open_gpu() -> Gpu {
    Gpu::open(None).expect("the tests need an adapter: see scripts/driver.sh")
}

#[test]
fn stages_without_fault_agree() {
    let gpu = open_gpu();
    for by in [By::Rays, Pixels, Triangles, Hemicube, Paper] {
        assert_eq!(failing_stages(&gpu, by, &[]), Vec::<String>::new(), "{by:?}");
    }
}

/// (settings, file, text, replacement, the stages that fail).
type Row = (By, &'static str, &'static str, &'static str, &'static [&'static str]);

/// A fault in a function that raster and lookup, or rays and escape, share fails both.
const FAULTS: &[Row] = &[
    (Pixels, "select", "if power > best {", "if power < best {", &["select"]),
    (
        Paper,
        "select",
        "total += power;",
        "total += power * 0.999;",
        &["select: unshot"],
    ),
    (
        Pixels,
        "select",
        "shot.sum * shot.scale, shot.escaped",
        "shot.sum, shot.escaped",
        &["closure"],
    ),
    (
        Pixels,
        "select",
        "shot.radiosity = shot.flux / shot.area;",
        "shot.radiosity = shot.flux;",
        &["deposit"],
    ),
    (Pixels, "view", ".position;", ".position * 1.001;", &["aim"]),
    (
        Pixels,
        "view",
        "= faces[face].plane.xyz;",
        "= -faces[face].plane.xyz;",
        &["aim", "form factor", "lookup", "escape"],
    ),
    (
        Pixels,
        "item_buffer",
        "pixel_centre(pixel.x, ",
        "pixel_centre(pixel.x + 1u, ",
        &["item buffer"],
    ),
    (
        Pixels,
        "item_buffer",
        "min(hit.t * DEPTH_SCALE, MAX_DEPTH)",
        "MAX_DEPTH - hit.t * DEPTH_SCALE",
        &["item buffer"],
    ),
    (
        Hemicube,
        "item_buffer",
        "index / 6u % IMAGE_PLANES",
        "index / 6u % (IMAGE_PLANES - 1u)",
        &["item buffer"],
    ),
    (
        Hemicube,
        "image_bound",
        "limits.xy - pixel",
        "limits.xy + pixel",
        &["item buffer"],
    ),
    (Pixels, "projection", "1.0 + u.z", "1.01 + u.z", &["lookup"]),
    (
        Triangles,
        "tessellate",
        "return level;",
        "return level / 2u;",
        &["item buffer"],
    ),
    (Pixels, "form_factor", "PI / 2.0 - a", "PI / 2.0 + a", &["form factor"]),
    (
        Paper,
        "form_factor",
        "return disc_factor(cos_i, cos_j, r2, shots[slot].area, shots[slot].area);",
        "return disc_factor(cos_i, 1.0, r2, shots[slot].area, shots[slot].area);",
        &["form factor"],
    ),
    (
        Pixels,
        "link",
        "return sum / f32(NEAR_POINTS_PER_SIDE * NEAR_POINTS_PER_SIDE);",
        "return sum / f32(NEAR_POINTS_PER_SIDE);",
        &["form factor"],
    ),
    (
        Pixels,
        "sampling",
        "let first = pcg_hash(texel ^ pcg_hash(patch_index));",
        "let first = pcg_hash(texel + pcg_hash(patch_index));",
        &["link"],
    ),
    (
        By::Rays,
        "texel_point",
        "let v = (place.y + uv.y) / size.y;\n    let low",
        "let v = (place.y + uv.x) / size.y;\n    let low",
        &["form factor", "link"],
    ),
    (
        Pixels,
        "link",
        "let part = shots[slot].area / f32(params.samples);",
        "let part = shots[slot].area;",
        // Known: lookup is red as well.
        &["lookup", "link"],
    ),
    (Pixels, "link", "next.seen += g;", "next.seen += 0.5 * g;", &["link"]),
    (
        Pixels,
        "link",
        "sums.form_factor * (seen / (sums.all * open))",
        "sums.form_factor * (seen / sums.all * 0.999)",
        &["link"],
    ),
    (
        Pixels,
        "lookup",
        "clamp(i32(floor(p.x)), 0, last)",
        "clamp(i32(floor(p.x)) + 2, 0, last)",
        &["lookup"],
    ),
    (
        Pixels,
        "lookup",
        "let tile = vec2i(tile_index()) * i32(IMAGE_SIZE);",
        "let tile = vec2i(1);",
        &["lookup"],
    ),
    (
        Paper,
        "intersect",
        "hit.t < SEGMENT_END_FRACTION * end",
        "hit.t > SEGMENT_END_FRACTION * end",
        &["lookup"],
    ),
    (
        By::Rays,
        "intersect",
        "hit.t < SEGMENT_END_FRACTION * end",
        "hit.t < 0.5 * end",
        &["rays"],
    ),
    (
        By::Rays,
        "escape",
        "nearest.front <= nearest.back + CONTACT_DISTANCE",
        "nearest.front > nearest.back + CONTACT_DISTANCE",
        &["escape"],
    ),
    (By::Rays, "patch_transfer", "* texels[texel].area;", ";", &["received"]),
    (
        By::Rays,
        "closure",
        "sum += transfers[",
        "sum += 1.01 * transfers[",
        &["closure"],
    ),
    (
        By::Rays,
        "closure",
        "return (1.0 - escaped) / sum;",
        "return 1.0 / (sum * 1.01);",
        &["closure"],
    ),
    (
        Pixels,
        "deposit",
        "texels[k].reflectance * received;",
        "received;",
        &["deposit"],
    ),
    (Pixels, "deposit", "residual[k] = vec4f(0.0);", "", &["deposit"]),
    (
        Pixels,
        "deposit",
        "radiosity[k] += vec4f(reflected, 0.0);",
        "radiosity[k] = vec4f(0.0);",
        &["deposit"],
    ),
    (
        Pixels,
        "unshot_power",
        "abs(r.z)) * area",
        "abs(r.y)) * area",
        &["power"],
    ),
    (
        Pixels,
        "unshot_power",
        "vec4f(r * area,",
        "vec4f(r * area * 1.001,",
        &["power"],
    ),
    (
        Pixels,
        "exchange",
        "sum += x * transfers[",
        "sum += 1.001 * x * transfers[",
        &["exchange"],
    ),
    (
        Pixels,
        "gather",
        "sum += x * links[",
        "sum += x * x * links[",
        &["collect"],
    ),
    (
        Pixels,
        "gather",
        "texels[k].reflectance * irradiance[k].xyz;",
        "irradiance[k].xyz;",
        &["collect"],
    ),
];

#[test]
fn fault_fails_its_own_stage_only() {
    let gpu = open_gpu();
    let mut wrong = Vec::new();
    for (by, file, from, to, expected) in FAULTS {
        let red = failing_stages(&gpu, *by, &[shader_fault(file, from, to)]);
        println!("{file:12} {from:60} {red:?}");
        if red != *expected {
            wrong.push(format!("{file}: {from} → {to}: {red:?}, not {expected:?}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
