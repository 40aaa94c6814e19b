//! The residual of a solution: light that follows from the solution's radiosity.

use common::mesh::Mesh;
use cpu::hierarchy::residual::gather_residual;
use cpu::hierarchy::solver::{ErrorBudget, solve_scene};
use glam::Vec3;
use radiosity_tests::lit_room;
use std::ops::ControlFlow;

#[test]
fn residual_of_dark_solution_is_all_reflected_light() {
    let scene = lit_room();
    let mesh = Mesh::uniform(&scene, 8, 1).unwrap();
    let goal = ErrorBudget::for_error(0.005);
    let mut go_on = |_| ControlFlow::Continue(());
    let whole = solve_scene(&scene, &mesh, &[], goal, &mut go_on).unwrap().irradiance;
    let dark = vec![Vec3::ZERO; mesh.texels.len()];
    let gathered = gather_residual(&scene, &mesh, &dark, goal, &mut go_on).unwrap();
    let (mut off, mut all, mut later) = (0.0, 0.0, 0.0);
    for (k, texel) in mesh.texels.iter().enumerate() {
        let total = gathered.irradiance[k] + gathered.later[k];
        off += texel.area * (total - whole[k]).length_squared();
        all += texel.area * whole[k].length_squared();
        later += texel.area * gathered.later[k].length_squared();
    }
    let [off, later] = [off / all, later / all].map(f32::sqrt);
    // Further bounces use coarse links, whose error is 2 % at most, without correction.
    assert!(later > 0.2 && off <= 0.02 * later, "{off} of {later}");
}
