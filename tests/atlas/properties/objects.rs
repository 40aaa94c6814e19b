//! Objects in a room: none, outside, in again, and two in either order.

use super::kit::{Way, apart, every_engine, every_way, gain, left};
use super::places::Pairing;
use super::scenes::{Cut, any_scene, convex};
use common::cover::furnished;
use common::mesh::Mesh;
use common::relight::{Method, Relit, Room};
use common::scene::Face;
use common::settings::Schedule;
use glam::{DQuat, DVec3, EulerRot, Vec3, Vec4};
use proptest::prelude::*;
use radiosity_tests::relighting::run;
use radiosity_tests::room;

/// The schedule of a relight: single shots, whatever the room was solved by.
fn schedule(way: Way) -> Schedule {
    Schedule {
        epsilon: 1e-4,
        ..way.settings().schedule.one_by_one()
    }
}

/// The room of `cut` with `objects` of 2×2 texels in it.
fn with(cut: &Cut, objects: &[Face], samples: u32) -> Mesh {
    let mut scene = cut.scene.clone();
    scene.faces.extend_from_slice(objects);
    let mut resolutions = cut.resolutions.clone();
    resolutions.resize(scene.faces.len(), [2, 2]);
    let points = [cut.cells, samples];
    furnished(&scene, cut.scene.faces.len(), &resolutions, points).unwrap()
}

/// What was found out of a room, for a mesh with more in it.
fn captured(radiosity: &[Vec4], residual: &[Vec4], mesh: &Mesh) -> Room {
    let fill = |values: &[Vec4]| {
        let mut all = values.to_vec();
        all.resize(mesh.texels.len(), Vec4::ZERO);
        all
    };
    Room {
        radiosity: fill(radiosity),
        residual: fill(residual),
        reflectance: Some(mesh.texels.iter().map(|t| t.reflectance).collect()),
    }
}

/// A relight to its end, by a fresh engine.
fn relight(way: Way, mesh: &Mesh, room: &Room) -> Relit {
    let mut engine = way.engine(mesh);
    run(engine.as_mut(), mesh, room, Method::Signed, &schedule(way))
}

/// The room of `cut`, solved by `way`, with `objects`.
fn relit(way: Way, cut: &Cut, objects: &[Face]) -> (Mesh, Room, Relit) {
    let empty = way.solve(&cut.mesh(way.samples)).field;
    let mesh = with(cut, objects, way.samples);
    let room = captured(&empty.radiosity, &empty.residual, &mesh);
    let relit = relight(way, &mesh, &room);
    (mesh, room, relit)
}

/// Not by one bit: what the room gives itself with and without the objects are the same sums.
fn unchanged(mesh: &Mesh, room: &Room, relit: &Relit) -> Result<(), TestCaseError> {
    for (k, texel) in mesh.texels.iter().enumerate() {
        if !mesh.is_object(texel.face) {
            prop_assert_eq!(
                relit.change.radiosity[k].truncate(),
                Vec3::ZERO,
                "texel {}",
                k
            );
            prop_assert_eq!(relit.run.field.radiosity[k], room.radiosity[k]);
        }
    }
    Ok(())
}

#[test]
fn no_object_changes_nothing() {
    every_way(1, &(any_scene(), any::<bool>()), |way, (cut, nothing)| {
        // None, or one without area.
        let point = cut.scene.faces[0].point(0.25, 0.25);
        let flat = Face::quad("flat", [point; 4], Vec3::ONE, Vec3::splat(0.5));
        let objects = if nothing { vec![] } else { vec![flat] };
        let (mesh, room, relit) = relit(way, &cut, &objects);
        prop_assert!(relit.map_shots > 0 && relit.object_shots == 0);
        unchanged(&mesh, &room, &relit)
    });
}

/// A box in the ball of diameter 1 about (½, ½, ½), turned; `half` says in which half of it.
fn body(half: usize) -> impl Strategy<Value = Vec<Face>> {
    let turn = (-3.0f64..3.0, -3.0f64..3.0, -3.0f64..3.0);
    let size = prop::array::uniform3(0.04f64..0.12);
    let look = (
        prop::array::uniform3(0.0f32..0.8),
        prop::option::of(0.5f32..4.0),
    );
    (turn, size, look, any::<bool>()).prop_map(
        move |((x, y, z), size, (colour, light), triangles)| {
            let turn = DQuat::from_euler(EulerRot::XYZ, x, y, z);
            let centre = DVec3::new(0.27 + 0.46 * half as f64, 0.5, 0.5);
            let size = DVec3::from(size);
            let emission = Vec3::splat(light.unwrap_or(0.0));
            let mut faces = Vec::new();
            for mut face in room(-size, size, false, emission, colour.into()) {
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
        },
    )
}

/// The boxes in the largest ball about the room's middle, whose diameter is 1 to them.
fn placed(cut: &Cut, objects: &[Face]) -> Vec<Face> {
    let corners: Vec<DVec3> = cut.scene.faces.iter().flat_map(|f| f.corners).collect();
    let centre = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let distances =
        (cut.scene.faces.iter()).map(|f| (centre - f.corners[0]).dot(f.vector_area().normalize()));
    let radius = distances.fold(f64::INFINITY, f64::min);
    let place = |face: &Face| Face {
        corners: face.corners.map(|p| centre + (p - 0.5) * 2.0 * radius),
        ..face.clone()
    };
    objects.iter().map(place).collect()
}

/// Backs of walls are black: what stands behind them changes nothing in the room.
#[test]
fn an_object_outside_changes_nothing() {
    every_engine(2, &(convex(), body(0)), |way, (cut, object)| {
        let mut object = placed(&cut, &object);
        let shift = cut.scene.faces[0].vector_area().normalize() * -20.0;
        for face in &mut object {
            face.corners = face.corners.map(|p| p + shift);
            face.emission = Vec3::ZERO;
        }
        let (mesh, room, relit) = relit(way, &cut, &object);
        unchanged(&mesh, &room, &relit)
    });
}

/// In, and the same engine once more from the captured room: it remembers nothing. And where it was
/// put in, something has changed.
#[test]
fn in_and_in_again_is_in_once() {
    every_engine(2, &(convex(), body(1)), |way, (cut, object)| {
        let object = placed(&cut, &object);
        let empty = way.solve(&cut.mesh(way.samples)).field;
        let mesh = with(&cut, &object, way.samples);
        let room = captured(&empty.radiosity, &empty.residual, &mesh);
        let mut engine = way.engine(&mesh);
        let [first, second] = [(); 2].map(|()| {
            run(
                engine.as_mut(),
                &mesh,
                &room,
                Method::Signed,
                &schedule(way),
            )
        });
        prop_assert_eq!(&first.run.shots, &second.run.shots);
        prop_assert_eq!(&first.run.field, &second.run.field);
        prop_assert!(
            first
                .change
                .radiosity
                .iter()
                .any(|d| d.truncate() != Vec3::ZERO)
        );
        // Out again: the room is captured anew from the faces that are left.
        let again = way.solve(&cut.mesh(way.samples)).field;
        prop_assert_eq!(again, empty);
        Ok(())
    });
}

/// One after the other: the first one is part of the room that the second one is put into.
fn both(way: Way, cut: &Cut, first: &[Face], second: &[Face]) -> (Mesh, Relit) {
    let (_, _, one) = relit(way, cut, first);
    let mut furnished = cut.clone();
    furnished.scene.faces.extend_from_slice(first);
    furnished
        .resolutions
        .resize(furnished.scene.faces.len(), [2, 2]);
    let mesh = with(&furnished, second, way.samples);
    let field = &one.run.field;
    let room = captured(&field.radiosity, &field.residual, &mesh);
    let relit = relight(way, &mesh, &room);
    (mesh, relit)
}

/// The limit of either order is the solution of everything; with one sample, which knows no numbers,
/// so is that of the two orders.
#[test]
fn two_objects_in_either_order_are_both_at_once() {
    every_engine(4, &(convex(), body(0), body(1)), |way, (cut, a, b)| {
        let [a, b] = [a, b].map(|object| placed(&cut, &object));
        let orders = [both(way, &cut, &a, &b), both(way, &cut, &b, &a)];
        let mut bounds = [0.0; 2];
        for ((mesh, relit), bound) in orders.iter().zip(&mut bounds) {
            let mut whole = mesh.clone();
            whole.room = whole.faces.len() as u32;
            let gain = gain(&whole, &way.links(&whole));
            prop_assume!(gain < 100.0);
            let full = way.solve(&whole);
            let found = apart(mesh, &relit.run.field, &full.field, |k| k);
            *bound = left(mesh, gain, &[&relit.run]);
            let bound = *bound + left(mesh, gain, &[&full]);
            prop_assert!(found <= bound, "{found:e} > {bound:e}");
        }
        if way.samples == 1 {
            let [(one, first), (two, second)] = &orders;
            let pairs = Pairing::new(one, two, |p| p);
            let found = apart(one, &first.run.field, &second.run.field, |k| {
                pairs.texels[k]
            });
            let bound = bounds[0] + bounds[1];
            prop_assert!(found <= bound, "{found:e} > {bound:e}");
        }
        Ok(())
    });
}
