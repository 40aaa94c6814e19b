//! What a file's material gives to a face: its colours, and what of them varies over it.

use super::input::Polygon;
use crate::paint::{self, Coat, Corner, Paint, Picture, WHITEST, Wrap};
use glam::{DAffine2, DVec2, DVec3};
use std::path::PathBuf;
use std::sync::Arc;

/// A texture as a material uses it.
#[derive(Clone)]
pub struct Texture {
    /// Its picture.
    pub picture: Arc<Picture>,
    /// How it goes on, right and downwards.
    pub wrap: [Wrap; 2],
    /// From the file's coordinates to the picture's (see [`Corner::places`]).
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
    /// The file that defines it.
    pub file: PathBuf,
    /// In the file.
    pub name: String,
    /// Reflectance, and radiance L.
    pub colours: [Colour; 2],
    /// What the file calls them.
    pub names: [&'static str; 2],
}

/// What it makes of a face.
pub struct Look {
    /// Reflectance and radiance where they do not vary.
    pub plain: [DVec3; 2],
    /// What varies.
    pub paint: Option<Paint>,
    /// Whether some of it would reflect all light.
    pub white: bool,
    /// Whether a texture has no coordinates there.
    pub lost: bool,
}

/// What a file has for a channel of a vertex' colour: beyond 0 to 1 it is taken as that, and what is no number
/// leaves all light.
pub fn of_vertex(written: f32) -> f32 {
    if written.is_nan() {
        1.0
    } else {
        written.clamp(0.0, 1.0)
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

    /// Of what lies at `places` of the file; none where it says nothing.
    fn coat(&self, places: Option<&[DVec2]>) -> Coat {
        let even = |factor: DVec3| Coat {
            factor,
            texture: None,
            coloured: false,
        };
        let (Some(texture), Some(places)) = (&self.texture, places) else {
            let whole = self.texture.as_ref().map(|t| t.picture.whole());
            return even(self.factor * whole.unwrap_or(DVec3::ONE));
        };
        if texture.picture.is_even(places) {
            return even(self.factor * texture.picture.at(places[0], texture.wrap));
        }
        let texture = paint::Texture {
            picture: texture.picture.clone(),
            wrap: texture.wrap,
        };
        Coat {
            texture: Some(texture),
            ..even(self.factor)
        }
    }
}

impl Material {
    /// What it makes of the face whose corners are those `of` a polygon; its reflectance does not vary where
    /// it is `replaced`.
    pub fn on(&self, polygon: &Polygon, of: &[usize], replaced: bool) -> Look {
        let mut corners = [Corner::PLAIN; 4];
        let mut known = [false; 2];
        for (k, colour) in self.colours.iter().enumerate() {
            let (Some(texture), Some(places)) = (&colour.texture, polygon.places[k]) else {
                continue;
            };
            known[k] = true;
            for (corner, n) in corners.iter_mut().zip(of) {
                corner.places[k] = texture.place.transform_point2(places[*n]);
            }
        }
        let mut coats = [0, 1].map(|k| {
            let places: Vec<DVec2> = corners[..of.len()].iter().map(|c| c.places[k]).collect();
            self.colours[k].coat(known[k].then_some(&places))
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
                    let dimmed = DVec3::select(full, DVec3::splat(WHITEST.into()), colour);
                    let dimmed = if coats[0].texture.is_none() {
                        dimmed
                    } else {
                        colour
                    };
                    white |= dimmed != colour;
                    corner.colour = dimmed;
                }
            }
        }
        let plain = coats.each_ref().map(|coat| coat.factor);
        let vary = |coat: &Coat| coat.texture.is_some() || coat.coloured;
        let coats = coats.map(|coat| (vary(&coat) && coat.factor != DVec3::ZERO).then_some(coat));
        let lost = |k: usize| self.colours[k].texture.is_some() && !known[k];
        Look {
            plain,
            paint: coats.iter().any(Option::is_some).then_some(Paint {
                corners,
                odd: polygon.odd,
                coats,
            }),
            white,
            lost: lost(0) || lost(1),
        }
    }

    /// Whether some of its texture would reflect all light.
    fn is_white(&self, coat: &Coat) -> bool {
        let texture = self.colours[0].texture.as_ref();
        texture.is_some_and(|t| t.picture.was_white()) && coat.factor != DVec3::ZERO
    }
}
