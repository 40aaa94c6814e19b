//! Lamps without a surface in the file: small bodies around a point, with faces that emit.

use super::surface::is_solvable_emission;
use crate::scene::{Face, Scene};
use glam::{DVec3, Vec3};

/// Radius of a lamp, as a share of the scene's extent.
const LAMP_RADIUS_SHARE: f64 = 1.0 / 400.0;
/// Distance of a lamp's centre from other faces, in radii.
const CLEARANCE_RADII: f64 = 2.0;
/// Steps by which a lamp is moved off the faces that it touches.
const MAX_MOVES: usize = 16;
/// Smallest distance of a lamp's centre from other faces, as a share of the scene's extent.
const MIN_DISTANCE_SHARE: f64 = 1e-5;

/// Corner indices of an icosahedron's faces, three each, counter-clockwise as seen from outside.
const ICOSAHEDRON_CORNERS: [usize; 60] = [
    0, 4, 1, 0, 1, 6, 0, 8, 4, 0, 6, 9, 0, 9, 8, 1, 4, 10, 1, 11, 6, 1, 10, 11, 2, 3, 5, 2, 7, 3, 2, 5, 8, 2, 9, 7, 2,
    8, 9, 3, 10, 5, 3, 7, 11, 3, 11, 10, 4, 8, 5, 4, 5, 10, 6, 7, 9, 6, 11, 7,
];

/// Adds a lamp at a point: an icosahedron that emits `power` watts in each channel and reflects nothing. A lamp that would
/// touch a face is moved off it, in front of the face where it stands on one, and a note says so.
///
/// Errors: there is no place for it, or its power cannot be solved.
pub fn add_lamp(scene: &mut Scene, name: &str, at: DVec3, power: f64) -> Result<(), String> {
    let corners = scene.faces.iter().flat_map(Face::outline).copied();
    let radius = lamp_radius(corners.chain([at]));
    let extent = radius / LAMP_RADIUS_SHARE;
    let (centre, distance) = find_place(scene, at, CLEARANCE_RADII * radius);
    if distance.is_nan() || distance <= MIN_DISTANCE_SHARE * extent {
        return Err("has no room between the faces around it".into());
    }
    let sides = icosahedron_faces(centre, radius.min(distance / CLEARANCE_RADII));
    let mut faces: Vec<Face> = sides
        .into_iter()
        .map(|[a, b, c]| Face::triangle(name, [a, b, c], Vec3::ZERO, Vec3::ZERO))
        .collect();
    let area: f64 = faces.iter().map(Face::area).sum();
    let emission = Vec3::splat((power / area) as f32);
    // The light of a large lamp may be 0 in rounding.
    if emission == Vec3::ZERO || !is_solvable_emission(emission) {
        return Err(format!("emits {power} W from {area:.1e}, which cannot be solved"));
    }
    faces.iter_mut().for_each(|face| face.emission = emission);
    scene.faces.append(&mut faces);
    let moved = centre.distance(at);
    if moved > 0.0 {
        let DVec3 { x, y, z } = centre;
        scene.notes.push(format!(
            "{name} is moved by {moved:.2e} to {x:.4},{y:.4},{z:.4}, where it touches nothing"
        ));
    }
    Ok(())
}

/// Returns the radius of a lamp among these points.
pub(super) fn lamp_radius(points: impl Iterator<Item = DVec3>) -> f64 {
    let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let [low, high] = points.fold(none, |[low, high], p| [low.min(p), high.max(p)]);
    let extent = (high - low).max_element();
    LAMP_RADIUS_SHARE * if extent > 0.0 { extent } else { 1.0 }
}

/// Moves a point off the nearest face until it is `clearance` away from all faces. Returns the place of the most steps
/// with its distance.
fn find_place(scene: &Scene, at: DVec3, clearance: f64) -> (DVec3, f64) {
    let mut best = (at, f64::NEG_INFINITY);
    let mut place = at;
    for _ in 0..MAX_MOVES {
        let near = |face: &Face| (nearest_point(face, place).distance(place), face.vector_area());
        let distances = scene.faces.iter().map(near);
        let Some((distance, normal)) = distances.min_by(|a, b| a.0.total_cmp(&b.0)) else {
            return (place, f64::INFINITY);
        };
        if distance > best.1 {
            best = (place, distance);
        }
        if distance >= clearance {
            break;
        }
        let nearest = |face: &&Face| nearest_point(face, place).distance(place) == distance;
        let foot = scene
            .faces
            .iter()
            .find(nearest)
            .map_or(place, |face| nearest_point(face, place));
        let away = match distance > 1e-6 * clearance {
            true => (place - foot) / distance,
            false => normal.normalize_or_zero(),
        };
        // Never through another face: half way to it.
        let beyond = scene.faces.iter().filter_map(|face| ray_distance(face, foot, away));
        let free = beyond.filter(|t| *t > 1e-6 * clearance).fold(f64::INFINITY, f64::min);
        place = foot + away * (1.01 * clearance).min(0.5 * free);
    }
    best
}

/// Returns the point of a face that is nearest to `p`.
fn nearest_point(face: &Face, p: DVec3) -> DVec3 {
    let (outline, normal) = (face.outline(), face.vector_area().normalize_or_zero());
    let edges = || outline.iter().zip(outline.iter().cycle().skip(1));
    let foot = p - normal * normal.dot(p - outline[0]);
    if normal != DVec3::ZERO && edges().all(|(a, b)| normal.cross(*b - *a).dot(foot - *a) >= 0.0) {
        return foot;
    }
    let on_edge = |(a, b): (&DVec3, &DVec3)| {
        let edge = *b - *a;
        let share = (p - *a).dot(edge) / edge.length_squared().max(f64::MIN_POSITIVE);
        *a + edge * share.clamp(0.0, 1.0)
    };
    let nearer = |a: DVec3, b: DVec3| if b.distance(p) < a.distance(p) { b } else { a };
    edges().map(on_edge).reduce(nearer).unwrap_or(p)
}

/// Returns the distance at which a ray meets a face.
fn ray_distance(face: &Face, origin: DVec3, direction: DVec3) -> Option<f64> {
    let normal = face.vector_area();
    let t = normal.dot(face.corners[0] - origin) / normal.dot(direction);
    let at = origin + direction * t;
    (t > 0.0 && nearest_point(face, at).distance(at) <= 1e-9 * t).then_some(t)
}

/// Returns the faces of an icosahedron, fronts outside. Its projected area differs by at most 5 % from its mean
/// over all directions; that of an octahedron differs by 18 %.
pub(super) fn icosahedron_faces(at: DVec3, radius: f64) -> Vec<[DVec3; 3]> {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let scale = radius / DVec3::new(0.0, 1.0, golden).length();
    let corner = |k: usize| {
        let sign = |bit: usize| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let [one, other] = [sign(0), golden * sign(1)];
        let corner = match k / 4 {
            0 => DVec3::new(one, other, 0.0),
            1 => DVec3::new(0.0, one, other),
            _ => DVec3::new(other, 0.0, one),
        };
        at + scale * corner
    };
    let (sides, _) = ICOSAHEDRON_CORNERS.as_chunks::<3>();
    sides.iter().map(|side| side.map(corner)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn icosahedra_face_outwards_with_even_projected_area() {
        let at = DVec3::new(1.0, 2.0, 3.0);
        let sides = icosahedron_faces(at, 0.5);
        let normal = |side: &[DVec3; 3]| (side[1] - side[0]).cross(side[2] - side[0]) * 0.5;
        for side in &sides {
            assert!(normal(side).dot(side[0] - at) > 0.0, "{side:?}");
            assert!((side[0].distance(at) - 0.5).abs() < 1e-12);
        }
        let all: f64 = sides.iter().map(|side| normal(side).length()).sum();
        for way in [DVec3::X, DVec3::ONE, DVec3::new(0.3, -2.0, 1.0)] {
            let way = way.normalize();
            let seen: f64 = sides.iter().map(|s| normal(s).dot(way).max(0.0)).sum();
            assert!((seen / (all / 4.0) - 1.0).abs() < 0.05, "{way}: {seen} of {all}");
        }
    }

    /// Corner of a room: floor y = 0 and walls x = 0 and z = 0, fronts inside, 10 wide.
    fn corner_of_room() -> Scene {
        let p = |x, y, z| 10.0 * DVec3::new(x, y, z);
        let face = |corners| Face::quad("wall", corners, Vec3::ZERO, Vec3::ONE);
        let (o, x, y, z) = (p(0., 0., 0.), p(1., 0., 0.), p(0., 1., 0.), p(0., 0., 1.));
        let faces = vec![face([o, z, z + x, x]), face([o, y, y + z, z]), face([o, x, x + y, y])];
        Scene {
            faces,
            ..Scene::default()
        }
    }

    #[test]
    fn lamps_have_their_power_and_touch_nothing() {
        for (at, is_moved) in [([5., 5., 5.], false), ([5., 0., 5.], true), ([0., 0.001, 0.], true)] {
            let mut scene = corner_of_room();
            add_lamp(&mut scene, "lamp 1", at.into(), 60.0).unwrap();
            let (walls, lamp) = scene.faces.split_at(3);
            let power: f64 = lamp.iter().map(|face| face.area() * f64::from(face.emission.x)).sum();
            assert!((power / 60.0 - 1.0).abs() < 1e-6 && lamp.len() == 20, "{power}");
            assert!(
                lamp.iter()
                    .all(|face| face.name == "lamp 1" && face.reflectance == Vec3::ZERO)
            );
            assert_eq!(scene.notes.len(), usize::from(is_moved), "{:?}", scene.notes);
            let inside = |wall: &Face, p: &DVec3| wall.vector_area().normalize().dot(*p - wall.corners[0]);
            for corner in lamp.iter().flat_map(Face::outline) {
                assert!(walls.iter().all(|wall| inside(wall, corner) > 0.02), "{at:?}: {corner}");
            }
        }
        let refused = |at, power| add_lamp(&mut corner_of_room(), "lamp 1", at, power).unwrap_err();
        assert!(refused(DVec3::ONE, 1e30).contains("cannot be solved"));
        assert!(refused(DVec3::splat(-1e30), 1.0).contains("cannot be solved"));
    }

    #[test]
    fn lamp_in_a_narrow_gap_is_smaller() {
        let mut scene = corner_of_room();
        let lid = scene.faces[0].reversed();
        scene.faces.push(Face {
            corners: lid.corners.map(|p| p + 0.02 * DVec3::Y),
            ..lid
        });
        add_lamp(&mut scene, "lamp 1", DVec3::new(5.0, 0.01, 5.0), 1.0).unwrap();
        let heights = scene.faces[4..].iter().flat_map(Face::outline).map(|p| p.y);
        assert!(heights.into_iter().all(|y| 0.0 < y && y < 0.02));
        // Fronts at no distance leave no room.
        let mut scene = corner_of_room();
        let backs: Vec<Face> = scene.faces.iter().map(Face::reversed).collect();
        scene.faces.extend(backs.into_iter().map(|face| Face {
            corners: face.corners.map(|p| p + DVec3::splat(1e-7)),
            ..face
        }));
        assert!(add_lamp(&mut scene, "lamp 1", DVec3::ZERO, 1.0).is_err());
    }
}
