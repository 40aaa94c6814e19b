//! Error of a face's shape by the rounding of its corners.
//!
//! ```text
//! error = 2·max(|h|·r, |n|·r) / height
//! ```
//! h, n: directions of the face's smallest height and of its normal. Each coordinate of a corner is
//! off by r (one for each axis) at most: by the file's rounding (f32 in a glTF, the digits of an OBJ's
//! text) and by that of the mesh, to f32 about the scene's centre. Either side of the face may be off
//! towards the other, or out of its plane; the relative error is largest along the smallest height.

use crate::mesh::Mesh;
use crate::scene::{Face, Scene, Shape};
use glam::DVec3;

/// Unit roundoff of f32: the largest relative error of a rounding.
pub const UNIT_ROUNDOFF: f64 = f32::EPSILON as f64 / 2.0;

/// Error of a face's shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeLoss {
    /// The face.
    pub face: u32,
    /// Relative error of its smallest height, at most.
    pub error: f64,
    /// The file's part of the error; the rest is the mesh's.
    pub file_part: f64,
}

/// Finds the faces whose smallest height may be off by more than `min_error` of itself, in the scene's order.
/// Faces without area are skipped.
pub fn find_shape_losses(scene: &Scene, mesh: &Mesh, min_error: f64) -> Vec<ShapeLoss> {
    let losses = scene
        .faces
        .iter()
        .zip(0..)
        .filter_map(|(face, k)| shape_loss(face, k, mesh));
    losses.filter(|loss| loss.error > min_error).collect()
}

fn shape_loss(face: &Face, k: u32, mesh: &Mesh) -> Option<ShapeLoss> {
    let (height, directions) = smallest_height(face)?;
    let local = face.outline().iter().map(|corner| mesh.local_point(*corner).abs());
    let farthest = local.fold(DVec3::ZERO, DVec3::max);
    let share = |rounding: DVec3| {
        let offsets = directions.map(|direction| direction.abs().dot(rounding));
        2.0 * offsets[0].max(offsets[1]) / height
    };
    let of_file = DVec3::splat(face.rounding);
    Some(ShapeLoss {
        face: k,
        error: share(of_file + UNIT_ROUNDOFF * mesh.unit * farthest),
        file_part: share(of_file),
    })
}

/// Returns a face's smallest height, with its direction and the face's normal: a triangle's height on its
/// longest edge, a parallelogram's distance between its longer edges. None for a face without area.
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

    fn losses_of(faces: Vec<Face>, min_error: f64) -> Vec<ShapeLoss> {
        let scene = Scene {
            faces,
            ..Scene::default()
        };
        find_shape_losses(&scene, &Mesh::uniform(&scene, 1, 1).unwrap(), min_error)
    }

    fn assert_ratio_is_one(found: f64, expected: f64) {
        assert!(
            abs_diff_eq!(found / expected, 1.0, epsilon = 1e-12),
            "{found} {expected}"
        );
    }

    #[test]
    fn sliver_in_large_mesh_has_shape_error() {
        // At an end of a mesh from −1 to 1 along both axes r is the roundoff itself along the height. Alone
        // in its mesh a sliver has no error: the mesh's unit is as small as the sliver.
        let wide = rectangle(2.0, DVec3::ZERO, 0.0);
        for width in [1.0, 1e-3, 1e-5, 1e-6] {
            let sliver = rectangle(width, DVec3::ZERO, 0.0);
            let all = losses_of(vec![sliver.clone(), wide.clone()], 0.0);
            assert_ratio_is_one(all[0].error, 2.0 * UNIT_ROUNDOFF / width);
            assert_eq!(all[0].file_part, 0.0);
            let lost = losses_of(vec![sliver.clone(), wide.clone()], 0.02);
            assert_eq!(lost.len(), usize::from(width < 6e-6), "{width}");
            assert!(losses_of(vec![sliver], 1e-6).is_empty(), "{width}");
        }
        // Two strips whose heights are centred, and whose planes lie at the ends of the mesh.
        let at = |z: f64| rectangle(1e-6, DVec3::new(0.0, -0.5e-6, z), 0.0);
        let lost = losses_of(vec![at(1.0), at(-1.0)], 0.02);
        assert_eq!(lost.len(), 2);
        assert_ratio_is_one(lost[0].error, 2.0 * UNIT_ROUNDOFF / 1e-6);
    }

    #[test]
    fn face_far_from_origin_has_only_the_file_rounding_error() {
        let far = DVec3::new(1e6, 0.0, 0.0);
        let exact = losses_of(vec![rectangle(1.0, far, 0.0)], 1e-6);
        assert!(exact.is_empty(), "{exact:?}");
        let rounding = UNIT_ROUNDOFF * 1e6;
        let lost = losses_of(vec![rectangle(1.0, far, rounding)], 0.02);
        assert_eq!(lost.len(), 1);
        assert_ratio_is_one(lost[0].file_part, 2.0 * rounding);
    }

    #[test]
    fn smallest_height_of_triangle_and_of_point() {
        let [a, b, c] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1e-3, 0.0]].map(DVec3::from);
        let triangle = Face::triangle("", [a, b, c], Vec3::ZERO, Vec3::ZERO);
        let (height, [along, normal]) = smallest_height(&triangle).unwrap();
        // The longest edge is b–c: 2A = 2e−3.
        assert_ratio_is_one(height, 2e-3 / b.distance(c));
        assert!(along.dot(c - b).abs() < 1e-12 && normal == DVec3::Z);
        let point = Face::quad("", [a; 4], Vec3::ZERO, Vec3::ZERO);
        assert_eq!(smallest_height(&point), None);
    }
}
