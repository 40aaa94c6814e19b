//! Relighting with two objects in either order.

use super::pairing::Pairing;
use super::scenes::convex_room;
use super::setups::{SolverSetup, check_every_engine, radiosity_distance, reflection_gain, remaining_error};
use common::cover::furnished_mesh;
use common::mesh::Mesh;
use common::relight::{RelightMethod, RelitRoom};
use common::scene::Face;
use common::settings::Schedule;
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use radiosity_tests::random_rooms::{RandomRoom, any_rotation};
use radiosity_tests::relighting::{FurnishedRoom, captured_room};
use radiosity_tests::{box_faces, halve_quads, named_scene};

/// Draws a rotated box in one half of the ball of diameter 1 about (½, ½, ½).
fn any_small_box(half: usize) -> impl Strategy<Value = Vec<Face>> {
    let size = prop::array::uniform3(0.04f64..0.12);
    let look = (prop::array::uniform3(0.0f32..0.8), prop::option::of(0.5f32..4.0));
    (any_rotation(), size, look, any::<bool>()).prop_map(move |(turn, size, (colour, light), triangles)| {
        let centre = DVec3::new(0.27 + 0.46 * half as f64, 0.5, 0.5);
        let size = DVec3::from(size);
        let emission = Vec3::splat(light.unwrap_or(0.0));
        let mut body = named_scene("box", box_faces(-size, size, false, emission, colour.into()));
        for face in &mut body.faces {
            face.corners = face.corners.map(|p| turn * p + centre);
        }
        if triangles {
            halve_quads(&body).faces
        } else {
            body.faces
        }
    })
}

/// Maps boxes from the ball of diameter 1 to the largest ball about the room's centre.
fn place_in_room(cut: &RandomRoom, objects: &[Face]) -> Vec<Face> {
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

/// Relights by single shots with one object of 2×2 texels after the other: the first is part of the room into which the
/// second is put.
fn relight_in_order(way: SolverSetup, cut: &RandomRoom, objects: [&Vec<Face>; 2]) -> (Mesh, RelitRoom) {
    let mut settings = way.settings();
    settings.schedule = Schedule {
        epsilon: 1e-4,
        ..settings.schedule.with_southwell()
    };
    let mut furnished = cut.clone();
    let mut field = way.solve_mesh(&cut.sampled_mesh(way.samples)).field;
    let [_, last] = objects.map(|object| {
        let count = furnished.scene.faces.len();
        furnished.scene.faces.extend_from_slice(object);
        furnished.resolutions.resize(furnished.scene.faces.len(), [2, 2]);
        let points = [furnished.patches, way.samples];
        let mesh = furnished_mesh(&furnished.scene, count, &furnished.resolutions, points, &|| false).unwrap();
        let room = captured_room(&field, &mesh);
        let captured = FurnishedRoom { settings, mesh, room };
        let relit = captured.relight(way.fresh_engine(&captured.mesh).as_mut(), RelightMethod::Signed);
        field = relit.run.field.clone();
        (captured.mesh, relit)
    });
    last
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
            let orders = [[&a, &b], [&b, &a]].map(|objects| relight_in_order(way, &cut, objects));
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
