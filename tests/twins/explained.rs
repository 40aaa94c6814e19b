//! `compare` explains those mismatches between item buffer and rays that lie below a pixel, and no others.

use common::mesh::Mesh;
use common::scene::Face;
use common::settings::{ItemBufferProjection, Raster, Transport, Visibility};
use cpu::CpuSolver;
use glam::Vec3;
use gpu::{Gpu, GpuSolver, ShaderFault};
use oracle::compare::comparison::VisibilityStatistics;
use oracle::compare::visibility::check_visibility;
use radiosity_tests::engines::item_buffer;
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::named_scene;
use radiosity_tests::shader_faults::shader_fault;
use std::ops::ControlFlow;

/// A small shooter, a screen that ends just above its horizon, and a wall behind the gap that goes
/// on below: no outline of the wall is near.
fn gap_statistics(visibility: Visibility, faults: &[ShaderFault]) -> VisibilityStatistics {
    let quad = |c| Face::quad("", c, Vec3::ONE, Vec3::ONE);
    let floor = rectangle([-0.05, -0.05, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]);
    let screen = rectangle([1.0, -2.0, 0.02], [0.0, 0.0, 1.0], [0.0, 4.0, 0.0]);
    let wall = rectangle([1.5, -2.0, -2.0], [0.0, 0.0, 4.0], [0.0, 4.0, 0.0]);
    let scene = named_scene("gap", [floor, screen, wall].map(quad).to_vec());
    let transport = Transport {
        visibility,
        ..Transport::default()
    };
    let gpu = Gpu::open(None).expect("the tests need an adapter: see scripts/driver.sh");
    let mut mesh = Mesh::new(&scene, &[[1, 1], [8, 8], [256, 256]], 1).unwrap();
    mesh.patches.truncate(1);
    let mut solver = GpuSolver::with_faults(&gpu, &mesh, &transport, faults).unwrap();
    let mut cpu = CpuSolver::new(&mesh, &transport);
    check_visibility(&mesh, &transport, &mut cpu, &mut solver, &mut || {
        ControlFlow::Continue(())
    })
    .unwrap()
    .statistics
}

#[test]
fn gap_narrower_than_pixel_is_explained() {
    // The stereographic rim is fine enough to show this gap.
    for visibility in [
        Visibility::with_item_buffer(ItemBufferProjection::Hemisphere(Raster::Pixel), 64),
        Visibility::with_item_buffer(ItemBufferProjection::Hemicube, 64),
    ] {
        let pairs = gap_statistics(visibility, &[]);
        assert!(pairs.vanished > 0, "{visibility:?}: {pairs:?}");
        assert_eq!(pairs.unexplained, 0, "{visibility:?}: {pairs:?}");
    }
    assert_eq!(gap_statistics(item_buffer(64), &[]).mismatched, 0);
}

#[test]
fn missing_screen_is_not_explained() {
    let fault = shader_fault(
        "item_buffer",
        "let empty = any(limits.xy >= limits.zw);",
        "let empty = face == 1u || any(limits.xy >= limits.zw);",
    );
    assert!(
        gap_statistics(
            Visibility::with_item_buffer(ItemBufferProjection::Hemicube, 64),
            &[fault]
        )
        .unexplained
            > 0
    );
}
