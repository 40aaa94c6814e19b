//! Light from outside a scene as faces: a black box far around it, whose texels emit what the sky shows in their
//! direction, and for each sun a square of its angular size.
//!
//! The box is 4096 half extents of the scene away, so that the direction of its light changes by less than a
//! quarter of a thousandth across the scene. Even light has no such error: around any point the box is closed.

use super::panorama::Panorama;
use super::room::{box_room, capture_point};
use super::wall_radiosity::texel_radiosity;
use crate::error::Result;
use crate::scene::{Face, Scene};
use crate::sky::{Sky, Sun};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// Distance of the box's faces, in half extents of the scene: a power of two.
const BOX_DISTANCE: f64 = 4096.0;
/// Distance of suns: within the box, and the irradiance changes by at most 0.1 % across the scene.
const SUN_DISTANCE: f64 = 2048.0;
/// Solid angle of the sun's disc of 0.53°, sr.
pub const SUN_SOLID_ANGLE: f64 = 6.72e-5;
/// Texels per side of a face of the box, 1.8° in its middle: no source is smaller.
const BOX_TEXELS: u32 = 64;

/// Faces that send the light of a sky.
#[derive(Default)]
pub struct SkyFaces {
    /// Quads whose fronts face the scene.
    pub faces: Vec<Face>,
    /// Texels of each.
    pub resolutions: Vec<[u32; 2]>,
    /// Radiosity of each texel, W/m²: face after face.
    pub radiosity: Vec<Vec3>,
}

/// Returns a sky of the same radiance L in all directions, W/m²/sr.
pub fn even_sky(radiance: f32) -> Sky {
    Sky {
        source: radiance.to_string(),
        texels: BOX_TEXELS,
        radiosity: vec![Vec3::splat(radiance * std::f32::consts::PI); 6 * (BOX_TEXELS * BOX_TEXELS) as usize],
        suns: Vec::new(),
    }
}

/// Returns the sky of a panorama: y is up, and the map's centre looks along +z.
///
/// Errors: those of [`texel_radiosity`].
pub fn panorama_sky(panorama: &Panorama, source: String) -> Result<Sky> {
    let size = DVec3::splat(2.0);
    let resolutions = [[BOX_TEXELS; 2]; 6];
    Ok(Sky {
        source,
        texels: BOX_TEXELS,
        radiosity: texel_radiosity(panorama, &box_room(size)?, &resolutions, capture_point(size, None)?)?,
        suns: Vec::new(),
    })
}

/// Builds the faces of a sky around `centre`; `unit` is half of the scene's extent or more.
///
/// Errors: those of [`box_room`].
pub fn build_sky_faces(sky: &Sky, centre: DVec3, unit: f64) -> Result<SkyFaces> {
    let mut built = SkyFaces::default();
    if sky.texels > 0 {
        let size = DVec3::splat(2.0 * BOX_DISTANCE * unit);
        let Scene { faces, .. } = box_room(size)?;
        let offset = centre - capture_point(size, None)?;
        built.faces.extend(faces.into_iter().map(|face| Face {
            corners: face.corners.map(|p| p + offset),
            ..face
        }));
        built.resolutions = vec![[sky.texels; 2]; 6];
        built.radiosity.clone_from(&sky.radiosity);
    }
    for sun in &sky.suns {
        built.faces.push(sun_face(sun, centre, unit));
        built.resolutions.push([1, 1]);
        // B Ω/π is the irradiance.
        built.radiosity.push(sun.irradiance * (PI / SUN_SOLID_ANGLE) as f32);
    }
    Ok(built)
}

fn sun_face(sun: &Sun, centre: DVec3, unit: f64) -> Face {
    let half = 0.5 * SUN_SOLID_ANGLE.sqrt() * SUN_DISTANCE * unit;
    let middle = centre + sun.direction * SUN_DISTANCE * unit;
    let u = half * sun.direction.any_orthonormal_vector();
    let v = u.cross(sun.direction);
    // Counter-clockwise as seen from the scene: u × v = −direction.
    let corners = [middle - u - v, middle + u - v, middle + u + v, middle - u + v];
    Face::quad("sun", corners, Vec3::ZERO, Vec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn sky_faces_look_at_the_scene_and_suns_have_their_size() {
        let direction = DVec3::new(1.0, 2.0, -0.5).normalize();
        let sun = Sun {
            direction,
            irradiance: Vec3::ONE,
        };
        let sky = Sky {
            suns: vec![sun],
            ..even_sky(1.0)
        };
        let centre = DVec3::new(3.0, -1.0, 2.0);
        let built = build_sky_faces(&sky, centre, 0.5).unwrap();
        assert_eq!([built.faces.len(), built.resolutions.len()], [7, 7]);
        for face in &built.faces {
            assert!(face.vector_area().dot(centre - face.corners[0]) > 0.0, "{}", face.name);
        }
        let sun = &built.faces[6];
        let distance = sun.point_at(0.5, 0.5) - centre;
        assert!((distance.normalize() - direction).length() < 1e-12);
        let solid_angle = sun.area() / distance.length_squared();
        assert!((solid_angle / SUN_SOLID_ANGLE - 1.0).abs() < 1e-9, "{solid_angle}");
        assert_eq!(built.radiosity.len(), 6 * 64 * 64 + 1);
    }

    #[test]
    fn panorama_sky_keeps_the_light_of_each_direction() {
        // A map that is bright above the horizon only.
        let pixels = (0..64 * 32).map(|k| Vec3::splat(if k < 64 * 16 { 2.0 } else { 0.5 }));
        let map = Panorama::from_pixels([64, 32], pixels.collect(), None).unwrap();
        let sky = panorama_sky(&map, String::new()).unwrap();
        let texels = (sky.texels * sky.texels) as usize;
        let mean = |k: usize| sky.radiosity[k * texels..(k + 1) * texels].iter().sum::<Vec3>().x / texels as f32;
        let expected = DVec2::new(0.5, 2.0).as_vec2() * std::f32::consts::PI;
        assert!((mean(0) - expected.x).abs() < 1e-4 && (mean(1) - expected.y).abs() < 1e-4);
    }
}
