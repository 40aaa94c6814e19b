//! `compare` explains those mismatches between item buffer and rays that lie below a pixel, and no others.

use common::mesh::Mesh;
use common::scene::Face;
use common::settings::{ItemBufferProjection, Settings, Visibility};
use glam::Vec3;
use gpu::ShaderFault;
use oracle::compare::comparison::VisibilityStatistics;
use radiosity_tests::engines::{hemicube, item_buffer};
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::named_scene;
use radiosity_tests::shader_faults::{assert_faults_noticed, visibility_statistics};

/// A small shooter, a screen that ends just above its horizon, and a wall behind the gap that goes
/// on below: no outline of the wall is near.
fn gap_statistics(visibility: Visibility, faults: &[ShaderFault]) -> VisibilityStatistics {
    let quad = |c| Face::quad("", c, Vec3::ONE, Vec3::ONE);
    let floor = rectangle([-0.05, -0.05, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]);
    let screen = rectangle([1.0, -2.0, 0.02], [0.0, 0.0, 1.0], [0.0, 4.0, 0.0]);
    let wall = rectangle([1.5, -2.0, -2.0], [0.0, 0.0, 4.0], [0.0, 4.0, 0.0]);
    let scene = named_scene("gap", [floor, screen, wall].map(quad).to_vec());
    let transport = Settings::default().with_visibility(visibility).transport;
    let mut mesh = Mesh::new(&scene, &[[1, 1], [8, 8], [256, 256]], 1).unwrap();
    mesh.patches.truncate(1);
    visibility_statistics(&mesh, &transport, faults)
}

#[test]
fn gap_narrower_than_pixel_is_explained() {
    // The stereographic rim is fine enough to show this gap.
    let hemisphere = ItemBufferProjection::Hemisphere;
    for visibility in [Visibility::with_item_buffer(hemisphere, 64), hemicube(64)] {
        let pairs = gap_statistics(visibility, &[]);
        assert!(pairs.vanished > 0, "{visibility:?}: {pairs:?}");
        assert_eq!(pairs.unexplained, 0, "{visibility:?}: {pairs:?}");
    }
    assert_eq!(gap_statistics(item_buffer(64), &[]).mismatched, 0);
}

#[test]
fn missing_screen_is_not_explained() {
    assert_faults_noticed("gap", |faults| {
        let unexplained = gap_statistics(hemicube(64), faults).unexplained;
        (unexplained > 0)
            .then(|| "unexplained".to_owned())
            .into_iter()
            .collect()
    });
}
