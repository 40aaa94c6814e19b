//! Calls of single WGSL functions find faults where scenes seldom meet the arguments on which they matter.

use common::mesh::Mesh;
use common::settings::{ItemBufferProjection, Transport, Visibility};
use gpu::function_calls::FUNCTION_CALLS;
use gpu::{Gpu, ShaderFault, ShaderFile, ShaderStage};
use oracle::compare::comparison::StageCheck;
use oracle::compare::function_calls::{check_link_functions, check_shooting_functions};
use pollster::block_on;
use radiosity_tests::engines::shared_gpu;
use radiosity_tests::lit_room;
use radiosity_tests::shader_faults::assert_faults_noticed;
use std::path::Path;

/// Returns the checks of all functions.
fn check_functions(gpu: &Gpu, faults: &[ShaderFault]) -> Vec<StageCheck> {
    let mesh = Mesh::uniform(&lit_room(), 2, 1).unwrap();
    let transport = Transport {
        visibility: Visibility::with_item_buffer(ItemBufferProjection::Stereographic, 64),
        ..Transport::default()
    };
    let mut checks = block_on(check_shooting_functions(&mesh, &transport, (gpu, faults))).unwrap();
    checks.extend(check_link_functions(gpu, faults).unwrap());
    checks
}

#[test]
fn function_calls_notice_faults_at_the_limits_of_branches() {
    assert_faults_noticed("function calls", |faults| {
        let checks = check_functions(shared_gpu(), faults);
        assert_eq!(checks.len(), FUNCTION_CALLS.len());
        assert!(checks.iter().all(|check| check.values >= 12));
        let failing = checks.into_iter().filter(|check| !check.agree);
        failing.map(|check| check.name).collect()
    });
}

#[test]
fn function_that_a_file_does_without_is_not_called() {
    let text = ShaderStage::find("image_bound").unwrap().text;
    for changed in [
        text.replace("edge_distance", "distance_of_edge"),
        text.replace(
            "edge_distance(a: vec3f, b: vec3f)",
            "edge_distance(a: vec3f, b: vec3f, c: f32)",
        )
        .replace("edge_distance(a, b)", "edge_distance(a, b, 0.0)"),
    ] {
        let file = ShaderFile::new("image_bound", Path::new("mine.wgsl"), changed);
        let checks = check_functions(&shared_gpu().clone().with_shader_files(vec![file]), &[]);
        assert!(checks.iter().all(|check| check.agree && check.name != "edge_distance"));
        assert_eq!(checks.len(), FUNCTION_CALLS.len() - 1);
    }
}
