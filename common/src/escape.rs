//! Directions by which the escaped share of a shooter's flux is measured.
//!
//! A cosine-weighted, stratified set in the shooter's frame (x tangent, y bitangent, z normal):
//! the share of the set that meets no front is the share of a diffuse shooter's flux that
//! escapes. Both solvers use the same set, so their shares are equal.

use crate::constants::{CONTACT_DISTANCE, MISS_DISTANCE, OUTLINE_MARGIN};
use crate::intersect::intersect_face;
use crate::mesh::{Cover, Mesh, MeshFace, PatchPoint};
use crate::rays::Rays;
use glam::Vec3;
use rayon::prelude::*;

/// Directions per shooter, a square number: standard error of a share ≲ 0.3 %.
pub const ESCAPE_DIRECTION_COUNT: usize = 1024;

/// Returns one direction in each of 32×32 equal strata of the projected hemisphere.
pub fn escape_directions() -> Vec<Vec3> {
    let side = ESCAPE_DIRECTION_COUNT.isqrt();
    let direction = |k: usize| {
        // R2 sequence inside the strata: aligned rays would run along edges of aligned rooms.
        let jitter = |alpha: f64| weyl_sequence(k + 1, alpha);
        let x = ((k % side) as f64 + jitter(0.754_877_666_246_693)) / side as f64;
        let y = ((k / side) as f64 + jitter(0.569_840_290_998_053)) / side as f64;
        concentric_direction(2.0 * x - 1.0, 2.0 * y - 1.0)
    };
    (0..ESCAPE_DIRECTION_COUNT).map(direction).collect()
}

/// Returns element `k` of the Weyl sequence of `alpha`, in [0, 1).
pub fn weyl_sequence(k: usize, alpha: f64) -> f64 {
    (0.5 + alpha * k as f64).fract()
}

/// Maps the square to the disc with equal areas (concentric map, Shirley & Chiu 1997), then to the hemisphere.
pub fn concentric_direction(x: f64, y: f64) -> Vec3 {
    use std::f64::consts::FRAC_PI_4;
    let (r, phi) = if x.abs() > y.abs() {
        (x, FRAC_PI_4 * y / x)
    } else if y != 0.0 {
        (y, 2.0 * FRAC_PI_4 - FRAC_PI_4 * x / y)
    } else {
        (0.0, 0.0)
    };
    let (s, c) = phi.sin_cos();
    Vec3::new((r * c) as f32, (r * s) as f32, (1.0 - r * r).max(0.0).sqrt() as f32)
}

/// Distances of the nearest front and the nearest back along a ray.
#[derive(Clone, Copy)]
pub struct NearestFaces {
    /// Nearest front.
    pub front: f32,
    /// Nearest back.
    pub back: f32,
}

/// Returns the escaped share of a patch; `directions` are [`escape_directions`]. The BVH only
/// leaves out faces that the shader's loop over all of them would not count either.
pub fn escaped_share(mesh: &Mesh, rays: &Rays, patch: u32, directions: &[Vec3]) -> f32 {
    let face = &mesh.faces[mesh.patches[patch as usize].face as usize];
    let first = (patch * mesh.samples) as usize;
    let points = &mesh.patch_points[first..first + mesh.samples as usize];
    let escapes =
        |(k, d): &(usize, &Vec3)| !meets_front(rays, face.sheet, ray_origin(points, *k), face.direction_in_frame(**d));
    directions.par_iter().enumerate().filter(escapes).count() as f32 / ESCAPE_DIRECTION_COUNT as f32
}

/// Returns the origin of direction `k`: the open points take turns.
pub fn ray_origin(points: &[PatchPoint], k: usize) -> Vec3 {
    let n = points.len();
    let mut at = k % n;
    for _ in 0..n {
        if points[at].cover == Cover::Open {
            break;
        }
        at = (at + 1) % n;
    }
    points[at].position
}

/// Returns whether the nearest face along the ray shows its front. A front that touches the shooter counts: the
/// light does not escape. The shooter's own sheet does not count.
pub fn meets_front(rays: &Rays, sheet: u32, origin: Vec3, direction: Vec3) -> bool {
    let mut nearest = NearestFaces {
        front: MISS_DISTANCE,
        back: MISS_DISTANCE,
    };
    rays.visit_faces_along(origin, direction, |_, face| {
        nearest = nearest_crossing(nearest, sheet, face, origin, direction);
        nearest.front.min(nearest.back)
    });
    // At a shared edge front and back are equally near: the front takes the light.
    nearest.front < MISS_DISTANCE && nearest.front <= nearest.back + CONTACT_DISTANCE
}

/// Returns the nearest of the faces so far and of `face`.
pub fn nearest_crossing(
    nearest: NearestFaces,
    sheet: u32,
    face: &MeshFace,
    origin: Vec3,
    direction: Vec3,
) -> NearestFaces {
    let mut next = nearest;
    if face.sheet == sheet {
        return next;
    }
    let hit = intersect_face(face, origin, direction);
    if hit.facing < 0.0 {
        if hit.t >= -CONTACT_DISTANCE && hit.inside >= -OUTLINE_MARGIN {
            next.front = next.front.min(hit.t);
        }
    } else if hit.t > CONTACT_DISTANCE && hit.inside >= OUTLINE_MARGIN {
        next.back = next.back.min(hit.t);
    }
    next
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;

    #[test]
    fn the_set_is_cosine_weighted() {
        let set = escape_directions();
        let n = set.len() as f32;
        // E[z] = 2/3, E[x] = E[y] = 0, E[x²] = 1/4; stratified error ~ n^(−3/4).
        let bound = 3.0 * n.powf(-0.75);
        let mean: Vec3 = set.iter().sum::<Vec3>() / n;
        assert!(mean.abs_diff_eq(Vec3::new(0.0, 0.0, 2.0 / 3.0), bound), "{mean}");
        let square = set.iter().map(|d| d.x * d.x).sum::<f32>() / n;
        assert!(abs_diff_eq!(square, 0.25, epsilon = bound));
        assert!(
            set.iter()
                .all(|d| abs_diff_eq!(d.length(), 1.0, epsilon = 1e-6) && d.z > 0.0)
        );
    }
}
