//! Ends of rays: fronts, backs, nothing, and a front and a back in one place.

use common::escape::meets_front;
use common::mesh::Mesh;
use common::rays::{RayEnd, Rays};
use common::scene::Face;
use glam::{DVec3, Vec3};
use radiosity_tests::named_scene;

/// A square parallel to the ground, its front up or down.
fn level_square(height: f64, is_front_up: bool) -> Face {
    let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]].map(|[x, z]| DVec3::new(x, height, z));
    let [a, b, c, d] = corners;
    let corners = if is_front_up { corners } else { [a, d, c, b] };
    Face::quad("plate", corners, Vec3::ZERO, Vec3::ONE)
}

/// Returns the end of a ray upwards from the middle of a floor, and whether it meets a front.
fn end_above_floor(plates: &[(f64, bool)]) -> (RayEnd, bool) {
    let plates = plates
        .iter()
        .map(|(height, is_front_up)| level_square(*height, *is_front_up));
    let faces = [level_square(0.0, true)].into_iter().chain(plates).collect();
    let mesh = Mesh::uniform(&named_scene("plates", faces), 1, 1).unwrap();
    let rays = Rays::new(&mesh);
    let floor = &mesh.faces[0];
    let from = mesh.local_point(DVec3::new(0.3, 0.0, 0.4)).as_vec3();
    (
        rays.trace_ray(from, floor.normal, floor.sheet),
        meets_front(&rays, floor.sheet, from, floor.normal),
    )
}

#[test]
fn ray_ends_at_the_nearest_side() {
    let (up, down) = (true, false);
    assert_eq!(end_above_floor(&[]), (RayEnd::Outside, false));
    assert_eq!(end_above_floor(&[(0.5, up)]), (RayEnd::Back, false));
    assert_eq!(end_above_floor(&[(0.25, up), (0.5, down)]), (RayEnd::Back, false));
    for (plates, nearest) in [
        (&[(0.5, down)][..], 1),
        (&[(0.5, down), (0.75, up)], 1),
        (&[(0.75, down), (0.5, down)], 2),
    ] {
        let (end, meets) = end_above_floor(plates);
        assert!(
            matches!(end, RayEnd::Front(face, _) if face == nearest) && meets,
            "{plates:?}: {end:?}"
        );
    }
}

/// The two sides of a sheet: the front takes the light, in either order.
#[test]
fn ray_meets_the_front_of_coinciding_sides() {
    for plates in [[(0.5, true), (0.5, false)], [(0.5, false), (0.5, true)]] {
        let (end, meets) = end_above_floor(&plates);
        assert!(matches!(end, RayEnd::Front(..)) && meets, "{plates:?}: {end:?}");
    }
}

/// Of coinciding fronts a lamp is met, wherever it comes in the file; else the first.
#[test]
fn ray_meets_the_lamp_of_coinciding_fronts() {
    let plate = |emission: f32| Face {
        emission: Vec3::splat(emission),
        ..level_square(0.5, false)
    };
    for (plates, met) in [([0.0, 1.0], 2), ([1.0, 0.0], 1), ([0.0, 0.0], 1), ([1.0, 1.0], 1)] {
        let faces = [level_square(0.0, true)].into_iter().chain(plates.map(plate));
        // Each overlaps the other in part: what is covered wholly has no area.
        let mut faces: Vec<Face> = faces.collect();
        for (face, shift) in faces[1..].iter_mut().zip([-0.1, 0.1]) {
            face.corners.iter_mut().for_each(|corner| corner.x += shift);
        }
        let mesh = Mesh::uniform(&named_scene("plates", faces), 8, 1).unwrap();
        let (rays, floor) = (Rays::new(&mesh), &mesh.faces[0]);
        let from = mesh.local_point(DVec3::new(0.3, 0.0, 0.4)).as_vec3();
        let end = rays.trace_ray(from, floor.normal, floor.sheet);
        let seen = rays.nearest_front(from, floor.normal).map(|(face, _)| face);
        assert!(
            matches!(end, RayEnd::Front(face, _) if face == met),
            "{plates:?}: {end:?}"
        );
        assert_eq!(seen, Some(met), "{plates:?}");
    }
}
