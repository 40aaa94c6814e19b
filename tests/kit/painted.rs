//! Faces painted with pictures.

use common::paint::{Coat, Paint, PaintCorner, TexturePicture, WrapMode, WrappedTexture};
use common::scene::Face;
use glam::{DVec2, DVec3, Vec3};
use std::sync::Arc;

/// Makes a coat of a picture that covers a face from corner to corner.
pub fn picture_coat(size: [usize; 2], pixels: &[Vec3]) -> Coat {
    let pixels = pixels.iter().map(|pixel| pixel.to_array()).collect();
    Coat {
        factor: DVec3::ONE,
        texture: Some(WrappedTexture {
            picture: Arc::new(TexturePicture::new(size, pixels)),
            wrap: [WrapMode::Clamp; 2],
        }),
        coloured: false,
    }
}

/// Paints a face with pictures of ρ and of radiance.
pub fn paint_face(mut face: Face, coats: [Option<Coat>; 2]) -> Face {
    let places = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]].map(DVec2::from);
    let corners = places.map(|place| PaintCorner {
        texture_coordinates: [place; 2],
        colour: DVec3::ONE,
    });
    face.paint = Some(Arc::new(Paint {
        corners,
        odd: false,
        coats,
    }));
    let [reflectance, emission] = face.mean_surface(face.outline());
    (face.reflectance, face.emission) = (reflectance, emission);
    face
}
