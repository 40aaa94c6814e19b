//! Relighting: without objects, with an object outside the room, twice by one engine, with two objects in either order.

use super::pairing::Pairing;
use super::scenes::{MeshedScene, any_scene, convex_room};
use super::setups::{
    SolverSetup, check_every_engine, check_every_iteration, radiosity_distance, reflection_gain, remaining_error,
};
use common::cover::furnished_mesh;
use common::mesh::Mesh;
use common::passes::Engine;
use common::relight::{RelightMethod, RelitRoom, RoomRadiosity, relight_room};
use common::scene::Face;
use common::settings::Schedule;
use glam::{DQuat, DVec3, EulerRot, Vec3, Vec4};
use proptest::prelude::*;
use radiosity_tests::box_faces;
use std::ops::ControlFlow;

/// Returns the schedule of a relight: single shots, whatever iteration solved the room.
fn single_shot_schedule(way: SolverSetup) -> Schedule {
    Schedule {
        epsilon: 1e-4,
        ..way.settings().schedule.with_southwell()
    }
}

/// Meshes the room of `cut` with `objects` of 2×2 texels in it.
fn mesh_with_objects(cut: &MeshedScene, objects: &[Face], samples: u32) -> Mesh {
    let mut scene = cut.scene.clone();
    scene.faces.extend_from_slice(objects);
    let mut resolutions = cut.resolutions.clone();
    resolutions.resize(scene.faces.len(), [2, 2]);
    let points = [cut.patches, samples];
    furnished_mesh(&scene, cut.scene.faces.len(), &resolutions, points, &|| false).unwrap()
}

/// Makes the captured room of a solution, extended to a mesh with objects.
fn captured_room(radiosity: &[Vec4], residual: &[Vec4], mesh: &Mesh) -> RoomRadiosity {
    let fill = |values: &[Vec4]| {
        let mut all = values.to_vec();
        all.resize(mesh.texels.len(), Vec4::ZERO);
        all
    };
    RoomRadiosity {
        radiosity: fill(radiosity),
        residual: fill(residual),
        reflectance: Some(mesh.texels.iter().map(|t| t.reflectance).collect()),
    }
}

/// Relights until the schedule ends.
fn relight(way: SolverSetup, engine: &mut dyn Engine, mesh: &Mesh, room: &RoomRadiosity) -> RelitRoom {
    let schedule = single_shot_schedule(way);
    relight_room(engine, mesh, room, RelightMethod::Signed, &schedule, &mut |_, _| {
        ControlFlow::Continue(())
    })
    .unwrap()
}

/// Solves the room of `cut` empty and relights it with `objects`.
fn solve_and_relight(way: SolverSetup, cut: &MeshedScene, objects: &[Face]) -> (Mesh, RoomRadiosity, RelitRoom) {
    let empty = way.solve_mesh(&cut.build_mesh(way.samples)).field;
    let mesh = mesh_with_objects(cut, objects, way.samples);
    let room = captured_room(&empty.radiosity, &empty.residual, &mesh);
    let relit = relight(way, way.fresh_engine(&mesh).as_mut(), &mesh, &room);
    (mesh, room, relit)
}

/// Asserts that the room did not change by one bit: with and without the objects its links are the same sums.
fn assert_room_unchanged(mesh: &Mesh, room: &RoomRadiosity, relit: &RelitRoom) -> Result<(), TestCaseError> {
    for (k, texel) in mesh.texels.iter().enumerate() {
        if !mesh.is_object(texel.face) {
            prop_assert_eq!(relit.change.radiosity[k].truncate(), Vec3::ZERO, "texel {}", k);
            prop_assert_eq!(relit.run.field.radiosity[k], room.radiosity[k]);
        }
    }
    Ok(())
}

/// Draws a rotated box in one half of the ball of diameter 1 about (½, ½, ½).
fn any_small_box(half: usize) -> impl Strategy<Value = Vec<Face>> {
    let turn = (-3.0f64..3.0, -3.0f64..3.0, -3.0f64..3.0);
    let size = prop::array::uniform3(0.04f64..0.12);
    let look = (prop::array::uniform3(0.0f32..0.8), prop::option::of(0.5f32..4.0));
    (turn, size, look, any::<bool>()).prop_map(move |((x, y, z), size, (colour, light), triangles)| {
        let turn = DQuat::from_euler(EulerRot::XYZ, x, y, z);
        let centre = DVec3::new(0.27 + 0.46 * half as f64, 0.5, 0.5);
        let size = DVec3::from(size);
        let emission = Vec3::splat(light.unwrap_or(0.0));
        let mut faces = Vec::new();
        for mut face in box_faces(-size, size, false, emission, colour.into()) {
            face.corners = face.corners.map(|p| turn * p + centre);
            let [a, b, c, d] = face.corners;
            if triangles {
                let half = |c| Face::triangle(&face.name, c, face.emission, face.reflectance);
                faces.extend([half([a, b, c]), half([a, c, d])]);
            } else {
                faces.push(face);
            }
        }
        faces
    })
}

/// Maps boxes from the ball of diameter 1 to the largest ball about the room's centre.
fn place_in_room(cut: &MeshedScene, objects: &[Face]) -> Vec<Face> {
    let corners: Vec<DVec3> = cut.scene.faces.iter().flat_map(|f| f.corners).collect();
    let centre = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let distances = (cut.scene.faces.iter()).map(|f| (centre - f.corners[0]).dot(f.vector_area().normalize()));
    let radius = distances.fold(f64::INFINITY, f64::min);
    let place = |face: &Face| Face {
        corners: face.corners.map(|p| centre + (p - 0.5) * 2.0 * radius),
        ..face.clone()
    };
    objects.iter().map(place).collect()
}

/// No object, one without area, and one behind a wall, whose back is black: nothing changes in the room.
#[test]
fn unseen_object_changes_nothing() {
    let drawn = (convex_room(), any_scene(), any_small_box(0), 0..3usize);
    check_every_iteration(1, &drawn, |way, (convex, any, object, kind)| {
        let cut = if kind == 0 { convex } else { any };
        let mut objects = place_in_room(&cut, &object);
        let shift = cut.scene.faces[0].vector_area().normalize() * -20.0;
        for face in &mut objects {
            face.corners = face.corners.map(|p| p + shift);
            face.emission = Vec3::ZERO;
        }
        let point = cut.scene.faces[0].point_at(0.25, 0.25);
        let flat = Face::quad("flat", [point; 4], Vec3::ONE, Vec3::splat(0.5));
        let objects = [objects, vec![], vec![flat]].into_iter().nth(kind).unwrap();
        let (mesh, room, relit) = solve_and_relight(way, &cut, &objects);
        prop_assert!(relit.map_shots > 0 && (kind == 0 || relit.object_shots == 0));
        assert_room_unchanged(&mesh, &room, &relit)
    });
}

/// An engine keeps no state between relights: a second one from the same captured room is identical. The object does
/// change the room.
#[test]
fn second_relight_by_same_engine_is_identical() {
    check_every_engine(2, &(convex_room(), any_small_box(1)), |way, (cut, object)| {
        let object = place_in_room(&cut, &object);
        let empty = way.solve_mesh(&cut.build_mesh(way.samples)).field;
        let mesh = mesh_with_objects(&cut, &object, way.samples);
        let room = captured_room(&empty.radiosity, &empty.residual, &mesh);
        let mut engine = way.fresh_engine(&mesh);
        let [first, second] = [(); 2].map(|()| relight(way, engine.as_mut(), &mesh, &room));
        prop_assert_eq!(&first.run.shots, &second.run.shots);
        prop_assert_eq!(&first.run.field, &second.run.field);
        prop_assert!(first.change.radiosity.iter().any(|d| d.truncate() != Vec3::ZERO));
        // The empty room solved again is identical as well.
        let again = way.solve_mesh(&cut.build_mesh(way.samples)).field;
        prop_assert_eq!(again, empty);
        Ok(())
    });
}

/// Relights with one object after the other: the first is part of the room into which the second is put.
fn relight_in_order(way: SolverSetup, cut: &MeshedScene, first: &[Face], second: &[Face]) -> (Mesh, RelitRoom) {
    let (_, _, one) = solve_and_relight(way, cut, first);
    let mut furnished = cut.clone();
    furnished.scene.faces.extend_from_slice(first);
    furnished.resolutions.resize(furnished.scene.faces.len(), [2, 2]);
    let mesh = mesh_with_objects(&furnished, second, way.samples);
    let field = &one.run.field;
    let room = captured_room(&field.radiosity, &field.residual, &mesh);
    let relit = relight(way, way.fresh_engine(&mesh).as_mut(), &mesh, &room);
    (mesh, relit)
}

/// Either order converges to the full solution. With one sample, which does not depend on the numbering of faces, the two
/// orders also agree with each other.
#[test]
fn relight_does_not_depend_on_order_of_objects() {
    check_every_engine(
        4,
        &(convex_room(), any_small_box(0), any_small_box(1)),
        |way, (cut, a, b)| {
            let [a, b] = [a, b].map(|object| place_in_room(&cut, &object));
            let orders = [relight_in_order(way, &cut, &a, &b), relight_in_order(way, &cut, &b, &a)];
            let mut bounds = [0.0; 2];
            for ((mesh, relit), bound) in orders.iter().zip(&mut bounds) {
                let mut whole = mesh.clone();
                whole.room_faces = whole.faces.len() as u32;
                let gain = reflection_gain(&whole, &way.link_rows(&whole));
                prop_assume!(gain < 100.0);
                let full = way.solve_mesh(&whole);
                let found = radiosity_distance(mesh, &relit.run.field, &full.field, |k| k);
                *bound = remaining_error(mesh, gain, &[&relit.run]);
                let bound = *bound + remaining_error(mesh, gain, &[&full]);
                prop_assert!(found <= bound, "{found:e} > {bound:e}");
            }
            if way.samples == 1 {
                let [(one, first), (two, second)] = &orders;
                let pairs = Pairing::new(one, two, |p| p);
                let found = radiosity_distance(one, &first.run.field, &second.run.field, |k| pairs.texels[k]);
                let bound = bounds[0] + bounds[1];
                prop_assert!(found <= bound, "{found:e} > {bound:e}");
            }
            Ok(())
        },
    );
}
