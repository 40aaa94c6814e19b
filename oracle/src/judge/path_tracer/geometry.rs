//! Triangles, what a ray meets of them, and points on lamps.

use super::tree::Tree;
use common::scene::{Face, Scene, Shape};
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::PI;

/// Rays begin this far in front of their face, of the scene's extent: within whatever stands there,
/// so that they meet its back. It is far less than any gap and far more than rounding.
const OFF: f64 = 1e-9;
/// Where a front and a back coincide, a ray meets the front: the other side of a sheet.
const SAME: f64 = 1e-10;

/// A point of a face's front.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    pub face: usize,
    pub at: DVec3,
}

/// What a ray meets first.
enum Met {
    Front(Hit),
    Back,
    /// At one place: a sheet, or a body at a wall, seen from the room or from within the body.
    Both(Hit),
    Nothing,
}

/// Half a quad, or a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    face: usize,
    corner: DVec3,
    edges: [DVec3; 2],
}

impl Triangle {
    /// Of face `face`.
    pub fn new(face: usize, [a, b, c]: [DVec3; 3]) -> Self {
        Self {
            face,
            corner: a,
            edges: [b - a, c - a],
        }
    }

    pub fn area(&self) -> f64 {
        0.5 * self.edges[0].cross(self.edges[1]).length()
    }

    /// The least and the greatest coordinates.
    fn bounds(&self) -> [DVec3; 2] {
        let [a, b, c] = [DVec3::ZERO, self.edges[0], self.edges[1]].map(|e| self.corner + e);
        [a.min(b).min(c), a.max(b).max(c)]
    }

    /// Of the unit square, folded onto the triangle: all points as likely.
    pub fn point(&self, at: DVec2) -> DVec3 {
        let at = if at.x + at.y > 1.0 { 1.0 - at } else { at };
        self.corner + self.edges[0] * at.x + self.edges[1] * at.y
    }

    /// How far along a ray it is met, and whether from the front (Möller & Trumbore 1997).
    fn meet(&self, origin: DVec3, along: DVec3) -> Option<(f64, bool)> {
        let [a, b] = self.edges;
        let p = along.cross(b);
        let determinant = a.dot(p);
        if determinant == 0.0 {
            return None;
        }
        let from = origin - self.corner;
        let u = from.dot(p) / determinant;
        let q = from.cross(a);
        let v = along.dot(q) / determinant;
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
        inside.then(|| (b.dot(q) / determinant, determinant > 0.0))
    }
}

/// A face's triangles; a quad has two.
fn triangles((face, of): (usize, &Face)) -> impl Iterator<Item = Triangle> {
    let [a, b, c, d] = of.corners;
    let second = (of.shape == Shape::Quad).then(|| Triangle::new(face, [a, c, d]));
    std::iter::once(Triangle::new(face, [a, b, c])).chain(second)
}

/// All faces.
pub struct Solid {
    triangles: Vec<Triangle>,
    tree: Tree,
    pub normals: Vec<DVec3>,
    extent: f64,
}

impl Solid {
    pub fn new(scene: &Scene) -> Self {
        let faces = scene.faces.iter().enumerate();
        let corners = || scene.faces.iter().flat_map(Face::outline);
        let low = corners().fold(DVec3::INFINITY, |a, b| a.min(*b));
        let high = corners().fold(DVec3::NEG_INFINITY, |a, b| a.max(*b));
        let extent = (high - low).max_element();
        let triangles: Vec<Triangle> = faces.flat_map(triangles).collect();
        let boxes: Vec<_> = triangles.iter().map(Triangle::bounds).collect();
        Self {
            tree: Tree::new(&boxes, extent),
            triangles,
            normals: scene
                .faces
                .iter()
                .map(|f| f.vector_area().normalize())
                .collect(),
            extent,
        }
    }

    /// The front that a ray from `from` meets; none where it meets a back or nothing.
    pub fn hit(&self, from: &Hit, along: DVec3) -> Option<Hit> {
        match self.meet(from, along) {
            Met::Front(hit) | Met::Both(hit) => Some(hit),
            Met::Back | Met::Nothing => None,
        }
    }

    fn meet(&self, from: &Hit, along: DVec3) -> Met {
        let origin = self.start(from);
        let same = SAME * self.extent;
        let (mut front, mut back, mut end) = (None, f64::INFINITY, f64::INFINITY);
        self.tree.walk(origin, along, &mut end, |k, end| {
            let triangle = &self.triangles[k];
            let met = triangle.meet(origin, along).filter(|(t, _)| *t > 0.0);
            let Some((t, is_front)) = met.filter(|_| triangle.face != from.face) else {
                return;
            };
            if !is_front {
                back = t.min(back);
            } else if front.is_none_or(|(_, other)| t < other) {
                front = Some((triangle.face, t));
            }
            *end = end.min(t + same);
        });
        match front {
            Some((face, t)) if t < back + same => {
                let at = origin + along * t;
                let hit = Hit { face, at };
                if back < t + same {
                    Met::Both(hit)
                } else {
                    Met::Front(hit)
                }
            }
            _ if back.is_finite() => Met::Back,
            _ => Met::Nothing,
        }
    }

    /// Whether a point lies within a body of which a side lies on a wall, and would let light in: wall and side are
    /// met as the two sides of a sheet are. Of these directions, z along the normal, some lead there, some to a back
    /// alone, and none to a front alone or out.
    pub fn is_within(&self, at: &Hit, directions: &[DVec3]) -> bool {
        let (x, y) = self.normals[at.face].any_orthonormal_pair();
        let frame = DMat3::from_cols(x, y, self.normals[at.face]);
        let (mut backs, mut both) = (false, false);
        for direction in directions {
            match self.meet(at, frame * *direction) {
                Met::Front(_) | Met::Nothing => return false,
                Met::Back => backs = true,
                Met::Both(_) => both = true,
            }
        }
        backs && both
    }

    /// Whether anything lies between two points.
    pub fn hides(&self, from: &Hit, to: &Hit) -> bool {
        let origin = self.start(from);
        let along = to.at - origin;
        let end = 1.0 - SAME * self.extent / along.length();
        let (mut hidden, mut before) = (false, end);
        self.tree.walk(origin, along, &mut before, |k, before| {
            let triangle = &self.triangles[k];
            let other = triangle.face != from.face && triangle.face != to.face;
            let met = triangle.meet(origin, along);
            if other && met.is_some_and(|(t, _)| t > 0.0 && t < end) {
                hidden = true;
                // Nothing more is asked.
                *before = f64::NEG_INFINITY;
            }
        });
        hidden
    }

    /// G of two points that see each other; 0 where one shows its back.
    pub fn kernel(&self, a: &Hit, b: &Hit) -> f64 {
        let r = b.at - a.at;
        let cosines = [(a, r), (b, -r)].map(|(p, r)| self.normals[p.face].dot(r).max(0.0));
        cosines[0] * cosines[1] / (PI * r.length_squared().powi(2))
    }

    fn start(&self, from: &Hit) -> DVec3 {
        from.at + self.normals[from.face] * (OFF * self.extent)
    }
}

/// Points on lamps, drawn by power.
pub struct Lamps {
    triangles: Vec<Triangle>,
    /// Power up to and with each.
    power: Vec<f64>,
}

impl Lamps {
    pub fn new(scene: &Scene) -> Self {
        let faces = scene.faces.iter().enumerate();
        let lamps = faces.filter(|(_, face)| face.emission.max_element() > 0.0);
        let triangles: Vec<Triangle> = lamps.flat_map(triangles).collect();
        let mut sum = 0.0;
        let power = triangles.iter().map(|triangle| {
            let emission = scene.faces[triangle.face].emission.as_dvec3();
            sum += triangle.area() * emission.element_sum();
            sum
        });
        Self {
            power: power.collect(),
            triangles,
        }
    }

    /// A point, by three numbers within 0…1.
    pub fn draw(&self, which: f64, at: DVec2) -> Option<Hit> {
        let which = which * self.power.last()?;
        let k = self.power.partition_point(|power| *power <= which);
        let triangle = self.triangles.get(k)?;
        Some(Hit {
            face: triangle.face,
            at: triangle.point(at),
        })
    }

    /// How likely a point of a lamp is, per area.
    pub fn density(&self, emission: DVec3) -> f64 {
        self.power
            .last()
            .map_or(0.0, |all| emission.element_sum() / all)
    }
}
