//! Each stage has a check of its own: a fault planted in a WGSL function fails that stage and no other, for every
//! visibility and number of samples; without a fault none fails.

use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::rays::Rays;
use common::settings::{ItemBufferProjection, ItemBufferSettings, Lookup, Settings, Transport, Visibility};
use gpu::{GpuSolver, ShaderFault};
use oracle::compare::stages::check_stages;
use radiosity_tests::box_in_room;
use radiosity_tests::engines::{hemicube, item_buffer, mesh_scene, settings_of, shared_gpu};
use radiosity_tests::shader_faults::assert_faults_noticed;

/// Returns the stages that fail, or the host's refusal.
fn failing_stages(mesh: &Mesh, transport: &Transport, faults: &[ShaderFault]) -> Vec<String> {
    let solver = GpuSolver::with_faults(shared_gpu(), mesh, transport, faults);
    match solver.and_then(|mut solver| check_stages(mesh, transport, &Rays::new(mesh), &mut solver)) {
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
