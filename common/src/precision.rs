//! How much of a face's shape the rounding of its corners may have taken.
//!
//! ```text
//! error = 2·max(|h|·r, |n|·r) / height
//! ```
//! h, n: directions of the face's smallest height and of its normal. Each coordinate of a corner is
//! off by r (one for each axis) at most: by the file's rounding (f32 in a glTF, the digits of an OBJ's
//! text) and by that of the mesh, to f32 about the scene's middle. Either side of the face may be off
//! towards the other, or out of its plane; the smallest height feels it most.

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
    let (height, directions) = smallest_height(face)?;
    let local = face
        .outline()
        .iter()
        .map(|corner| mesh.local(*corner).abs());
    let farthest = local.fold(DVec3::ZERO, DVec3::max);
    let share = |rounding: DVec3| {
        let off = directions.map(|direction| direction.abs().dot(rounding));
        2.0 * off[0].max(off[1]) / height
    };
    let of_file = DVec3::splat(face.rounding);
    Some(Loss {
        face: k,
        error: share(of_file + ROUNDOFF * mesh.unit * farthest),
        of_file: share(of_file),
    })
}

/// A triangle's on its longest edge, a parallelogram's between its longer edges; and its direction,
/// with the face's normal.
fn smallest_height(face: &Face) -> Option<(f64, [DVec3; 2])> {
    let outline = face.outline();
    let ends = outline.iter().zip(outline.iter().cycle().skip(1));
    let edges = ends.map(|(a, b): (&DVec3, &DVec3)| *b - *a);
    let longest = edges.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
    let normal = face.vector_area().try_normalize()?;
    let along = normal.cross(longest).try_normalize()?;
    let area = match face.shape {
        Shape::Quad => face.area(),
        Shape::Triangle => 2.0 * face.area(),
    };
    Some((area / longest.length(), [along, normal]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;
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
        // At an end of a mesh from −1 to 1 both ways: r is the roundoff itself along the height. Alone
        // in its mesh a sliver loses nothing: f32 is as fine as it is thin.
        let wide = rectangle(2.0, DVec3::ZERO, 0.0);
        for width in [1.0, 1e-3, 1e-5, 1e-6] {
            let sliver = rectangle(width, DVec3::ZERO, 0.0);
            let all = found(vec![sliver.clone(), wide.clone()], 0.0);
            let expected = 2.0 * ROUNDOFF / width;
            assert!(
                abs_diff_eq!(all[0].error / expected, 1.0, epsilon = 1e-12),
                "{all:?}"
            );
            assert_eq!(all[0].of_file, 0.0);
            let lost = found(vec![sliver.clone(), wide.clone()], 0.02);
            assert_eq!(lost.len(), usize::from(width < 6e-6), "{width}");
            assert!(found(vec![sliver], 1e-6).is_empty(), "{width}");
        }
    }

    #[test]
    fn a_strip_is_bent_out_of_its_plane() {
        // Its height lies about the middle, its plane at an end.
        let width = 1e-6;
        let at = |z: f64| rectangle(width, DVec3::new(0.0, -0.5 * width, z), 0.0);
        let lost = found(vec![at(1.0), at(-1.0)], 0.02);
        assert_eq!(lost.len(), 2);
        assert!(abs_diff_eq!(
            lost[0].error / (2.0 * ROUNDOFF / width),
            1.0,
            epsilon = 1e-12
        ));
    }

    #[test]
    fn a_place_far_away_loses_what_the_file_rounds_and_nothing_else() {
        let far = DVec3::new(1e6, 0.0, 0.0);
        let exact = found(vec![rectangle(1.0, far, 0.0)], 1e-6);
        assert!(exact.is_empty(), "{exact:?}");
        let rounding = ROUNDOFF * 1e6;
        let lost = found(vec![rectangle(1.0, far, rounding)], 0.02);
        assert_eq!(lost.len(), 1);
        assert!(abs_diff_eq!(
            lost[0].of_file / (2.0 * rounding),
            1.0,
            epsilon = 1e-12
        ));
    }

    #[test]
    fn a_triangle_has_its_own_height_and_a_point_has_none() {
        let [a, b, c] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1e-3, 0.0]].map(DVec3::from);
        let triangle = Face::triangle("", [a, b, c], Vec3::ZERO, Vec3::ZERO);
        let (height, [along, normal]) = smallest_height(&triangle).unwrap();
        // The longest edge is b–c: 2A = 2e−3.
        assert!(abs_diff_eq!(
            height / (2e-3 / b.distance(c)),
            1.0,
            epsilon = 1e-12
        ));
        assert!(along.dot(c - b).abs() < 1e-12 && normal == DVec3::Z);
        let point = Face::quad("", [a; 4], Vec3::ZERO, Vec3::ZERO);
        assert_eq!(smallest_height(&point), None);
    }
}
