//! How much of a face's shape the rounding of its corners may have taken.
//!
//! ```text
//! error = 2√3 · r / height
//! ```
//! Each coordinate of a corner is off by r at most: by the file's rounding (f32 in a glTF, the digits
//! of an OBJ's text) and by that of the mesh, to f32 about the scene's middle. Either side of the face
//! may be off by √3 r, towards the other; the smallest height feels it most.

use crate::mesh::Mesh;
use crate::scene::{Face, Scene, Shape};
use glam::DVec3;

/// Unit roundoff of f32: x is off by at most so much of itself.
pub const ROUNDOFF: f64 = f32::EPSILON as f64 / 2.0;

/// A face that may have lost its shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loss {
    /// The face.
    pub face: u32,
    /// What its smallest height may be off by, of itself.
    pub error: f64,
    /// The file's part of that; the rest is the mesh's.
    pub of_file: f64,
}

/// The faces that may be off by more than `least` of their smallest height, in the scene's order.
/// Faces without area have nothing to lose.
pub fn losses(scene: &Scene, mesh: &Mesh, least: f64) -> Vec<Loss> {
    let faces = scene.faces.iter().zip(0..);
    faces
        .filter_map(|(face, k)| loss(face, k, mesh))
        .filter(|loss| loss.error > least)
        .collect()
}

fn loss(face: &Face, k: u32, mesh: &Mesh) -> Option<Loss> {
    let height = smallest_height(face)?;
    let farthest = face
        .outline()
        .iter()
        .map(|corner| mesh.local(*corner).abs().max_element())
        .fold(0.0, f64::max);
    let share = |rounding: f64| 2.0 * 3f64.sqrt() * rounding / height;
    let of_file = share(face.rounding);
    Some(Loss {
        face: k,
        error: of_file + share(ROUNDOFF * farthest * mesh.unit),
        of_file,
    })
}

/// A triangle's on its longest edge, a parallelogram's between its longer edges.
fn smallest_height(face: &Face) -> Option<f64> {
    let outline = face.outline();
    let ends = outline.iter().zip(outline.iter().cycle().skip(1));
    let longest = ends.map(|(a, b): (&DVec3, &DVec3)| a.distance(*b));
    let longest = longest.fold(0.0, f64::max);
    let area = match face.shape {
        Shape::Quad => face.area(),
        Shape::Triangle => 2.0 * face.area(),
    };
    (area > 0.0).then(|| area / longest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn rectangle(width: f64, at: DVec3, rounding: f64) -> Face {
        let p = |x: f64, y: f64| at + DVec3::new(x, y, 0.0);
        let corners = [p(0.0, 0.0), p(2.0, 0.0), p(2.0, width), p(0.0, width)];
        Face {
            rounding,
            ..Face::quad("", corners, Vec3::ZERO, Vec3::ZERO)
        }
    }

    fn found(faces: Vec<Face>, least: f64) -> Vec<Loss> {
        let scene = Scene {
            faces,
            ..Scene::default()
        };
        losses(&scene, &Mesh::uniform(&scene, 1, 1).unwrap(), least)
    }

    #[test]
    fn slivers_lose_what_the_mesh_rounds() {
        // In a mesh from −1 to 1 the long way: r is the roundoff itself.
        for width in [1.0, 1e-3, 1e-5, 1e-6] {
            let expected = 2.0 * 3f64.sqrt() * ROUNDOFF / width;
            let all = found(vec![rectangle(width, DVec3::ZERO, 0.0)], 0.0);
            assert_eq!(all.len(), 1);
            assert!((all[0].error / expected - 1.0).abs() < 1e-12, "{all:?}");
            assert_eq!(all[0].of_file, 0.0);
            let lost = found(vec![rectangle(width, DVec3::ZERO, 0.0)], 0.02);
            assert_eq!(lost.len(), usize::from(width < 1.1e-5), "{width}");
        }
    }

    #[test]
    fn a_place_far_away_loses_what_the_file_rounds_and_nothing_else() {
        let far = DVec3::new(1e6, 0.0, 0.0);
        let exact = found(vec![rectangle(1.0, far, 0.0)], 1e-6);
        assert!(exact.is_empty(), "{exact:?}");
        let rounding = ROUNDOFF * 1e6;
        let lost = found(vec![rectangle(1.0, far, rounding)], 0.02);
        assert_eq!(lost.len(), 1);
        assert!((lost[0].of_file / (2.0 * 3f64.sqrt() * rounding) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_triangle_has_its_own_height_and_a_point_has_none() {
        let [a, b, c] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1e-3, 0.0]].map(DVec3::from);
        let triangle = Face::triangle("", [a, b, c], Vec3::ZERO, Vec3::ZERO);
        let height = smallest_height(&triangle).unwrap();
        // The longest edge is b–c: 2A = 2e−3.
        assert!((height / (2e-3 / b.distance(c)) - 1.0).abs() < 1e-12);
        let point = Face::quad("", [a; 4], Vec3::ZERO, Vec3::ZERO);
        assert_eq!(smallest_height(&point), None);
    }
}
