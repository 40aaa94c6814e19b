//! Each property holds for a small solver, and finds a fault that is planted in it.

mod solver;

use common::mesh::Mesh;
use common::scene::Scene;
use glam::{DVec3, Vec3};
use properties::{
    MeshedScene, SceneSolver, Violation, box_faces, check_closure, check_corner_order, check_energy, check_face_order,
    check_linearity, check_mirror, check_monotonicity, check_reciprocity, check_similarity, check_split, named_scene,
    order_by_keys, strategies,
};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use solver::{Fault, HONEST, gather_light};

/// Tolerance of properties that hold up to rounding and the light that is left after the last bounce.
const ROUNDING: f64 = 2e-5;
/// Tolerance of properties that hold up to the centroid rule: of texels, on which irradiance is that of the centre.
const CENTROID_RULE: f64 = 0.08;
/// Random rooms of each test.
const ROOMS: usize = 6;

/// A property of one room, and what it draws with it.
type Property<D> = fn(&SceneSolver, &MeshedScene, &D) -> Result<(), Violation>;

/// Checks that the honest solver has a property in random convex rooms, and that one with the fault lacks it in some.
fn find_fault<S: Strategy>(drawn: &S, property: Property<S::Value>, (name, fault): (&str, Fault)) {
    let mut runner = TestRunner::deterministic();
    let strategy = (strategies::convex_room(), drawn);
    let mut found = Vec::new();
    for _ in 0..ROOMS {
        let (room, drawn) = strategy.new_tree(&mut runner).unwrap().current();
        let solve = |fault: Fault| move |_: &Scene, mesh: &Mesh| gather_light(mesh, fault);
        property(&solve(HONEST), &room, &drawn).unwrap_or_else(|violation| panic!("{violation}\n{room:?}"));
        found.extend(property(&solve(fault), &room, &drawn).err());
    }
    let is_difference = |violation: &Violation| matches!(violation, Violation::Differs { .. });
    assert!(found.iter().any(is_difference), "{name} is not found: {found:?}");
    println!("{name}: {}", found[0]);
}

/// Draws what a property needs beside the scene.
fn nothing() -> Just<()> {
    Just(())
}

#[test]
fn energy_finds_lost_light() {
    let fault = Fault {
        irradiance: |_, h| h * 0.8,
        ..HONEST
    };
    find_fault(
        &nothing(),
        |solver, room, ()| check_energy(solver, room, CENTROID_RULE),
        ("a fifth is lost", fault),
    );
}

#[test]
fn closure_finds_reflectance_applied_twice() {
    let fault = Fault {
        irradiance: |texel, h| texel.reflectance * h,
        ..HONEST
    };
    find_fault(
        &nothing(),
        |solver, room, ()| check_closure(solver, room, ROUNDING),
        ("ρ applied twice", fault),
    );
}

#[test]
fn reciprocity_finds_swapped_areas() {
    let fault = Fault {
        link: |mesh, k, i| mesh.texels[k].area / mesh.patches[i].shooter.area,
        ..HONEST
    };
    let faces = any::<[usize; 2]>().prop_filter("two faces", |[i, j]| i % 2 != j % 2);
    let check: Property<[usize; 2]> = |solver, room, faces| match check_reciprocity(solver, room, *faces, 0.3) {
        // Both halves of a wall, or the same face.
        Err(Violation::Nothing { .. }) => Ok(()),
        checked => checked,
    };
    find_fault(&faces, check, ("A_i F_ij for A_j F_ji", fault));
}

#[test]
fn linearity_finds_clamped_light() {
    let fault = Fault {
        irradiance: |_, h| h.min(Vec3::ONE),
        ..HONEST
    };
    find_fault(
        &nothing(),
        |solver, room, ()| check_linearity(solver, room, 1e-4),
        ("clamped to 1", fault),
    );
}

#[test]
fn monotonicity_finds_automatic_exposure() {
    let exposed = |mesh: &Mesh, _: usize, _: usize| {
        let emissions = mesh.texels.iter().map(|texel| texel.emission.max_element());
        1.0 / (1.0 + emissions.fold(0.0, f32::max).powi(2))
    };
    let fault = Fault {
        link: exposed,
        ..HONEST
    };
    let check: Property<usize> = |solver, room, at| check_monotonicity(solver, room, *at, ROUNDING);
    find_fault(&any::<usize>(), check, ("exposed by the brightest", fault));
}

#[test]
fn similarity_finds_fixed_up_axis() {
    let fault = Fault {
        link: |mesh, k, _| 1.0 + 0.1 * mesh.faces[mesh.texels[k].face as usize].normal.y,
        ..HONEST
    };
    let check: Property<_> = |solver, room, (matrix, shift): &(glam::DMat3, DVec3)| {
        check_similarity(solver, room, |p| *matrix * p + *shift, ROUNDING)
    };
    find_fault(&strategies::any_similarity(), check, ("more light from above", fault));
}

#[test]
fn mirror_finds_handedness() {
    // Light from the left of a face's longest edge.
    let left = |mesh: &Mesh, k: usize, i: usize| {
        let face = &mesh.faces[mesh.texels[k].face as usize];
        let way = (mesh.patches[i].shooter.centre - mesh.texels[k].position).normalize_or_zero();
        1.0 + 0.1 * way.dot(face.normal.cross(face.tangent))
    };
    let check: Property<DVec3> = |solver, room, axis| check_mirror(solver, room, *axis, ROUNDING);
    find_fault(
        &strategies::any_axis(),
        check,
        ("light from the left", Fault { link: left, ..HONEST }),
    );
}

#[test]
fn order_of_faces_finds_forgotten_patch() {
    let fault = Fault {
        link: |_, _, i| if i == 0 { 0.0 } else { 1.0 },
        ..HONEST
    };
    let check: Property<Vec<u32>> =
        |solver, room, keys| check_face_order(solver, room, &order_by_keys(room.scene.faces.len(), keys), ROUNDING);
    find_fault(
        &strategies::random_keys(),
        check,
        ("the first patch is forgotten", fault),
    );
}

/// Makes a lit box of quads, whose patches do not depend on their first corners, of the colours of a room.
fn quads_only(room: &MeshedScene) -> MeshedScene {
    let size = DVec3::new(1.0, 2.0, 1.5);
    let mut faces = box_faces(DVec3::ZERO, size, true, Vec3::ZERO, Vec3::splat(0.5));
    for (face, other) in faces.iter_mut().zip(&room.scene.faces) {
        (face.emission, face.reflectance) = (other.emission, other.reflectance);
    }
    faces[1].emission = Vec3::ONE;
    MeshedScene {
        scene: named_scene("quads", faces),
        resolutions: vec![[2, 4]; 6],
        patches: 4,
    }
}

#[test]
fn order_of_corners_finds_preferred_corner() {
    let near_first = |mesh: &Mesh, k: usize, _: usize| {
        let corner = mesh.faces[mesh.texels[k].face as usize].corners[0];
        1.0 / (1.0 + corner.distance(mesh.texels[k].position))
    };
    let check: Property<Vec<u32>> = |solver, room, keys| check_corner_order(solver, &quads_only(room), keys, ROUNDING);
    find_fault(
        &strategies::random_keys(),
        check,
        (
            "light near corner 0",
            Fault {
                link: near_first,
                ..HONEST
            },
        ),
    );
}

#[test]
fn split_finds_light_by_number_of_texels() {
    let by_texels = |mesh: &Mesh, k: usize, _: usize| {
        let [w, h] = mesh.faces[mesh.texels[k].face as usize].resolution;
        (w * h) as f32 / 8.0
    };
    let check: Property<usize> = |solver, room, at| check_split(solver, &quads_only(room), *at, ROUNDING);
    find_fault(
        &any::<usize>(),
        check,
        (
            "light by the number of texels",
            Fault {
                link: by_texels,
                ..HONEST
            },
        ),
    );
}

/// Makes a closed unit cube whose first face emits `emission`.
fn cube(emission: f32) -> MeshedScene {
    let mut faces = box_faces(DVec3::ZERO, DVec3::ONE, true, Vec3::ZERO, Vec3::splat(0.5));
    faces[0].emission = Vec3::splat(emission);
    MeshedScene {
        scene: named_scene("cube", faces),
        resolutions: vec![[2, 2]; 6],
        patches: 2,
    }
}

#[test]
fn outputs_that_cannot_be_compared_are_violations() {
    let honest = |_: &Scene, mesh: &Mesh| gather_light(mesh, HONEST);
    let change = |change: fn(&mut Vec<Vec3>)| {
        move |_: &Scene, mesh: &Mesh| {
            let mut values = gather_light(mesh, HONEST);
            change(&mut values);
            values
        }
    };
    let message = |solver: &SceneSolver| check_linearity(solver, &cube(1.0), 1e-4).unwrap_err().to_string();
    assert_eq!(
        message(&change(Vec::clear)),
        "the solver returned 0 values for 24 texels"
    );
    assert_eq!(
        message(&change(|b| b[5].y = f32::NAN)),
        "the solver returned NaN for texel 1 of face 2 (ceiling), green"
    );
    assert_eq!(
        message(&change(|b| b[0].x = -1.0)),
        "the solver returned -1 for texel 0 of face 1 (floor), red"
    );
    assert!(message(&change(|b| b.fill(Vec3::ZERO))).contains("0 for all texels"));

    let nothing = |checked: Result<(), Violation>| matches!(checked, Err(Violation::Nothing { .. }));
    assert!(nothing(check_energy(&honest, &cube(0.0), 1e-4)));
    assert!(nothing(check_linearity(&honest, &cube(0.0), 1e-4)));
    assert!(nothing(check_reciprocity(&honest, &cube(0.0), [1, 7], 1e-4)));
    assert!(nothing(check_face_order(&honest, &cube(1.0), &[0, 1, 2], 1e-4)));
    assert!(nothing(check_mirror(&honest, &cube(0.0), DVec3::X, 1e-4)));
    for tolerance in [f64::NAN, f64::INFINITY, -1.0, 1.0] {
        assert!(nothing(check_closure(&honest, &cube(1.0), tolerance)), "{tolerance}");
    }
    let mut open = cube(1.0);
    open.scene.faces.pop();
    open.resolutions.pop();
    assert!(nothing(check_closure(&honest, &open, 1e-4)));
    check_energy(&honest, &open, CENTROID_RULE).unwrap();
}
