//! Each stage has a check of its own: a fault planted in a WGSL function fails that stage and no other, for every
//! visibility and number of samples; without a fault none fails.

use common::Result;
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::rays::Rays;
use common::settings::{ItemBufferProjection, ItemBufferSettings, Lookup, Settings, Transport, Visibility};
use cpu::shader_twins::link::texel_form_factor;
use gpu::{GpuSolver, ShaderFault};
use oracle::compare::comparison::{DifferingValue, StageCheck, StageDifference};
use oracle::compare::stages::{check_relit_stages, check_stages, relit_mesh};
use pollster::block_on;
use radiosity_tests::box_in_room;
use radiosity_tests::engines::{hemicube, item_buffer, mesh_scene, settings_of, shared_gpu};
use radiosity_tests::shader_faults::assert_faults_noticed;

/// Returns the checks of all stages with faults planted in the shaders.
fn checks_with_faults(mesh: &Mesh, transport: &Transport, faults: &[ShaderFault]) -> Result<Vec<StageCheck>> {
    let gpu = shared_gpu().for_checks();
    let mut solver = GpuSolver::with_faults(&gpu, mesh, transport, faults)?;
    Ok(block_on(check_stages(mesh, transport, &Rays::new(mesh), &mut solver))?.checks)
}

/// Returns the stages that fail, or the host's refusal.
fn failing_stages(mesh: &Mesh, transport: &Transport, faults: &[ShaderFault]) -> Vec<String> {
    match checks_with_faults(mesh, transport, faults) {
        Ok(stages) => stages
            .into_iter()
            .filter(|stage| !stage.agree)
            .map(|stage| stage.name)
            .collect(),
        Err(error) => vec![error.to_string()],
    }
}

/// Several samples of patches; for `paper` one sample a pair, whole faces, discs.
fn settings_for(check: &str) -> Settings {
    let (counts, visibility) = match check {
        "rays" => ([6, 2, 3], Visibility::Rays),
        "pixels" => ([6, 2, 3], item_buffer(128)),
        "triangles" => (
            [6, 2, 3],
            Visibility::with_item_buffer(ItemBufferProjection::Paper, 128),
        ),
        "hemicube" => ([6, 2, 3], hemicube(128)),
        _ => ([6, 1, 1], item_buffer(128)),
    };
    let mut settings = settings_of(counts, visibility, 1e-3);
    settings.transport.conserve = true;
    if check == "paper" {
        settings.transport.form_factor = FormFactor::Disc;
    }
    settings
}

/// A fault in a function that raster and lookup, or rays and escape, share fails both. The wrong area of a sample
/// fails the lookup as well as its link.
#[test]
fn fault_fails_its_own_stage_only() {
    for check in ["rays", "pixels", "triangles", "hemicube", "paper"] {
        let settings = settings_for(check);
        let mesh = mesh_scene(&box_in_room(), &settings);
        assert_faults_noticed(check, |faults| failing_stages(&mesh, &settings.transport, faults));
    }
}

/// Texels of the room receive by every rule of relighting.
#[test]
fn fault_of_relighting_fails_its_own_stage_only() {
    let mesh = relit_mesh(&box_in_room(), 4).unwrap().unwrap();
    for (check, visibility) in [("relit rays", Visibility::Rays), ("relit pixels", item_buffer(64))] {
        let transport = settings_of([4, 1, 2], visibility, 1e-3).transport;
        assert_faults_noticed(check, |faults| {
            let mut solver = GpuSolver::with_faults(shared_gpu(), &mesh, &transport, faults).unwrap();
            let checks = block_on(check_relit_stages(&mesh, &transport, &mut solver)).unwrap();
            let failing = checks.into_iter().filter(|stage| !stage.agree);
            failing.map(|stage| stage.name).collect()
        });
    }
}

/// Returns what differs at `stage` with a fault planted in the shader `file`, by the paper's settings.
fn difference_at(
    mesh: &Mesh,
    stage: &str,
    file: &'static str,
    from: &'static str,
    to: &'static str,
) -> StageDifference {
    let transport = settings_for("paper").transport;
    let checks = checks_with_faults(mesh, &transport, &[ShaderFault { file, from, to }]).unwrap();
    let check = checks.into_iter().find(|check| check.name == stage).unwrap();
    assert!(!check.agree, "{check:?}");
    let difference = check.difference.unwrap();
    println!("{difference}");
    difference
}

/// Returns both values of a difference.
fn both_values(value: &DifferingValue) -> [f32; 2] {
    [&value.gpu, &value.twin].map(|text| text.parse().unwrap())
}

#[test]
fn dropped_cosine_is_shown_by_texel_and_both_values() {
    let mesh = mesh_scene(&box_in_room(), &settings_for("paper"));
    let call = "return disc_factor(cos_i, cos_j, r2, shots[slot].area, shots[slot].area);";
    let dropped = "return disc_factor(cos_i, 1.0, r2, shots[slot].area, shots[slot].area);";
    let found = difference_at(&mesh, "form factor", "form_factor", call, dropped);
    for value in [&found.first, &found.worst] {
        let numbers = value.element.split(|c: char| !c.is_ascii_digit());
        let numbers: Vec<u32> = numbers.filter_map(|number| number.parse().ok()).collect();
        let [texel, face, patch] = numbers[..] else {
            panic!("{}", value.element);
        };
        let place = format!("F of texel {texel} of face {face} from patch {patch}");
        assert_eq!(
            (value.element.as_str(), mesh.texels[texel as usize].face),
            (place.as_str(), face)
        );
        let twin = texel_form_factor(&mesh, FormFactor::Disc, patch, texel);
        let [wrong, expected] = both_values(value);
        assert_eq!(expected, twin);
        assert!(wrong > twin, "{value}");
    }
    assert!(found.beyond < found.values, "{found}");
}

#[test]
fn wrong_channel_of_a_deposit_is_shown_by_texel_and_both_values() {
    let mesh = mesh_scene(&box_in_room(), &settings_for("paper"));
    let (from, to) = (
        "irradiance[k].xyz + received, f)",
        "irradiance[k].xyz + received * vec3f(1.0, 1.001, 1.0), f)",
    );
    let found = difference_at(&mesh, "deposit", "deposit", from, to);
    assert!(found.first.element.starts_with("H.g of texel "), "{found}");
    assert!(found.first.element.contains(" from patch "), "{found}");
    let [wrong, twin] = both_values(&found.first);
    assert!((wrong / twin - 1.001).abs() < 1e-5, "{found}");
    assert!(found.pattern.ends_with(", only H.g"), "{found}");
}

#[test]
fn gpu_stages_agree_with_twins() {
    let mesh = Mesh::uniform(&box_in_room(), 6, 2).unwrap();
    for (n, projection) in ItemBufferProjection::ALL_PROJECTIONS.into_iter().enumerate() {
        for (m, form_factor) in [FormFactor::Paper, FormFactor::Disc, FormFactor::Polygon]
            .into_iter()
            .enumerate()
        {
            let transport = Transport {
                visibility: Visibility::ItemBuffer(ItemBufferSettings {
                    projection,
                    size: 256,
                    lookup: [Lookup::Exact, Lookup::Neighbours][(n + m) % 2],
                }),
                form_factor,
                conserve: false,
            };
            let failing = failing_stages(&mesh, &transport, &[]);
            assert!(failing.is_empty(), "{transport:?}: {failing:?}");
        }
    }
}
