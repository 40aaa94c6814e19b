//! What rooms and bodies are made of: a prism between two similar outlines in parallel planes. Its
//! walls are planar whatever the upper outline's size and place, and its outline is cut into quads.

use super::convex::Convex;
use super::{Source, reflectance};
use common::scene::Face;
use glam::{DMat3, DVec2, DVec3, Vec3};
use rand::RngExt;
use std::fmt;

/// How the two sides of a sheet are given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sheet {
    /// Each is the other's partner.
    Partners,
    /// Two faces that coincide.
    Coinciding,
}

impl fmt::Display for Sheet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Partners => "two-sided",
            Self::Coinciding => "of two faces",
        })
    }
}

/// A planar convex quad on which nothing is decided but its place and colour.
#[derive(Clone, Debug)]
pub struct Panel {
    pub name: String,
    /// Counter-clockwise from the front.
    pub corners: [DVec3; 4],
    pub emission: Vec3,
    pub reflectance: Vec3,
    /// How its back is given, if that is a front as well.
    pub two_sided: Option<Sheet>,
}

impl Panel {
    /// A dark quad.
    pub fn new(name: &str, corners: [DVec3; 4]) -> Self {
        Self {
            name: name.to_owned(),
            corners,
            emission: Vec3::ZERO,
            reflectance: Vec3::ZERO,
            two_sided: None,
        }
    }

    /// The quad as a face.
    pub fn face(&self) -> Face {
        Face::quad(&self.name, self.corners, self.emission, self.reflectance)
    }
}

/// One colour for all faces, or each its own.
pub fn dress(source: &mut Source, panels: &mut [Panel]) {
    let same = reflectance(source);
    let one = source.random_bool(0.6);
    for panel in panels {
        panel.reflectance = if one { same } else { reflectance(source) };
    }
}

/// An outline in the plane of x and z, counter-clockwise from above: (sin a, cos a) for growing a.
#[derive(Clone, Debug)]
pub struct Outline {
    pub points: Vec<DVec2>,
    /// Quads that cover it.
    pub quads: Vec<[usize; 4]>,
    /// Its largest convex parts: together they cover it, one alone if it is convex.
    pub parts: Vec<Vec<usize>>,
}

impl Outline {
    /// A convex one, cut into quads; it has an even number of corners, and its first may lie
    /// within an edge.
    pub fn convex(points: Vec<DVec2>) -> Self {
        let n = points.len();
        Self {
            quads: (1..n - 2)
                .step_by(2)
                .map(|k| [0, k, k + 1, k + 2])
                .collect(),
            parts: vec![(0..n).collect()],
            points,
        }
    }

    /// A rectangle.
    pub fn rectangle(x: f64, z: f64) -> Self {
        let [x, z] = [0.5 * x, 0.5 * z];
        let points = [[-x, -z], [-x, z], [x, z], [x, -z]];
        Self::convex(points.map(DVec2::from).into())
    }

    /// A rectangle without a corner: x > `at.x` and z > `at.y`, shares of its sides.
    pub fn angle(x: f64, z: f64, at: DVec2) -> Self {
        let (p, q) = (at.x, at.y);
        let shares = [
            [0., 0.],
            [0., q],
            [0., 1.],
            [p, 1.],
            [p, q],
            [1., q],
            [1., 0.],
            [p, 0.],
        ];
        let place = |share: [f64; 2]| (DVec2::from(share) - 0.5) * DVec2::new(x, z);
        Self {
            points: shares.map(place).into(),
            quads: vec![[0, 1, 4, 7], [1, 2, 3, 4], [7, 4, 5, 6]],
            parts: vec![vec![0, 2, 3, 7], vec![0, 1, 5, 6]],
        }
    }
}

/// The prism: from y = 0 to its height.
#[derive(Clone, Debug)]
pub struct Loft {
    bottom: Vec<DVec3>,
    top: Vec<DVec3>,
    outline: Outline,
}

impl Loft {
    /// Over `outline`; the upper one is `scale` times as large and moved by `shift`.
    pub fn new(outline: Outline, height: f64, scale: f64, shift: DVec2) -> Self {
        let at = |p: DVec2, y: f64| DVec3::new(p.x, y, p.y);
        let points = &outline.points;
        Self {
            bottom: points.iter().map(|p| at(*p, 0.0)).collect(),
            top: points
                .iter()
                .map(|p| at(*p * scale + shift, height))
                .collect(),
            outline,
        }
    }

    /// Turned about the origin.
    pub fn turned(mut self, turn: DMat3) -> Self {
        for point in self.bottom.iter_mut().chain(&mut self.top) {
            *point = turn * *point;
        }
        self
    }

    /// Moved.
    pub fn moved(mut self, by: DVec3) -> Self {
        for point in self.bottom.iter_mut().chain(&mut self.top) {
            *point += by;
        }
        self
    }

    /// Its corners.
    pub fn points(&self) -> impl Iterator<Item = DVec3> {
        self.bottom.iter().chain(&self.top).copied()
    }

    /// Floor, ceiling and walls, fronts inwards.
    pub fn inward(&self) -> [Vec<Panel>; 3] {
        let (bottom, top, n) = (&self.bottom, &self.top, self.bottom.len());
        let quads = self.outline.quads.iter();
        let floor = quads
            .clone()
            .map(|q| Panel::new("floor", q.map(|k| bottom[k])));
        let ceiling =
            quads.map(|[a, b, c, d]| Panel::new("ceiling", [a, d, c, b].map(|k| top[*k])));
        let wall = |k: usize| {
            let next = (k + 1) % n;
            let corners = [bottom[next], bottom[k], top[k], top[next]];
            Panel::new(&format!("wall {}", k + 1), corners)
        };
        [
            floor.collect(),
            ceiling.collect(),
            (0..n).map(wall).collect(),
        ]
    }

    /// All its faces, fronts outwards.
    pub fn outward(&self, name: &str) -> Vec<Panel> {
        let all = self.inward().into_iter().flatten();
        let turned = |panel: Panel| {
            let [a, b, c, d] = panel.corners;
            Panel::new(name, [a, d, c, b])
        };
        all.map(turned).collect()
    }

    /// Its convex parts.
    pub fn parts(&self) -> Vec<Convex> {
        let part = |part: &Vec<usize>| {
            let pick = |from: &[DVec3]| part.iter().map(|k| from[*k]).collect::<Vec<_>>();
            Convex::prism(&pick(&self.bottom), &pick(&self.top))
        };
        self.outline.parts.iter().map(part).collect()
    }
}
