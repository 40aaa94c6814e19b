//! Triangles, what a ray meets of them, and points on lamps: all of them asked in turn.

use common::scene::{Face, Scene, Shape};
use glam::{DVec2, DVec3};
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
    pub normals: Vec<DVec3>,
    extent: f64,
}

impl Solid {
    pub fn new(scene: &Scene) -> Self {
        let faces = scene.faces.iter().enumerate();
        let corners = || scene.faces.iter().flat_map(Face::outline);
        let low = corners().fold(DVec3::INFINITY, |a, b| a.min(*b));
        let high = corners().fold(DVec3::NEG_INFINITY, |a, b| a.max(*b));
        Self {
            triangles: faces.flat_map(triangles).collect(),
            normals: scene
                .faces
                .iter()
                .map(|f| f.vector_area().normalize())
                .collect(),
            extent: (high - low).max_element(),
        }
    }

    /// The front that a ray from `from` meets; none where it meets a back or nothing.
    pub fn hit(&self, from: &Hit, along: DVec3) -> Option<Hit> {
        let origin = self.start(from);
        let mut nearest = (f64::INFINITY, None);
        for triangle in self.triangles.iter().filter(|t| t.face != from.face) {
            if let Some((t, front)) = triangle.meet(origin, along).filter(|(t, _)| *t > 0.0) {
                let back = if front { 0.0 } else { SAME * self.extent };
                if t + back < nearest.0 {
                    nearest = (t + back, front.then_some(triangle.face));
                }
            }
        }
        nearest.1.map(|face| Hit {
            face,
            at: origin + along * nearest.0,
        })
    }

    /// Whether anything lies between two points.
    pub fn hides(&self, from: &Hit, to: &Hit) -> bool {
        let origin = self.start(from);
        let along = to.at - origin;
        let end = 1.0 - SAME * self.extent / along.length();
        let others = self
            .triangles
            .iter()
            .filter(|t| t.face != from.face && t.face != to.face);
        let between = |t: f64| t > 0.0 && t < end;
        others.into_iter().any(|triangle| {
            triangle
                .meet(origin, along)
                .is_some_and(|(t, _)| between(t))
        })
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
