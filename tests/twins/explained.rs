//! Mismatches between item buffer and rays that one pixel cannot decide are explained; others not.

use common::mesh::Mesh;
use common::scene::Face;
use common::settings::{Projection, Raster, Transport, Visibility};
use cpu::CpuSolver;
use glam::Vec3;
use gpu::{Fault, Gpu, GpuSolver};
use oracle::judge::compare::sights::sights;
use oracle::judge::comparison::Pairs;
use radiosity_tests::engines::drawn;
use radiosity_tests::pairs::rectangle;
use radiosity_tests::scene;
use std::ops::ControlFlow;

/// A small shooter, a screen that ends just above its horizon, and a wall behind the gap that goes
/// on below: no outline of the wall is near.
fn gap(visibility: Visibility, faults: &[Fault]) -> Pairs {
    let quad = |c| Face::quad("", c, Vec3::ONE, Vec3::ONE);
    let floor = rectangle([-0.05, -0.05, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]);
    let screen = rectangle([1.0, -2.0, 0.02], [0.0, 0.0, 1.0], [0.0, 4.0, 0.0]);
    let wall = rectangle([1.5, -2.0, -2.0], [0.0, 0.0, 4.0], [0.0, 4.0, 0.0]);
    let scene = scene("gap", [floor, screen, wall].map(quad).to_vec());
    let transport = Transport {
        visibility,
        ..Transport::default()
    };
    let gpu = Gpu::open(None).expect("the tests need an adapter: see scripts/driver.sh");
    let mut mesh = Mesh::new(&scene, &[[1, 1], [8, 8], [256, 256]], 1).unwrap();
    mesh.cells.truncate(1);
    let mut solver = GpuSolver::with_faults(&gpu, &mesh, &transport, faults).unwrap();
    let mut cpu = CpuSolver::new(&mesh, &transport);
    sights(&mesh, &transport, &mut cpu, &mut solver, &mut || {
        ControlFlow::Continue(())
    })
    .unwrap()
    .pairs
}

#[test]
fn a_gap_below_a_pixel_is_explained() {
    // The stereographic rim is fine enough to show this gap.
    for visibility in [
        Visibility::drawn(Projection::Hemisphere(Raster::Pixel), 64),
        Visibility::drawn(Projection::Hemicube, 64),
    ] {
        let pairs = gap(visibility, &[]);
        assert!(pairs.vanished > 0, "{visibility:?}: {pairs:?}");
        assert_eq!(pairs.unexplained, 0, "{visibility:?}: {pairs:?}");
    }
    assert_eq!(gap(drawn(64), &[]).mismatched, 0);
}

#[test]
fn a_screen_that_is_not_drawn_is_not() {
    let fault = Fault {
        file: "item_buffer",
        from: "if any(limits.xy >= limits.zw)",
        to: "if face == 1u || any(limits.xy >= limits.zw)",
    };
    assert!(gap(Visibility::drawn(Projection::Hemicube, 64), &[fault]).unexplained > 0);
}
