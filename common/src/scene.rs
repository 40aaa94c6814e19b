//! Scenes in the file's units: planar, one-sided faces that emit and reflect diffusely.
//!
//! Lengths are in the file's own unit (it cancels), radiosities in W/m² per channel of linear
//! Rec. 709. Positions are f64 so that a scene far from its origin keeps its shape until
//! [`crate::mesh::Mesh`] moves it to the origin.

use crate::constants::CONTACT_DISTANCE;
use crate::paint::{MAX_WHITE_REFLECTANCE, Paint};
use crate::sky::Sky;
use glam::{DVec3, Vec2, Vec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::sync::Arc;

/// A scene: faces in file order.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The file's name, for messages and `result.json`.
    pub name: String,
    /// Planar convex faces: input face k is entry k; further pieces of split faces follow, and backs last.
    pub faces: Vec<Face>,
    /// Notes of the import (a split face, a default material).
    pub notes: Vec<String>,
    /// Light from outside.
    pub sky: Option<Arc<Sky>>,
}

/// A face's outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// Planar and convex; texels are bilinear.
    Quad,
    /// Texels are N² equal sub-triangles.
    Triangle,
}

impl Shape {
    /// Returns the point at (u, v): bilinear on a quad; on a triangle u runs along edge 0→1, v along 0→2.
    pub fn point_at(self, [a, b, c, d]: [DVec3; 4], u: f64, v: f64) -> DVec3 {
        match self {
            Self::Quad => a.lerp(b, u).lerp(d.lerp(c, u), v),
            Self::Triangle => a + (b - a) * u + (c - a) * v,
        }
    }
}

/// A planar convex face; its front is the side from which the corners run counter-clockwise.
#[derive(Clone, Debug)]
pub struct Face {
    /// Group or object name.
    pub name: String,
    /// Quad or triangle.
    pub shape: Shape,
    /// Corners, counter-clockwise from the front; a triangle repeats its third.
    pub corners: [DVec3; 4],
    /// Emitted radiosity E = πL, W/m²: the mean over its area.
    pub emission: Vec3,
    /// Diffuse reflectance ρ, 0 ≤ ρ < 1 per channel: the mean over its area.
    pub reflectance: Vec3,
    /// Input face that this face is a piece or the other side of.
    pub input_face: Option<u32>,
    /// Face on the other side of this sheet, if the sheet is two-sided.
    pub partner: Option<u32>,
    /// Upper bound on the rounding of each coordinate in the file, scene units (see [`crate::precision`]).
    pub rounding: f64,
    /// Normals at the corners, as in the file. Two faces with the same normal at a corner approximate one
    /// curved surface. The solvers do not use them.
    pub corner_normals: Option<[Vec3; 4]>,
    /// Variation of ρ and E over the face, if they vary.
    pub paint: Option<Arc<Paint>>,
    /// Positions of a triangle's corners on the file's lightmap; none if the import does not read them or
    /// the file has none.
    pub lightmap_corners: Option<[Vec2; 3]>,
}

/// Smallest extent of the largest lamp, as a share of the scene's: fronts within [`CONTACT_DISTANCE`] exchange nothing.
const MIN_LAMP_SHARE: f64 = 2.0 * CONTACT_DISTANCE as f64;
/// Smallest area of a lamp, as a share of its extent squared.
const MIN_LAMP_AREA_SHARE: f64 = 1e-12;

impl Face {
    /// Returns the largest distance of two corners along an axis.
    fn extent(&self) -> f64 {
        let [first, rest @ ..] = self.corners;
        let [low, high] = rest
            .iter()
            .fold([first; 2], |[low, high], p| [low.min(*p), high.max(*p)]);
        (high - low).max_element()
    }

    /// Makes a quad with the given corners.
    pub fn quad(name: &str, corners: [DVec3; 4], emission: Vec3, reflectance: Vec3) -> Self {
        Self {
            name: name.to_owned(),
            shape: Shape::Quad,
            corners,
            emission,
            reflectance,
            input_face: None,
            partner: None,
            rounding: 0.0,
            corner_normals: None,
            paint: None,
            lightmap_corners: None,
        }
    }

    /// Makes a triangle with the given corners.
    pub fn triangle(name: &str, c: [DVec3; 3], emission: Vec3, reflectance: Vec3) -> Self {
        Self {
            shape: Shape::Triangle,
            ..Self::quad(name, [c[0], c[1], c[2], c[2]], emission, reflectance)
        }
    }

    /// Returns the 4 or 3 corners, without a triangle's repeated one.
    pub fn outline(&self) -> &[DVec3] {
        match self.shape {
            Shape::Quad => &self.corners,
            Shape::Triangle => &self.corners[..3],
        }
    }

    /// Returns the vector area: the front's normal times the area (scene units squared).
    pub fn vector_area(&self) -> DVec3 {
        let [a, b, c, d] = self.corners;
        (c - a).cross(d - b) * 0.5
    }

    /// Returns the area in scene units squared.
    pub fn area(&self) -> f64 {
        self.vector_area().length()
    }

    /// Returns the lengths of the sides from corner 0 to corner 1 and to corner 3, by which texels are counted: the longest
    /// twice on a triangle, and on a quad unless its sides differ by more than a factor of three.
    pub fn grid_lengths(&self) -> [f64; 2] {
        let [a, b, c, d] = self.corners;
        let sides = [a.distance(b).max(c.distance(d)), b.distance(c).max(d.distance(a))];
        let long = sides[0].max(sides[1]);
        let even = self.shape == Shape::Triangle || long <= 3.0 * sides[0].min(sides[1]);
        if even { [long; 2] } else { sides }
    }

    /// Returns along which sides the parts of a W×H grid are to be divided to become more even: both, or that along which
    /// they are more than twice as long.
    pub fn longer_sides(&self, grid: [u32; 2]) -> [bool; 2] {
        let lengths = self.grid_lengths();
        let [u, v] = [0, 1].map(|k| lengths[k] / f64::from(grid[k]));
        [v <= 2.0 * u, u <= 2.0 * v]
    }

    /// Returns twice as many texels along those sides.
    pub fn halve_texels(&self, texels: [u32; 2]) -> [u32; 2] {
        let longer = self.longer_sides(texels);
        [0, 1].map(|k| if longer[k] { 2 * texels[k] } else { texels[k] })
    }

    /// Returns the point at (u, v), as [`Shape::point_at`].
    pub fn point_at(&self, u: f64, v: f64) -> DVec3 {
        self.shape.point_at(self.corners, u, v)
    }

    /// Returns the means of ρ and E over a convex part of the face.
    pub fn mean_surface(&self, part: &[DVec3]) -> [Vec3; 2] {
        match &self.paint {
            Some(paint) => self.surface_or_own(paint.mean_over(self.outline(), part)),
            None => [self.reflectance, self.emission],
        }
    }

    /// Returns ρ and E at a point of the face.
    pub fn surface_at(&self, point: DVec3) -> [Vec3; 2] {
        match &self.paint {
            Some(paint) => self.surface_or_own(paint.value_at(self.outline(), point)),
            None => [self.reflectance, self.emission],
        }
    }

    /// Converts paint to ρ and E; the face's own values where paint has none.
    fn surface_or_own(&self, [reflectance, radiance]: [Option<DVec3>; 2]) -> [Vec3; 2] {
        let whitest = |rho: Vec3| Vec3::select(rho.cmpge(Vec3::ONE), Vec3::splat(MAX_WHITE_REFLECTANCE), rho);
        [
            reflectance.map_or(self.reflectance, |rho| whitest(rho.as_vec3())),
            radiance.map_or(self.emission, |l| (l * PI).as_vec3()),
        ]
    }

    /// Returns the face with its front on the other side.
    pub fn reversed(&self) -> Self {
        let turned = match self.shape {
            Shape::Quad => [0, 3, 2, 1],
            Shape::Triangle => [0, 2, 1, 1],
        };
        Self {
            corners: turned.map(|k| self.corners[k]),
            corner_normals: self.corner_normals.map(|normals| turned.map(|k| -normals[k])),
            paint: (self.paint.as_ref()).map(|paint| Arc::new(paint.with_corner_order(turned))),
            lightmap_corners: self.lightmap_corners.map(|[a, b, c]| [a, c, b]),
            ..self.clone()
        }
    }
}

impl Scene {
    /// Returns the smallest and the largest coordinates of the corners.
    pub fn bounds(&self) -> [DVec3; 2] {
        let corners = self.faces.iter().flat_map(Face::outline);
        corners.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], c| {
            [low.min(*c), high.max(*c)]
        })
    }

    /// Returns the number of face `k` in the scene's file, from 1 on, and its name.
    pub fn face_label(&self, k: usize) -> String {
        let face = &self.faces[k];
        let number = face.input_face.map_or(k, |k| k as usize) + 1;
        format!("face {number} ({})", face.name)
    }

    /// Returns why the light of all lamps is lost, if it is and there are lamps: they have no area, or hardly any extent
    /// beside that of the scene.
    pub fn explain_lost_lamps(&self) -> Option<String> {
        let lamps = || (0..self.faces.len()).filter(|k| self.faces[*k].emission != Vec3::ZERO);
        let first = lamps().next()?;
        let extent = |k: &usize| self.faces[*k].extent();
        let has_area = |k: &usize| self.faces[*k].area() > MIN_LAMP_AREA_SHARE * extent(k).powi(2);
        let Some(lamp) = lamps().filter(has_area).max_by(|a, b| extent(a).total_cmp(&extent(b))) else {
            let label = self.face_label(first);
            return Some(format!(
                "no face that emits light has an area: {label} is a line or a point"
            ));
        };
        let [low, high] = self.bounds();
        let (size, own) = ((high - low).max_element(), extent(&lamp));
        if own >= MIN_LAMP_SHARE * size {
            return None;
        }
        let place = self.faces[lamp].corners[0];
        let distance = |k: &usize| {
            self.faces[*k]
                .corners
                .map(|p| p.distance(place))
                .into_iter()
                .fold(0.0, f64::max)
        };
        let farthest = (0..self.faces.len()).max_by(|a, b| distance(a).total_cmp(&distance(b)));
        Some(format!(
            "its light is lost in rounding: the largest lamp, {}, extends over {own:.1e}, and the scene over {size:.1e}; \
             is a corner of {} misplaced?",
            self.face_label(lamp),
            self.face_label(farthest.unwrap_or(lamp)),
        ))
    }

    /// Returns whether ρ or E vary within a face.
    pub fn is_painted(&self) -> bool {
        self.faces.iter().any(|face| face.paint.is_some())
    }

    /// Joins scenes to one, in their order.
    pub fn join_scenes(scenes: &[Self]) -> Self {
        let mut all = Self {
            name: scenes.first().map_or_else(String::new, |s| s.name.clone()),
            ..Self::default()
        };
        for scene in scenes {
            let first = all.faces.len() as u32;
            all.faces.extend(scene.faces.iter().map(|face| Face {
                input_face: face.input_face.map(|k| k + first),
                partner: face.partner.map(|k| k + first),
                ..face.clone()
            }));
            all.notes.extend(scene.notes.iter().cloned());
        }
        all
    }

    /// Adds a face for the back of each face (`--two-sided`). The backs follow all other faces, so that
    /// entry k stays input face k.
    pub fn two_sided(mut self) -> Self {
        let count = self.faces.len() as u32;
        let back = |(k, face): (u32, &mut Face)| {
            face.partner = Some(count + k);
            Face {
                input_face: Some(face.input_face.unwrap_or(k)),
                partner: Some(k),
                ..face.reversed()
            }
        };
        let backs: Vec<Face> = (0..count).zip(&mut self.faces).map(back).collect();
        self.faces.extend(backs);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_scenes_keep_pieces_and_partners() {
        let quad = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let scene = Scene {
            faces: vec![Face::quad("a", quad, Vec3::ONE, Vec3::ZERO); 2],
            ..Scene::default()
        };
        let scene = scene.two_sided();
        let twice = Scene::join_scenes(&[scene.clone(), scene.clone()]);
        assert_eq!(twice.faces.len(), 8);
        for (face, again) in twice.faces[..4].iter().zip(&twice.faces[4..]) {
            assert_eq!(again.input_face, face.input_face.map(|k| k + 4));
            assert_eq!(again.partner, face.partner.map(|k| k + 4));
        }
    }
}
