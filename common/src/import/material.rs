//! What a file's material gives to a face: its colours, or the means of their textures there.

use super::builder::Builder;
use super::picture::{Picture, Wrap};
use super::surface::Surface;
use glam::{DAffine2, DVec2, DVec3};
use std::rc::Rc;

/// Less than this of a texture's light is what rounding leaves of a pixel beside the face.
const NOTHING: f64 = 1e-6;

/// A texture as a material uses it.
#[derive(Clone)]
pub struct Texture {
    /// Its picture.
    pub picture: Rc<Picture>,
    /// How it goes on, right and downwards.
    pub wrap: [Wrap; 2],
    /// From the file's coordinates to the picture's (see [`Picture::mean`]).
    pub place: DAffine2,
}

/// A factor times a texture, if there is one.
#[derive(Clone)]
pub struct Colour {
    /// Linear Rec. 709.
    pub factor: DVec3,
    /// None: 1.
    pub texture: Option<Texture>,
}

/// A material.
#[derive(Clone)]
pub struct Material {
    /// In the file.
    pub name: String,
    /// Reflectance, and radiance L.
    pub colours: [Colour; 2],
    /// What the file calls them.
    pub names: [&'static str; 2],
}

/// A face's corners, and the coordinates there of each colour's texture; none where the file has none.
pub struct Corners<'c> {
    /// In space.
    pub corners: &'c [DVec3],
    /// On the textures.
    pub places: [Option<&'c [DVec2]>; 2],
}

impl Material {
    /// The surface of a face.
    ///
    /// Errors: what is wrong with the material.
    pub fn surface(&self, builder: &mut Builder, face: &Corners) -> Result<Surface, String> {
        let [reflectance, radiance] = &self.colours;
        let colours = [
            reflectance.over(face.corners, face.places[0]),
            radiance.over(face.corners, face.places[1]),
        ];
        if self.colours.iter().any(|colour| colour.texture.is_some()) {
            builder.textured(&self.name);
        }
        builder.surface(&self.name, colours, self.names)
    }
}

impl Colour {
    /// Without a texture.
    pub fn plain(factor: DVec3) -> Self {
        Self {
            factor,
            texture: None,
        }
    }

    fn over(&self, corners: &[DVec3], places: Option<&[DVec2]>) -> DVec3 {
        let Some(texture) = &self.texture else {
            return self.factor;
        };
        let mean = match places {
            None => texture.picture.whole(),
            Some(places) => {
                let places: Vec<DVec2> = places
                    .iter()
                    .map(|p| texture.place.transform_point2(*p))
                    .collect();
                texture.picture.mean(corners, &places, texture.wrap)
            }
        };
        if mean.max_element() < NOTHING {
            DVec3::ZERO
        } else {
            self.factor * mean
        }
    }
}
