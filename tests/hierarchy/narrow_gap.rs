//! A plate close to an emitting wall: interreflection is as between infinite planes, H = E/(1 − ρρ′) on the plate.

use common::mesh::Mesh;
use common::scene::{Face, Scene};
use cpu::hierarchy::solver::{ErrorBudget, solve_scene};
use glam::Vec3;
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::named_scene;
use std::ops::ControlFlow;

const EMITTED: f32 = 4.0;
const RHO: [f32; 2] = [0.6, 0.7];
const GAP: f64 = 0.05;
const N: u32 = 32;

/// The plate covers 4×16 texels of the wall's 32×32, far from its centre.
fn wall_and_plate() -> Scene {
    let face = |corner, u, v, emission, reflectance| {
        let corners = rectangle(corner, u, v);
        Face::quad("", corners, Vec3::splat(emission), Vec3::splat(reflectance))
    };
    let wall = face([0.0; 3], [96., 0., 0.], [0., 24., 0.], EMITTED, RHO[0]);
    let plate = face([12., 6., GAP], [0., 12., 0.], [12., 0., 0.], 0.0, RHO[1]);
    named_scene("gap", vec![wall, plate])
}

#[test]
fn gap_narrower_than_nodes_is_lit_as_infinite_planes() {
    let scene = wall_and_plate();
    let mesh = Mesh::uniform(&scene, N, 1).unwrap();
    let mut go_on = |_| ControlFlow::Continue(());
    let found = solve_scene(&scene, &mesh, &[], ErrorBudget::for_error(0.01), &mut go_on).unwrap();
    let expected = EMITTED / (1.0 - RHO[0] * RHO[1]);
    // Light leaves through the edges within a few gap widths: less than a texel, which is 7 gaps wide.
    let inside = |k: &usize| {
        let texel = &mesh.texels[*k];
        let within = texel.lattice_corner.map(|i| (1..N - 1).contains(&i));
        texel.face == 1 && within == [true; 2]
    };
    let texels: Vec<usize> = (0..mesh.texels.len()).filter(inside).collect();
    assert_eq!(texels.len(), 30 * 30);
    // 1 % of the RMS of all reflected light, which is a third of that in the gap, and the average over the wall's texels
    // at the edge.
    for k in texels {
        let h = found.irradiance[k].x;
        let off = (h / expected - 1.0).abs();
        assert!(off < 0.02, "{h} instead of {expected}: {:?}", mesh.texels[k]);
    }
}
