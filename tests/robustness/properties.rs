//! Properties of the solutions by the dense solver and by shooting on the CPU, in random rooms.

use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::Visibility;
use cpu::dense::Matrix;
use glam::Vec3;
use properties::strategies::{any_axis, any_similarity, closed_room, convex_room, furnished_room, random_keys};
use properties::{
    SceneSolver, Violation, check_closure, check_energy, check_face_order, check_linearity, check_mirror,
    check_monotonicity, check_reciprocity, check_similarity, order_by_keys,
};
use proptest::prelude::*;
use radiosity_tests::dense::solve_matrix;
use radiosity_tests::engines::{settings_of, shoot_on_cpu};
use radiosity_tests::random_cases;
use std::ops::ControlFlow;

/// Rounding of f32, which a bounce adds up.
const ROUNDING: f64 = 1e-5;
/// Error of visibility between boxes, which the dense solver samples.
const SAMPLED_VISIBILITY: f64 = 0.01;
/// Error of the energy by the centroid rule on 8×8 texels: irradiance jumps at the edges of a room.
const CENTROID_RULE: f64 = 0.03;

/// Solves by exact form factors.
fn solve_densely(scene: &Scene, mesh: &Mesh) -> Vec<Vec3> {
    let (matrix, _) = Matrix::assemble(scene, mesh, &mut |_, _| ControlFlow::Continue(())).unwrap();
    let answer = solve_matrix(mesh, &matrix);
    answer.radiosity.iter().map(|b| b.as_vec3()).collect()
}

/// Shoots on the CPU until 10⁻¹⁰ of the light is left, which is little of a channel of 10⁻⁶ of the light, too.
fn solve_by_shots(_: &Scene, mesh: &Mesh) -> Vec<Vec3> {
    let run = shoot_on_cpu(mesh, &settings_of([1, 1, 1], Visibility::Rays, 1e-10));
    assert!(run.converged);
    run.field.radiosity.iter().map(|b| b.truncate()).collect()
}

const SOLVERS: [&SceneSolver; 2] = [&solve_densely, &solve_by_shots];

/// Passes over two faces between which no light passes.
fn allow_unseen(checked: Result<(), Violation>) -> Result<(), Violation> {
    match checked {
        Err(Violation::Nothing { .. }) => Ok(()),
        checked => checked,
    }
}

proptest! {
    #![proptest_config(random_cases(6))]

    #[test]
    fn energy_is_absorbed_or_escapes(furnished in furnished_room(), mut convex in convex_room()) {
        check_energy(&solve_densely, &furnished, SAMPLED_VISIBILITY)?;
        convex.resolutions.fill([8, 8]);
        check_energy(&solve_by_shots, &convex, CENTROID_RULE)?;
    }

    #[test]
    fn furnace_is_even(furnished in closed_room(), convex in convex_room()) {
        check_closure(&solve_densely, &furnished, SAMPLED_VISIBILITY)?;
        check_closure(&solve_densely, &convex, ROUNDING)?;
        check_closure(&solve_by_shots, &convex, ROUNDING)?;
    }

    #[test]
    fn lamp_and_receiver_may_be_swapped(room in furnished_room(), faces in any::<[usize; 2]>()) {
        allow_unseen(check_reciprocity(&solve_densely, &room, faces, ROUNDING))?;
    }

    #[test]
    fn light_adds_up(room in furnished_room()) {
        for solver in SOLVERS {
            check_linearity(solver, &room, ROUNDING)?;
        }
    }

    #[test]
    fn more_light_darkens_nothing(room in furnished_room(), at in any::<usize>()) {
        for solver in SOLVERS {
            check_monotonicity(solver, &room, at, ROUNDING)?;
        }
    }

    #[test]
    fn solution_is_symmetric(
        room in convex_room(),
        (matrix, shift) in any_similarity(),
        axis in any_axis(),
        keys in random_keys(),
    ) {
        let order = order_by_keys(room.scene.faces.len(), &keys);
        for solver in SOLVERS {
            check_similarity(solver, &room, |p| matrix * p + shift, ROUNDING)?;
            check_mirror(solver, &room, axis, ROUNDING)?;
            check_face_order(solver, &room, &order, ROUNDING)?;
        }
    }
}
