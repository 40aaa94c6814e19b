//! Triangles of a scene, their intersection with rays, and sampling of lamps. Only the path tracer uses it.

use super::tree::BoxTree;
use common::mesh::{Mesh, MeshFace};
use common::scene::{Face, Scene, Shape};
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::PI;

/// Distance of a ray's origin in front of its face, as a share of the scene's extent. It lies inside any body that
/// stands on the face, so that the ray meets the body's back; it is far less than any gap and far more than rounding.
const RAY_ORIGIN_OFFSET: f64 = 1e-9;
/// Distance within which faces coincide, as a share of the scene's extent: of a front and a back a ray then meets the
/// front (the other side of a sheet), of two fronts the one that precedes the other.
const COINCIDENCE_TOLERANCE: f64 = 1e-10;

/// A point of a face's front.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    pub face: usize,
    pub position: DVec3,
}

/// Half a quad, or a triangle.
#[derive(Clone, Copy, Debug)]
pub struct RayTriangle {
    face: usize,
    corner: DVec3,
    edges: [DVec3; 2],
}

impl RayTriangle {
    /// Creates a triangle of face `face`.
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

    /// Returns the smallest and the largest coordinates.
    fn bounds(&self) -> [DVec3; 2] {
        let [a, b, c] = [DVec3::ZERO, self.edges[0], self.edges[1]].map(|e| self.corner + e);
        [a.min(b).min(c), a.max(b).max(c)]
    }

    /// Maps a point of the unit square to the triangle by folding; uniform points stay uniform.
    pub fn point_at(&self, at: DVec2) -> DVec3 {
        let at = if at.x + at.y > 1.0 { 1.0 - at } else { at };
        self.corner + self.edges[0] * at.x + self.edges[1] * at.y
    }

    /// Returns the distance along a ray, and true if it meets the front (Möller & Trumbore 1997).
    fn intersect_ray(&self, origin: DVec3, along: DVec3) -> Option<(f64, bool)> {
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

/// Returns the triangles of a face; a quad has two.
pub fn face_triangles((face, of): (usize, &Face)) -> impl Iterator<Item = RayTriangle> {
    let [a, b, c, d] = of.corners;
    let second = (of.shape == Shape::Quad).then(|| RayTriangle::new(face, [a, c, d]));
    std::iter::once(RayTriangle::new(face, [a, b, c])).chain(second)
}

/// Triangles of all faces with a tree of boxes.
pub struct SceneGeometry {
    triangles: Vec<RayTriangle>,
    tree: BoxTree,
    pub normals: Vec<DVec3>,
    /// The faces as the solvers see them.
    faces: Vec<MeshFace>,
    /// True for faces on which a front lies that precedes them.
    overlapped: Vec<bool>,
    extent: f64,
}

impl SceneGeometry {
    /// Creates the geometry of `scene`, of which `mesh` tells sheets and overlaps.
    pub fn new(scene: &Scene, mesh: &Mesh) -> Self {
        let faces = scene.faces.iter().enumerate();
        let [low, high] = scene.bounds();
        let extent = (high - low).max_element();
        let triangles: Vec<RayTriangle> = faces.flat_map(face_triangles).collect();
        let boxes: Vec<_> = triangles.iter().map(RayTriangle::bounds).collect();
        Self {
            tree: BoxTree::new(&boxes, extent),
            triangles,
            normals: scene.faces.iter().map(|f| f.vector_area().normalize()).collect(),
            faces: mesh.faces.clone(),
            overlapped: mesh.find_overlapped(),
            extent,
        }
    }

    /// Returns the front that a ray from `from` meets, and true if it meets a back there or before: front and back at one
    /// position are a sheet, or a body at a wall, seen from the room or from inside the body.
    pub fn trace_ray(&self, from: &SurfacePoint, along: DVec3) -> (Option<SurfacePoint>, bool) {
        let origin = self.ray_origin(from);
        let same = COINCIDENCE_TOLERANCE * self.extent;
        let (mut front, mut back, mut end) = (None, f64::INFINITY, f64::INFINITY);
        self.tree.visit_boxes(origin, along, &mut end, |k, end| {
            let triangle = &self.triangles[k];
            let met = triangle.intersect_ray(origin, along).filter(|(t, _)| *t > 0.0);
            let Some((t, is_front)) = met.filter(|_| triangle.face != from.face) else {
                return;
            };
            if !is_front {
                // Of a sheet's two sides the ray meets only the front.
                if self.faces[triangle.face].two_sided {
                    return;
                }
                back = t.min(back);
            } else if front.is_none_or(|(other, nearest)| {
                t < nearest - same || (t < nearest + same && self.faces[triangle.face].precedes(&self.faces[other]))
            }) {
                front = Some((triangle.face, t));
            }
            *end = end.min(t + same);
        });
        match front {
            Some((face, t)) if t < back + same => {
                let position = origin + along * t;
                (Some(SurfacePoint { face, position }), back < t + same)
            }
            _ => (None, back.is_finite()),
        }
    }

    /// True if a point lies under a front that precedes its own.
    pub fn is_under_front(&self, at: &SurfacePoint) -> bool {
        let is_near = |p: DVec3| p.distance(at.position) <= RAY_ORIGIN_OFFSET * self.extent;
        let met = || self.trace_ray(at, -self.normals[at.face]).0;
        self.overlapped[at.face]
            && met().is_some_and(|over| is_near(over.position) && self.faces[over.face].precedes(&self.faces[at.face]))
    }

    /// True if a point lies inside a body with a side on a wall, which light would enter because wall and side look
    /// like the two sides of a sheet. Then some of the directions (z along the normal) meet both, others a back alone,
    /// and none a front alone or nothing.
    pub fn is_within(&self, at: &SurfacePoint, directions: &[DVec3]) -> bool {
        let (x, y) = self.normals[at.face].any_orthonormal_pair();
        let frame = DMat3::from_cols(x, y, self.normals[at.face]);
        let (mut backs, mut both) = (false, false);
        for direction in directions {
            match self.trace_ray(at, frame * *direction) {
                (_, false) => return false,
                (None, true) => backs = true,
                (Some(_), true) => both = true,
            }
        }
        backs && both
    }

    /// True if a face lies between two points.
    pub fn is_occluded(&self, from: &SurfacePoint, to: &SurfacePoint) -> bool {
        let origin = self.ray_origin(from);
        let along = to.position - origin;
        let end = 1.0 - COINCIDENCE_TOLERANCE * self.extent / along.length();
        let (mut hidden, mut before) = (false, end);
        self.tree.visit_boxes(origin, along, &mut before, |k, before| {
            let triangle = &self.triangles[k];
            let other = triangle.face != from.face && triangle.face != to.face;
            let met = triangle.intersect_ray(origin, along);
            if other && met.is_some_and(|(t, _)| t > 0.0 && t < end) {
                hidden = true;
                // Stops the traversal.
                *before = f64::NEG_INFINITY;
            }
        });
        hidden
    }

    /// Returns G of two points that see each other; 0 if one shows its back.
    pub fn geometry_kernel(&self, a: &SurfacePoint, b: &SurfacePoint) -> f64 {
        let r = b.position - a.position;
        let cosines = [(a, r), (b, -r)].map(|(p, r)| self.normals[p.face].dot(r).max(0.0));
        cosines[0] * cosines[1] / (PI * r.length_squared().powi(2))
    }

    fn ray_origin(&self, from: &SurfacePoint) -> DVec3 {
        from.position + self.normals[from.face] * (RAY_ORIGIN_OFFSET * self.extent)
    }
}

/// Samples points on lamps by power.
pub struct LampSampler {
    triangles: Vec<RayTriangle>,
    /// Cumulative power up to and including each triangle.
    cumulative_power: Vec<f64>,
}

impl LampSampler {
    pub fn new(scene: &Scene) -> Self {
        let faces = scene.faces.iter().enumerate();
        let lamps = faces.filter(|(_, face)| face.emission.max_element() > 0.0);
        let triangles: Vec<RayTriangle> = lamps.flat_map(face_triangles).collect();
        let mut sum = 0.0;
        let power = triangles.iter().map(|triangle| {
            let emission = scene.faces[triangle.face].emission.as_dvec3();
            sum += triangle.area() * emission.element_sum();
            sum
        });
        Self {
            cumulative_power: power.collect(),
            triangles,
        }
    }

    /// Samples a point by three numbers within 0…1; none without lamps.
    pub fn sample_point(&self, which: f64, at: DVec2) -> Option<SurfacePoint> {
        let which = which * self.cumulative_power.last()?;
        let k = self.cumulative_power.partition_point(|power| *power <= which);
        let triangle = self.triangles.get(k)?;
        Some(SurfacePoint {
            face: triangle.face,
            position: triangle.point_at(at),
        })
    }

    /// Returns the density per area of a point with this emission.
    pub fn area_density(&self, emission: DVec3) -> f64 {
        self.cumulative_power
            .last()
            .map_or(0.0, |all| emission.element_sum() / all)
    }
}
