//! The light that meets no front.

use common::escape::{escape_directions, meets_front, weyl_sequence};
use common::mesh::Mesh;
use common::rays::Rays;
use common::sampling::outline_point;
use common::scene::Scene;
use common::texel::texel_outline;
use glam::Vec3;
use rayon::prelude::*;

/// Steps of the points on a texel, the golden ratio and √2: other than those of the directions.
const POINT_STEPS: [f64; 2] = [0.618_033_988_749_895, 0.414_213_562_373_095];

/// Returns the share of each texel's light that meets no front, the mean over its area.
pub fn escaped_shares(scene: &Scene, mesh: &Mesh) -> Vec<f64> {
    let (rays, directions) = (Rays::new(mesh), escape_directions());
    let share = |k: usize| {
        let texel = &mesh.texels[k];
        let face = &mesh.faces[texel.face as usize];
        let outline = texel_outline(&scene.faces[texel.face as usize], face.resolution, texel.index);
        let corners = outline.padded_corners().map(|p| mesh.local_point(p).as_vec3());
        let escapes = |(n, direction): &(usize, &Vec3)| {
            let uv = POINT_STEPS.map(|step| weyl_sequence(*n, step) as f32);
            let origin = outline_point(&corners, uv).truncate();
            !meets_front(&rays, face.sheet, origin, face.direction_in_frame(**direction))
        };
        directions.iter().enumerate().filter(escapes).count() as f64 / directions.len() as f64
    };
    (0..mesh.texels.len()).into_par_iter().map(share).collect()
}
