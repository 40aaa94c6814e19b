//! Polygons and materials of scene files, and the paint that a material gives to a face.

use crate::paint::{self, Coat, MAX_WHITE_REFLECTANCE, Paint, PaintCorner, TexturePicture, WrapMode};
use glam::{DAffine2, DVec2, DVec3, Vec2, Vec3};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A polygon of a scene file with its attributes per corner.
#[derive(Default)]
pub struct InputPolygon<'p> {
    /// Corners, counter-clockwise as seen from the front.
    pub corners: &'p [DVec3],
    /// Shading normals at the corners; empty if the file has none.
    pub normals: &'p [Vec3],
    /// Largest rounding error of a coordinate.
    pub rounding: f64,
    /// Texture coordinates of the corners, for the reflectance and the radiance texture.
    pub texture_coordinates: [Option<&'p [DVec2]>; 2],
    /// Vertex colours, which multiply the reflectance.
    pub colours: Option<&'p [DVec3]>,
    /// True for a quad joined from two triangles over the diagonal from corner 1 to corner 3.
    pub odd_diagonal: bool,
    /// Lightmap coordinates of a triangle's corners.
    pub chart: Option<[Vec2; 3]>,
}

impl InputPolygon<'_> {
    /// Returns the unit normals at the corners of a piece of this polygon, or none if any of them is missing
    /// or zero.
    pub fn normals_of(&self, piece: &[DVec3; 4]) -> Option<[Vec3; 4]> {
        let mut normals = [Vec3::ZERO; 4];
        for (own, corner) in normals.iter_mut().zip(piece) {
            let k = self.corners.iter().position(|c| c == corner)?;
            *own = self.normals.get(k)?.try_normalize()?;
        }
        Some(normals)
    }
}

/// A picture with its wrap mode and its coordinate transform.
#[derive(Clone)]
pub struct MaterialTexture {
    /// Picture.
    pub picture: Arc<TexturePicture>,
    /// Wrap modes, to the right and downwards.
    pub wrap: [WrapMode; 2],
    /// Transform from the file's texture coordinates to the picture's (see [`PaintCorner::places`]).
    pub transform: DAffine2,
}

/// A constant factor times an optional texture.
#[derive(Clone)]
pub struct TexturedColour {
    /// Factor, linear Rec. 709.
    pub factor: DVec3,
    /// Texture; none: 1 everywhere.
    pub texture: Option<MaterialTexture>,
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
    /// True if the reflectance was 1 in some place and has been lowered.
    pub was_white: bool,
    /// True if the material has a texture for which the face has no coordinates.
    pub lacks_coordinates: bool,
}

/// Returns a channel of a vertex colour clamped to 0 … 1; NaN counts as 1.
pub fn clamp_vertex_colour(written: f32) -> f32 {
    if written.is_nan() { 1.0 } else { written.clamp(0.0, 1.0) }
}

impl TexturedColour {
    /// Creates a colour without a texture.
    pub fn from_factor(factor: DVec3) -> Self {
        Self { factor, texture: None }
    }

    /// Builds the coat of a face with these texture coordinates. Without coordinates, the texture's mean
    /// takes the texture's place; an even part of a texture becomes a factor.
    fn build_coat(&self, places: Option<&[DVec2]>) -> Coat {
        let even = |factor: DVec3| Coat {
            factor,
            texture: None,
            coloured: false,
        };
        let (Some(texture), Some(places)) = (&self.texture, places) else {
            let whole = self.texture.as_ref().map(|t| t.picture.mean_colour());
            return even(self.factor * whole.unwrap_or(DVec3::ONE));
        };
        if texture.picture.is_uniform(places) {
            return even(self.factor * texture.picture.colour_at(places[0], texture.wrap));
        }
        let texture = paint::WrappedTexture {
            picture: texture.picture.clone(),
            wrap: texture.wrap,
        };
        Coat {
            texture: Some(texture),
            ..even(self.factor)
        }
    }
}

impl ImportedMaterial {
    /// Creates a material without textures, of this reflectance and radiance.
    pub fn from_factors(file: &Path, name: &str, factors: [DVec3; 2], names: [&'static str; 2]) -> Self {
        Self {
            file: file.to_owned(),
            name: name.to_owned(),
            colours: factors.map(TexturedColour::from_factor),
            names,
        }
    }

    /// Returns the appearance of a face whose corners are the corners `of` a polygon. Where the options
    /// replace the reflectance (`replaced`), vertex colours are ignored.
    pub fn appearance_on(&self, polygon: &InputPolygon, of: &[usize], replaced: bool) -> FaceAppearance {
        let mut corners = [PaintCorner::PLAIN_WHITE; 4];
        let mut known = [false; 2];
        for (k, colour) in self.colours.iter().enumerate() {
            let (Some(texture), Some(places)) = (&colour.texture, polygon.texture_coordinates[k]) else {
                continue;
            };
            known[k] = true;
            for (corner, n) in corners.iter_mut().zip(of) {
                corner.places[k] = texture.transform.transform_point2(places[*n]);
            }
        }
        let mut coats = [0, 1].map(|k| {
            let places: Vec<DVec2> = corners[..of.len()].iter().map(|c| c.places[k]).collect();
            self.colours[k].build_coat(known[k].then_some(&places))
        });
        let mut white = self.is_white(&coats[0]);
        if let Some(colours) = polygon.colours.filter(|_| !replaced) {
            let colours: Vec<DVec3> = of.iter().map(|n| colours[*n]).collect();
            if colours.iter().all(|c| *c == colours[0]) {
                coats[0].factor *= colours[0];
            } else {
                coats[0].coloured = true;
                let all = coats[0].factor.cmpeq(DVec3::ONE);
                for (corner, colour) in corners.iter_mut().zip(colours) {
                    let full = all & colour.cmpeq(DVec3::ONE);
                    corner.colour = match coats[0].texture {
                        None => DVec3::select(full, DVec3::splat(MAX_WHITE_REFLECTANCE.into()), colour),
                        Some(_) => colour,
                    };
                    white |= corner.colour != colour;
                }
            }
        }
        let plain = coats.each_ref().map(|coat| coat.factor);
        let vary = |coat: &Coat| coat.texture.is_some() || coat.coloured;
        let coats = coats.map(|coat| (vary(&coat) && coat.factor != DVec3::ZERO).then_some(coat));
        let lost = |k: usize| self.colours[k].texture.is_some() && !known[k];
        FaceAppearance {
            factors: plain,
            paint: coats.iter().any(Option::is_some).then_some(Paint {
                corners,
                odd: polygon.odd_diagonal,
                coats,
            }),
            was_white: white,
            lacks_coordinates: lost(0) || lost(1),
        }
    }

    /// True if a reflectance of 1 was lowered in the texture of the reflectance.
    fn is_white(&self, coat: &Coat) -> bool {
        let texture = self.colours[0].texture.as_ref();
        texture.is_some_and(|t| t.picture.was_white()) && coat.factor != DVec3::ZERO
    }
}
