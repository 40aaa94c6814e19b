//! What a result is judged by: light that follows from the result's own.

use common::mesh::Mesh;
use cpu::hierarchy::anew::anew;
use cpu::hierarchy::solve::{Goal, solve};
use glam::Vec3;
use radiosity_tests::lit_room;
use std::ops::ControlFlow;

#[test]
fn a_result_without_reflected_light_is_told_all_that_it_lacks() {
    let scene = lit_room();
    let mesh = Mesh::uniform(&scene, 8, 1).unwrap();
    let goal = Goal::of(0.005);
    let mut on = |_| ControlFlow::Continue(());
    let whole = solve(&scene, &mesh, &[], goal, &mut on).unwrap().irradiance;
    let dark = vec![Vec3::ZERO; mesh.texels.len()];
    let found = anew(&scene, &mesh, &dark, goal, &mut on).unwrap();
    let (mut off, mut all, mut later) = (0.0, 0.0, 0.0);
    for (k, texel) in mesh.texels.iter().enumerate() {
        let told = found.irradiance[k] + found.later[k];
        off += texel.area * (told - whole[k]).length_squared();
        all += texel.area * whole[k].length_squared();
        later += texel.area * found.later[k].length_squared();
    }
    let [off, later] = [off / all, later / all].map(f32::sqrt);
    println!("{off:.4} off, later bounces {later:.3}");
    // Bounces go over coarse links, which are 2 % off at most, and are not made fine.
    assert!(later > 0.2 && off <= 0.02 * later, "{off} of {later}");
}
