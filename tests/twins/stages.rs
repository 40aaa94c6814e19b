//! Each stage has a check of its own: a fault planted in a WGSL function turns that stage red and no
//! other, whatever the visibility and however many samples; without a fault none is red.

use common::cover::sampled;
use common::form_factor::FormFactor;
use common::rays::Rays;
use common::settings::{Meshing, Projection, Raster, Settings, Transport, Visibility};
use gpu::{Fault, Gpu, GpuSolver};
use oracle::judge::compare::stages::stages;
use radiosity_tests::box_in_room;

/// How links are made.
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

fn settings(by: By) -> Settings {
    let drawn = |projection| Visibility::drawn(projection, 128);
    let visibility = match by {
        By::Rays => Visibility::Rays,
        Pixels | Paper => drawn(Projection::Stereographic(Raster::Pixel)),
        Triangles => drawn(Projection::Stereographic(Raster::Tessellated)),
        Hemicube => drawn(Projection::Hemicube),
    };
    let whole = by == Paper;
    Settings {
        meshing: Meshing {
            texels: 6,
            cells: if whole { 1 } else { 2 },
            samples: if whole { 1 } else { 3 },
        },
        transport: Transport {
            form_factor: if whole {
                FormFactor::Disc
            } else {
                FormFactor::Polygon
            },
            visibility,
            conserve: true,
        },
        ..Settings::default()
    }
}

/// The stages that are red.
fn red(gpu: &Gpu, by: By, faults: &[Fault]) -> Vec<String> {
    let settings = settings(by);
    let mesh = sampled(&box_in_room(), &settings.meshing).unwrap();
    let solver = GpuSolver::with_faults(gpu, &mesh, &settings.transport, faults);
    let judged =
        solver.and_then(|mut s| stages(&mesh, &settings.transport, &Rays::new(&mesh), &mut s));
    let stages = match judged {
        Ok(stages) => stages,
        Err(error) => return vec![error.to_string()],
    };
    let red = stages.into_iter().filter(|stage| !stage.agree);
    red.map(|stage| stage.name).collect()
}

fn gpu() -> Gpu {
    Gpu::open(None).expect("the tests need an adapter: see scripts/driver.sh")
}

#[test]
fn without_a_fault_no_stage_is_red() {
    let gpu = gpu();
    for by in [By::Rays, Pixels, Triangles, Hemicube, Paper] {
        assert_eq!(red(&gpu, by, &[]), Vec::<String>::new(), "{by:?}");
    }
}

/// (how, file, what it reads, what it reads instead, the stages that are red then).
type Row = (
    By,
    &'static str,
    &'static str,
    &'static str,
    &'static [&'static str],
);

/// A fault in what raster and lookup, or rays and escape, share is seen by both.
const FAULTS: &[Row] = &[
    (
        Pixels,
        "select",
        "if power > best {",
        "if power < best {",
        &["select"],
    ),
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
    (Pixels, "aim", ".position;", ".position * 1.001;", &["aim"]),
    (
        Pixels,
        "aim",
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
        "min(hit.t * DEPTH_SCALE, DEPTH_MAX)",
        "DEPTH_MAX - hit.t * DEPTH_SCALE",
        &["item buffer"],
    ),
    (
        Hemicube,
        "item_buffer",
        "index / 6u % SIDES",
        "index / 6u % (SIDES - 1u)",
        &["item buffer"],
    ),
    (
        Hemicube,
        "bound",
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
    (
        Pixels,
        "form_factor",
        "PI / 2.0 - a",
        "PI / 2.0 + a",
        &["form factor"],
    ),
    (
        Paper,
        "form_factor",
        "return disc(cos_i, cos_j, r2, shots[slot].area, shots[slot].area);",
        "return disc(cos_i, 1.0, r2, shots[slot].area, shots[slot].area);",
        &["form factor"],
    ),
    (
        Pixels,
        "link",
        "return sum / f32(NEAR * NEAR);",
        "return sum / f32(NEAR);",
        &["form factor"],
    ),
    (
        Pixels,
        "sampling",
        "let first = hash(texel ^ hash(cell));",
        "let first = hash(texel + hash(cell));",
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
    (
        Pixels,
        "link",
        "next.seen += g;",
        "next.seen += 0.5 * g;",
        &["link"],
    ),
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
        "let tile = vec2i(tile()) * i32(SIZE);",
        "let tile = vec2i(1);",
        &["lookup"],
    ),
    (
        Paper,
        "intersect",
        "hit.t < END * end",
        "hit.t > END * end",
        &["lookup"],
    ),
    (
        By::Rays,
        "intersect",
        "hit.t < END * end",
        "hit.t < 0.5 * end",
        &["rays"],
    ),
    (
        By::Rays,
        "escape",
        "nearest.front <= nearest.back + CONTACT",
        "nearest.front > nearest.back + CONTACT",
        &["escape"],
    ),
    (
        By::Rays,
        "received",
        "* texels[texel].area;",
        ";",
        &["received"],
    ),
    (
        By::Rays,
        "closure",
        "sum += taken[",
        "sum += 1.01 * taken[",
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
    (
        Pixels,
        "deposit",
        "residual[k] = vec4f(0.0);",
        "",
        &["deposit"],
    ),
    (
        Pixels,
        "deposit",
        "radiosity[k] += vec4f(reflected, 0.0);",
        "radiosity[k] = vec4f(0.0);",
        &["deposit"],
    ),
    (
        Pixels,
        "power",
        "abs(r.z)) * area",
        "abs(r.y)) * area",
        &["power"],
    ),
    (
        Pixels,
        "power",
        "vec4f(r * area,",
        "vec4f(r * area * 1.001,",
        &["power"],
    ),
    (
        Pixels,
        "exchange",
        "sum += x * taken[",
        "sum += 1.001 * x * taken[",
        &["exchange"],
    ),
    (
        Pixels,
        "collect",
        "sum += x * links[",
        "sum += x * x * links[",
        &["collect"],
    ),
    (
        Pixels,
        "collect",
        "texels[k].reflectance * irradiance[k].xyz;",
        "irradiance[k].xyz;",
        &["collect"],
    ),
];

#[test]
fn a_fault_turns_its_own_stage_red() {
    let gpu = gpu();
    let mut wrong = Vec::new();
    for (by, file, from, to, expected) in FAULTS {
        let red = red(&gpu, *by, &[Fault { file, from, to }]);
        println!("{file:12} {from:60} {red:?}");
        if red != *expected {
            wrong.push(format!("{file}: {from} → {to}: {red:?}, not {expected:?}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
