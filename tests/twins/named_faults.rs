//! Mistakes that students make, and faults that public projects shipped and mended: `compare` finds each in a user's
//! file, names its stage first, and shows an element with both values, as docs/your-shader.md prints them.

use common::form_factor::FormFactor;
use common::settings::{Settings, Visibility};
use gpu::{Gpu, ShaderFile, ShaderStage};
use oracle::compare::comparison::{Comparison, DifferingValue};
use oracle::compare::hierarchical::compare_hierarchical;
use oracle::compare::{ComparisonRequest, compare_shooting};
use oracle::solve::progress::without_progress;
use oracle::solve::solver::ErrorTarget;
use radiosity_tests::bundled_scene;
use radiosity_tests::engines::{item_buffer, settings_of, shared_gpu};

/// Name, shader, stage that differs, the one text that the fault replaces, and the replacement.
pub type NamedFault = [&'static str; 5];

const DISC_CALL: &str = "disc_factor(cos_i, cos_j, r2, shots[slot].area, shots[slot].area)";
const TEXEL_COSINE: &str = "let cos_j = max(-dot(normal, d) / r, 0.0);\n    if";

/// Faults that single shots by an item buffer find.
pub const BY_PIXELS: [NamedFault; 23] = [
    [
        "cosine dropped",
        "form_factor",
        "form factor",
        DISC_CALL,
        "disc_factor(cos_i, 1.0, r2, shots[slot].area, shots[slot].area)",
    ],
    [
        "π forgotten",
        "form_factor",
        "form factor",
        "(PI * r2 + disc_area)",
        "(r2 + disc_area)",
    ],
    [
        "distance not squared",
        "form_factor",
        "form factor",
        "(PI * r2 + disc_area)",
        "(PI * sqrt(r2) + disc_area)",
    ],
    [
        "wrong side of the hemisphere",
        "view",
        "aim",
        "= faces[face].plane.xyz;",
        "= -faces[face].plane.xyz;",
    ],
    [
        "areas swapped",
        "form_factor",
        "form factor",
        DISC_CALL,
        "disc_factor(cos_i, cos_j, r2, texel_area, shots[slot].area)",
    ],
    [
        "half a pixel off",
        "projection",
        "lookup",
        "vec2f((p.x * 0.5 + 0.5) * n,",
        "vec2f((p.x * 0.5 + 0.5) * n - 0.5,",
    ],
    [
        "no horizon test",
        "form_factor",
        "form factor",
        "if height <= CONTACT_DISTANCE {",
        "if false {",
    ],
    [
        "depth compared the wrong way",
        "item_buffer",
        "item buffer",
        "min(hit.t * DEPTH_SCALE, MAX_DEPTH)",
        "MAX_DEPTH - hit.t * DEPTH_SCALE",
    ],
    [
        "residual not cleared",
        "deposit",
        "deposit",
        "        residual[k] = vec4f(0.0);\n",
        "",
    ],
    [
        "ρ squared",
        "deposit",
        "deposit",
        "= texels[k].reflectance *",
        "= texels[k].reflectance * texels[k].reflectance *",
    ],
    [
        "absolute cosine",
        "form_factor",
        "form factor",
        TEXEL_COSINE,
        "let cos_j = abs(dot(normal, d) / r);\n    if",
    ],
    [
        "IDs compared as floats",
        "lookup",
        "lookup",
        "id == face + 1u || lies_on_face(id, position)",
        "f32(id) * (1.0 / 41.0) * 41.0 == f32(face + 1u)",
    ],
    [
        "directions not weighted by the cosine (webgpu/webgpu-samples#259)",
        "escape",
        "escape",
        "to_world(directions[k].xyz)",
        "to_world(directions[k].xyz * vec3f(vec2f(sqrt(1.0 + directions[k].z * directions[k].z)), directions[k].z))",
    ],
    [
        "workgroups rounded down (webgpu/webgpu-samples#261)",
        "select",
        "select: workgroups",
        "(COUNTED_DEPOSIT, params.groups[0], shooting)",
        "(COUNTED_DEPOSIT, vec4u(params.texels / PATCH_SUM_LANES, 1u, 0u, 0u), shooting)",
    ],
    [
        "negative cosine (webgpu/webgpu-samples#112)",
        "form_factor",
        "form factor",
        TEXEL_COSINE,
        "let cos_j = -dot(normal, d) / r;\n    if",
    ],
    [
        "face upside down (NatLabRockies/EnergyPlus#463)",
        "form_factor",
        "form factor",
        TEXEL_COSINE,
        "let cos_j = max(dot(normal, d) / r, 0.0);\n    if",
    ],
    [
        "orientation by the wrong index (sampotter/fluxpy#63)",
        "link",
        "form factor",
        "let normal = faces[face].plane.xyz;\n    let middle",
        "let normal = faces[k % params.faces].plane.xyz;\n    let middle",
    ],
    [
        "not the nearest hit (brandonpelfrey/Fast-BVH#4)",
        "item_buffer",
        "item buffer",
        "min(hit.t * DEPTH_SCALE, MAX_DEPTH)",
        "0.5",
    ],
    [
        "directions stretched by 2 (RayTracing/TheRestOfYourLife#8)",
        "escape",
        "escape",
        "to_world(directions[k].xyz)",
        "to_world(directions[k].xyz * vec3f(2.0, 2.0, 1.0))",
    ],
    [
        "weights by area, not by solid angle (bevyengine/bevy#24671)",
        "form_factor",
        "link",
        "return disc_factor(cos_i, cos_j, r2, part, part) +",
        "return part +",
    ],
    [
        "transfer in the wrong direction",
        "exchange",
        "exchange",
        "transfers[i * params.patches + c]",
        "transfers[c * params.patches + i]",
    ],
    [
        "ρ dropped",
        "gather",
        "collect",
        "texels[k].reflectance * irradiance[k].xyz",
        "irradiance[k].xyz",
    ],
    [
        "half the irradiance (NVIDIAGameWorks/RTXGI-DDGI#15)",
        "link",
        "link",
        "* (seen / (sums.all * open))",
        "* (0.5 * seen / (sums.all * open))",
    ],
];

/// A fault that rays find.
pub const BY_RAYS: [NamedFault; 1] = [[
    "hits near edges missed (godotengine/godot#53844)",
    "intersect",
    "rays",
    "hit.inside >= -OUTLINE_MARGIN",
    "hit.inside >= 0.01",
]];

/// Faults in the links between nodes that a solve to an error finds, one in each of its files.
const BY_LINKS: [NamedFault; 17] = [
    [
        "records in another order",
        "hierarchy_types",
        "refine",
        "    factor: f32,             // F\n    weight: f32,             // w\n",
        "    weight: f32,\n    factor: f32,\n",
    ],
    [
        "list not emptied",
        "clear_work_lists",
        "clear_work_lists",
        "    more_work[lane] = 0u;\n",
        "",
    ],
    [
        "bound without a cosine",
        "link_bounds",
        "link_bounds",
        "min(area * leaves * arrives /",
        "min(area * leaves /",
    ],
    [
        "threshold compared the wrong way",
        "refine",
        "refine",
        "varies > request.source",
        "varies < request.source",
    ],
    [
        "samples not raised to 4/3",
        "visibility_samples",
        "refine",
        "return x * fourth",
        "return fourth",
    ],
    [
        "edge of the polygon dropped",
        "link_factors",
        "link_factors",
        "    sum += edge_term(d, a, normal, false);\n",
        "",
    ],
    [
        "points beside the middle of their cells",
        "surface_points",
        "link_factors",
        "select(0.5, 1.0 / 3.0, triangle)",
        "select(0.25, 1.0 / 3.0, triangle)",
    ],
    [
        "weights not over their sum",
        "sample_links",
        "sample_links",
        "let f = factor / all;",
        "let f = factor;",
    ],
    [
        "light from below the horizon",
        "sample_links",
        "sample_links",
        ">= CONTACT_DISTANCE {\n        return true;",
        ">= CONTACT_DISTANCE {\n        return false;",
    ],
    [
        "one step for both axes",
        "sampling",
        "sample_links",
        "return vec2f(sample_coordinate(s, STEP_PATCH_U, first)",
        "return vec2f(sample_coordinate(s, STEP_PATCH_V, first)",
    ],
    [
        "a hit taken for a miss",
        "rays",
        "rays",
        "return SIGHT_BLOCKED;",
        "return SIGHT_CLEAR;",
    ],
    [
        "exclusive sum made inclusive",
        "prefix_sum",
        "prefix_sum",
        "        offsets[pair] = before;\n        before += pair_counts(pair);\n",
        "        before += pair_counts(pair);\n        offsets[pair] = before;\n",
    ],
    [
        "index of a child + 1",
        "subdivide_nodes",
        "subdivide_nodes",
        "shots[node].first + k;",
        "shots[node].first + k + 1u;",
    ],
    [
        "last link of a block dropped",
        "add_links",
        "add_links",
        "pair < range.y",
        "pair + 1u < range.y",
    ],
    [
        "slope forgotten",
        "add_links",
        "add_links",
        "\n            + lanes[at].along.y * radiosity[node].slope_y;",
        ";",
    ],
    [
        "link at the next spot",
        "store_links",
        "store_links",
        "links[link * BLOCK_SPOTS + at % BLOCK_SPOTS]",
        "links[link * BLOCK_SPOTS + (at + 1u) % BLOCK_SPOTS]",
    ],
    [
        "link of every second pair lost",
        "store_links",
        "store_links",
        "if pair >= counts[0] ||",
        "if pair >= counts[0] || pair % 2u == 1u ||",
    ],
];

/// Compares the solvers on the plates with a block between them.
fn compare_plates(gpu: &Gpu, settings: Settings) -> Comparison {
    let request = ComparisonRequest {
        settings,
        gpu,
        faults: &[],
    };
    compare_shooting(&bundled_scene("occluded_plates.obj"), &request, &without_progress()).unwrap()
}

/// Compares hierarchical solves on the same plates.
fn compare_links(gpu: &Gpu) -> Comparison {
    let target = ErrorTarget {
        error: 0.05,
        texels: Some(4),
    };
    let scene = bundled_scene("occluded_plates.obj");
    compare_hierarchical(&scene, target, &Settings::default(), (gpu, &[]), &without_progress()).unwrap()
}

/// Returns the process's GPU with a user's file of this text in the place of a shader.
fn gpu_with_file(shader: &str, text: &str) -> Gpu {
    let path = std::env::temp_dir().join(format!("radiosity-fault-{}.wgsl", std::process::id()));
    std::fs::write(&path, text).unwrap();
    let files = vec![ShaderFile::read(shader, &path).unwrap()];
    std::fs::remove_file(&path).unwrap();
    gpu::shaders::check_shader_files(&files).unwrap();
    shared_gpu().clone().with_shader_files(files)
}

/// Compares with the fault in a user's file, and returns its row of the page.
fn compare_with_fault([name, shader, stage, from, to]: NamedFault, compare: impl Fn(&Gpu) -> Comparison) -> String {
    let ShaderStage { text, verdict, .. } = ShaderStage::find(shader).unwrap();
    assert!(
        verdict.is_empty() || verdict.contains(&stage),
        "{name}: {stage} is no name of {shader}"
    );
    assert_eq!(text.matches(from).count(), 1, "{name}: {from}");
    let gpu = gpu_with_file(shader, &text.replace(from, to));
    let comparison = compare(&gpu);
    assert!(gpu.unused_shader_file().is_none(), "{name}: the file was not run");
    let first = comparison.criteria.iter().find(|criterion| !criterion.pass);
    let first = first.unwrap_or_else(|| panic!("{name} is not found"));
    assert_eq!(first.name, format!("WGSL = twin: {stage}"), "{name}");
    let difference = first.difference.as_ref().unwrap();
    println!(
        "{name}: {} = {:e} > {:e}\n    {difference}",
        first.name, first.value, first.bound
    );
    let DifferingValue { element, gpu, twin } = &difference.first;
    let [gpu, twin] = [gpu, twin].map(|number| short_number(number));
    assert_ne!(gpu, twin, "{name}");
    format!("| {name} | {shader} | {stage} | {element} | {gpu} | {twin} |")
}

/// Returns a whole number as it is, another with four digits: rounding may differ between adapters.
fn short_number(number: &str) -> String {
    match number.parse::<f32>() {
        Ok(value) if number.contains('.') && value != 0.0 => {
            let decimals = (3.0 - value.abs().log10().floor()).max(0.0) as usize;
            format!("{value:.decimals$}")
        }
        _ => number.to_owned(),
    }
}

/// Returns settings of single shots by an item buffer, and by rays.
pub fn fault_settings() -> [Settings; 2] {
    let mut by_pixels = settings_of([5, 1, 1], item_buffer(64), 0.01);
    by_pixels.transport.form_factor = FormFactor::Disc;
    by_pixels.schedule = by_pixels.schedule.with_southwell();
    [by_pixels, settings_of([5, 1, 3], Visibility::Rays, 0.01)]
}

#[test]
fn named_faults_are_shown_as_the_page_does() {
    let [by_pixels, by_rays] = fault_settings();
    let by_pixels = |gpu: &Gpu| compare_plates(gpu, by_pixels);
    let by_rays = |gpu: &Gpu| compare_plates(gpu, by_rays);
    for healthy in [
        by_pixels(shared_gpu()),
        by_rays(shared_gpu()),
        compare_links(shared_gpu()),
    ] {
        assert!(healthy.solvers_agree(), "a false alarm");
        for stage in &healthy.stages {
            assert!(!ShaderStage::files_judged_by(&stage.name).is_empty(), "{}", stage.name);
        }
    }
    let rows = (BY_PIXELS.into_iter().map(|fault| compare_with_fault(fault, by_pixels)))
        .chain(BY_RAYS.into_iter().map(|fault| compare_with_fault(fault, by_rays)))
        .chain(
            BY_LINKS
                .into_iter()
                .map(|fault| compare_with_fault(fault, compare_links)),
        );
    let table = [
        "| Mistake | File | Stage | First value | GPU | Twin |",
        "|---|---|---|---|---|---|",
    ]
    .map(str::to_owned);
    let table: Vec<String> = table.into_iter().chain(rows).collect();
    let table = table.join("\n");
    let page = include_str!("../../docs/your-shader.md");
    assert!(page.contains(&table), "docs/your-shader.md should have:\n{table}");
}

/// A shader, and a change of it that leaves a loop without an end.
type EndlessLoop = [&'static str; 3];

/// Loops without an end in shots.
const ENDLESS_SHOTS: [EndlessLoop; 7] = [
    ["unshot_power", "stride > 0u", "stride >= 0u"],
    ["select", "stride > 0u", "stride >= 0u"],
    ["closure", "k += SELECT_LANES", "k += 0u"],
    ["link", "s < shots[slot].next; s++", "s < shots[slot].next;"],
    // Relights have near points, which a solve with a single sample does without.
    [
        "link",
        "place < NEAR_POINTS_PER_SIDE * NEAR_POINTS_PER_SIDE; place++",
        "place < 4u;",
    ],
    ["lookup", "i <= min(x + LOOKUP_REACH, last)", "i == i"],
    ["gather", "i < params.end; i++", "i < params.end;"],
];
/// Loops without an end in links between nodes.
const ENDLESS_LINKS: [EndlessLoop; 3] = [
    ["prefix_sum", "k < lane; k++", "k < lane + 1u; k *= 1u"],
    ["add_links", "pair < range.y; pair++", "pair < range.y;"],
    ["rays", "leaves &= leaves - 1u", "leaves &= leaves"],
];

/// A loop without an end is named with its file, though a software adapter ends it.
#[test]
fn loops_without_an_end_are_named() {
    let [by_pixels, _] = fault_settings();
    let shots = ENDLESS_SHOTS.map(|fault| (fault, true));
    for ([shader, from, to], is_shot) in shots.into_iter().chain(ENDLESS_LINKS.map(|fault| (fault, false))) {
        let text = ShaderStage::find(shader).unwrap().text;
        assert_eq!(text.matches(from).count(), 1, "{shader}: {from}");
        let gpu = gpu_with_file(shader, &text.replace(from, to));
        let comparison = match is_shot {
            true => compare_plates(&gpu, by_pixels),
            false => compare_links(&gpu),
        };
        let failing: Vec<_> = comparison.criteria.iter().filter(|criterion| !criterion.pass).collect();
        let first = failing.first().unwrap_or_else(|| panic!("{shader}: not found"));
        println!("{}: {}", first.name, first.reason);
        assert_eq!(first.name, format!("WGSL = twin: {shader}"));
        let line = text[..text.find(from).unwrap()].matches('\n').count() + 1;
        let place = format!("line {line}: the loop `for (");
        assert!(
            first.reason.starts_with(&place) && first.reason.contains("does not end within"),
            "{shader}: {}",
            first.reason
        );
    }
}
