//! Polygons and materials of scene files, and the paint that a material gives to a face. The readers of OBJ and glTF
//! files make them, and the builder makes faces of them.

use crate::paint::{Coat, MAX_WHITE_REFLECTANCE, Paint, PaintCorner, WrappedTexture};
use glam::{DAffine2, DVec2, DVec3, Vec2, Vec3};
use std::path::{Path, PathBuf};

/// Corner of a polygon of a scene file, with the attributes that it has.
#[derive(Clone, Copy, Default)]
pub struct InputVertex {
    /// Position in the scene.
    pub position: DVec3,
    /// Shading normal, untransformed: normals are only compared for equality.
    pub normal: Option<Vec3>,
    /// Texture coordinates for the reflectance and the radiance texture.
    pub texture_coordinates: [Option<DVec2>; 2],
    /// Colour, which multiplies the reflectance.
    pub colour: Option<DVec3>,
    /// Lightmap coordinates.
    pub lightmap_coordinates: Option<Vec2>,
    /// Number of the vertex within its primitive.
    pub index: u32,
    /// Largest rounding error of a coordinate.
    pub rounding: f64,
}

/// A constant factor times an optional texture.
#[derive(Clone)]
pub struct TexturedColour {
    /// Factor, linear Rec. 709.
    pub factor: DVec3,
    /// Texture, and the transform from the file's coordinates to those of [`PaintCorner::texture_coordinates`]; none: 1 everywhere.
    pub texture: Option<(WrappedTexture, DAffine2)>,
}

/// Material of a scene file.
#[derive(Clone)]
pub struct ImportedMaterial {
    /// File that defines the material.
    pub file: PathBuf,
    /// Name in that file.
    pub name: String,
    /// Reflectance and radiance L.
    pub colours: [TexturedColour; 2],
    /// The file's names of both colours, for messages.
    pub names: [&'static str; 2],
}

/// Appearance that a material gives to a face.
pub struct FaceAppearance {
    /// Constant factors of reflectance and radiance.
    pub factors: [DVec3; 2],
    /// Variation over the face, if there is any.
    pub paint: Option<Paint>,
    /// True if a white value of the factor, texture or vertex colour has been lowered.
    pub was_white: bool,
    /// True if the material has a texture for which the face has no coordinates.
    pub lacks_coordinates: bool,
}

/// Returns a channel of a vertex colour clamped to 0 … 1; NaN counts as 1.
pub fn clamp_vertex_colour(written: f32) -> f32 {
    if written.is_nan() { 1.0 } else { written.clamp(0.0, 1.0) }
}

impl TexturedColour {
    /// Returns the coat of a face with these coordinates on the picture. Without coordinates, the texture's mean
    /// takes the texture's place; a texture with one colour under the face becomes a factor.
    fn build_coat(&self, corners: Option<&[DVec2]>) -> Coat {
        let mut coat = Coat {
            factor: self.factor,
            texture: None,
            coloured: false,
        };
        let Some((texture, _)) = &self.texture else {
            return coat;
        };
        match corners {
            None => coat.factor *= texture.picture.mean_colour(),
            Some(corners) if texture.picture.is_uniform(corners) => {
                coat.factor *= texture.picture.colour_at(corners[0], texture.wrap);
            }
            Some(_) => coat.texture = Some(texture.clone()),
        }
        coat
    }
}

impl ImportedMaterial {
    /// Creates a material without textures, of this reflectance and radiance.
    pub fn from_factors(file: &Path, name: &str, factors: [DVec3; 2], names: [&'static str; 2]) -> Self {
        let texture = None;
        Self {
            file: file.to_owned(),
            name: name.to_owned(),
            colours: factors.map(|factor| TexturedColour {
                factor,
                texture: texture.clone(),
            }),
            names,
        }
    }

    /// Returns the appearance of a face with these corners; `odd` if the diagonal of a joined quad runs from corner 1 to
    /// corner 3. Where the options replace the reflectance (`replaced`), vertex colours are ignored.
    pub fn appearance_on(&self, vertices: &[InputVertex], odd: bool, replaced: bool) -> FaceAppearance {
        let mut corners = [PaintCorner {
            texture_coordinates: [DVec2::ZERO; 2],
            colour: DVec3::ONE,
        }; 4];
        let mut lacks_coordinates = false;
        let mut coats = [0, 1].map(|k| {
            let coordinates = self.colours[k].texture.as_ref().and_then(|(_, transform)| {
                let in_file = vertices.iter().map(|v| v.texture_coordinates[k]);
                let coordinates = in_file.map(|point| Some(transform.transform_point2(point?)));
                let coordinates: Option<Vec<DVec2>> = coordinates.collect();
                lacks_coordinates |= coordinates.is_none();
                coordinates
            });
            for (corner, point) in corners.iter_mut().zip(coordinates.iter().flatten()) {
                corner.texture_coordinates[k] = *point;
            }
            self.colours[k].build_coat(coordinates.as_deref())
        });
        let texture = self.colours[0].texture.as_ref();
        let mut was_white =
            texture.is_some_and(|(texture, _)| texture.picture.was_white()) && coats[0].factor != DVec3::ZERO;
        let colours: Option<Vec<DVec3>> = vertices.iter().map(|v| v.colour).collect();
        if let Some(colours) = colours.filter(|_| !replaced) {
            if colours.iter().all(|c| *c == colours[0]) {
                coats[0].factor *= colours[0];
            } else {
                coats[0].coloured = true;
                let whitest = DVec3::splat(MAX_WHITE_REFLECTANCE.into());
                let all = coats[0].factor.cmpeq(DVec3::ONE);
                for (corner, colour) in corners.iter_mut().zip(colours) {
                    let full = all & colour.cmpeq(DVec3::ONE);
                    corner.colour = match coats[0].texture {
                        None => DVec3::select(full, whitest, colour),
                        Some(_) => colour,
                    };
                    was_white |= corner.colour != colour;
                }
            }
        }
        let factors = coats.each_ref().map(|coat| coat.factor);
        let varies = |coat: &Coat| (coat.texture.is_some() || coat.coloured) && coat.factor != DVec3::ZERO;
        let coats = coats.map(|coat| varies(&coat).then_some(coat));
        let paint = Paint { corners, odd, coats };
        FaceAppearance {
            factors,
            paint: paint.coats.iter().any(Option::is_some).then_some(paint),
            was_white,
            lacks_coordinates,
        }
    }
}
