//! Lofts, of which rooms and bodies are made: solids between two similar outlines in parallel
//! planes. The walls are planar for any scale and shift of the upper outline.

use super::convex::ConvexBody;
use super::{FaceShapes, RandomSource, draw_reflectance};
use common::scene::Face;
use glam::{DMat3, DVec2, DVec3, Vec3};
use rand::RngExt;
use std::f64::consts::TAU;

/// Representation of the two sides of a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SheetSides {
    /// Two partner faces, as an import makes of a two-sided face.
    Partners,
    /// Two independent faces that coincide.
    Coinciding,
}

/// A planar convex quad that is not yet converted to faces; one that becomes triangles need not be planar.
#[derive(Clone, Debug)]
pub struct Panel {
    pub name: String,
    /// Counter-clockwise from the front.
    pub corners: [DVec3; 4],
    pub emission: Vec3,
    pub reflectance: Vec3,
    /// Representation of its back, if that is a front as well.
    pub two_sided: Option<SheetSides>,
}

impl Panel {
    /// Makes a quad that neither emits nor reflects.
    pub fn new(name: &str, corners: [DVec3; 4]) -> Self {
        Self {
            name: name.to_owned(),
            corners,
            emission: Vec3::ZERO,
            reflectance: Vec3::ZERO,
            two_sided: None,
        }
    }

    /// Returns the quad as one face, or as two triangles.
    fn to_faces(&self, source: &mut RandomSource, shapes: FaceShapes) -> Vec<Face> {
        let split = match shapes {
            FaceShapes::Quads => false,
            FaceShapes::Triangles => true,
            FaceShapes::Mixed => source.random_bool(0.5),
        };
        if !split {
            return vec![Face::quad(&self.name, self.corners, self.emission, self.reflectance)];
        }
        let [a, b, c, d] = self.corners;
        let halves = if source.random_bool(0.5) {
            [[a, b, c], [a, c, d]]
        } else {
            [[a, b, d], [b, c, d]]
        };
        let half = |mut corners: [DVec3; 3]| {
            corners.rotate_left(source.random_range(0..3));
            Face::triangle(&self.name, corners, self.emission, self.reflectance)
        };
        // At the pole of a surface two corners coincide.
        halves.map(half).into_iter().filter(|half| half.area() > 0.0).collect()
    }
}

/// Returns the faces of all panels, the backs of two-sided sheets last, as an import does.
pub fn faces_of_panels(source: &mut RandomSource, panels: &[Panel], shapes: FaceShapes) -> Vec<Face> {
    let (mut all, mut fronts) = (Vec::new(), Vec::new());
    for panel in panels {
        let first = all.len();
        all.extend(panel.to_faces(source, shapes));
        match panel.two_sided {
            Some(SheetSides::Partners) => fronts.extend(first..all.len()),
            Some(SheetSides::Coinciding) => {
                let [a, b, c, d] = panel.corners;
                let back = Panel {
                    corners: [a, d, c, b],
                    ..panel.clone()
                };
                all.extend(back.to_faces(source, shapes));
            }
            None => {}
        }
    }
    for front in fronts {
        all[front].partner = Some(all.len() as u32);
        all.push(Face {
            input_face: Some(front as u32),
            partner: Some(front as u32),
            ..all[front].reversed()
        });
    }
    all
}

/// Draws one reflectance for all panels, or one for each.
pub fn paint_panels(source: &mut RandomSource, panels: &mut [Panel]) {
    let same = draw_reflectance(source);
    let one = source.random_bool(0.6);
    for panel in panels {
        panel.reflectance = if one { same } else { draw_reflectance(source) };
    }
}

/// An outline in the plane of x and z, counter-clockwise from above: (sin a, cos a) for growing a.
#[derive(Clone, Debug)]
pub struct Footprint {
    pub points: Vec<DVec2>,
    /// Quads that cover it, by corner index.
    pub quads: Vec<[usize; 4]>,
    /// Maximal convex parts that together cover it, by corner index; one if it is convex.
    pub parts: Vec<Vec<usize>>,
}

impl Footprint {
    /// Makes a convex outline, cut into quads. The number of corners is even; the first may lie within
    /// an edge.
    pub fn from_convex(points: Vec<DVec2>) -> Self {
        let n = points.len();
        Self {
            quads: (1..n - 2).step_by(2).map(|k| [0, k, k + 1, k + 2]).collect(),
            parts: vec![(0..n).collect()],
            points,
        }
    }

    /// Makes a regular polygon of an even number of corners about the origin.
    pub fn regular(corners: usize, radius: DVec2) -> Self {
        let angles = (0..corners).map(|k| TAU * k as f64 / corners as f64);
        Self::from_convex(angles.map(|a| DVec2::new(a.sin(), a.cos()) * radius).collect())
    }

    /// Makes a rectangle about the origin.
    pub fn rectangle(x: f64, z: f64) -> Self {
        let [x, z] = [0.5 * x, 0.5 * z];
        let points = [[-x, -z], [-x, z], [x, z], [x, -z]];
        Self::from_convex(points.map(DVec2::from).into())
    }

    /// Makes an L shape: a rectangle without its part x > `at.x` and z > `at.y`, in shares of its sides.
    pub fn l_shape(x: f64, z: f64, at: DVec2) -> Self {
        let (p, q) = (at.x, at.y);
        let shares = [[0., 0.], [0., q], [0., 1.], [p, 1.], [p, q], [1., q], [1., 0.], [p, 0.]];
        let place = |share: [f64; 2]| (DVec2::from(share) - 0.5) * DVec2::new(x, z);
        Self {
            points: shares.map(place).into(),
            quads: vec![[0, 1, 4, 7], [1, 2, 3, 4], [7, 4, 5, 6]],
            parts: vec![vec![0, 2, 3, 7], vec![0, 1, 5, 6]],
        }
    }
}

/// A solid between an outline in y = 0 and a similar one at its height.
#[derive(Clone, Debug)]
pub struct Loft {
    bottom: Vec<DVec3>,
    top: Vec<DVec3>,
    outline: Footprint,
}

impl Loft {
    /// Makes a loft over `outline`; the upper outline is scaled by `scale` and shifted by `shift`.
    pub fn new(outline: Footprint, height: f64, scale: f64, shift: DVec2) -> Self {
        let at = |p: DVec2, y: f64| DVec3::new(p.x, y, p.y);
        let points = &outline.points;
        Self {
            bottom: points.iter().map(|p| at(*p, 0.0)).collect(),
            top: points.iter().map(|p| at(*p * scale + shift, height)).collect(),
            outline,
        }
    }

    /// Rotates it about the origin.
    pub fn rotate_by(mut self, turn: DMat3) -> Self {
        for point in self.bottom.iter_mut().chain(&mut self.top) {
            *point = turn * *point;
        }
        self
    }

    /// Translates it.
    pub fn move_by(mut self, by: DVec3) -> Self {
        for point in self.bottom.iter_mut().chain(&mut self.top) {
            *point += by;
        }
        self
    }

    /// Iterates over the corners.
    pub fn corner_points(&self) -> impl Iterator<Item = DVec3> {
        self.bottom.iter().chain(&self.top).copied()
    }

    /// Returns floor, ceiling and walls, fronts inwards.
    pub fn inward_panels(&self) -> [Vec<Panel>; 3] {
        let (bottom, top, n) = (&self.bottom, &self.top, self.bottom.len());
        let quads = self.outline.quads.iter();
        let floor = quads.clone().map(|q| Panel::new("floor", q.map(|k| bottom[k])));
        let ceiling = quads.map(|[a, b, c, d]| Panel::new("ceiling", [a, d, c, b].map(|k| top[*k])));
        let wall = |k: usize| {
            let next = (k + 1) % n;
            let corners = [bottom[next], bottom[k], top[k], top[next]];
            Panel::new(&format!("wall {}", k + 1), corners)
        };
        [floor.collect(), ceiling.collect(), (0..n).map(wall).collect()]
    }

    /// Returns all faces, fronts outwards.
    pub fn outward_panels(&self, name: &str) -> Vec<Panel> {
        let all = self.inward_panels().into_iter().flatten();
        let turned = |panel: Panel| {
            let [a, b, c, d] = panel.corners;
            Panel::new(name, [a, d, c, b])
        };
        all.map(turned).collect()
    }

    /// Returns the least and the greatest y.
    pub fn height_range(&self) -> [f64; 2] {
        self.convex_hull().extent_along(DVec3::Y)
    }

    /// Returns the body of a convex outline.
    pub fn convex_hull(&self) -> ConvexBody {
        ConvexBody::from_prism(&self.bottom, &self.top)
    }

    /// Returns the convex parts.
    pub fn convex_parts(&self) -> Vec<ConvexBody> {
        let part = |part: &Vec<usize>| {
            let pick = |from: &[DVec3]| part.iter().map(|k| from[*k]).collect::<Vec<_>>();
            ConvexBody::from_prism(&pick(&self.bottom), &pick(&self.top))
        };
        self.outline.parts.iter().map(part).collect()
    }
}
