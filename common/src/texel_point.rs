//! Points of a texel.

use crate::mesh::{Mesh, MeshFace, Texel, TexelKind};
use crate::sampling::{fold_triangle, texel_uv};
use crate::texel::{first_texels, triangle_index};
use glam::{Vec3, Vec4};

/// Returns sample point `s` of texel `k` for a patch; w is the area that it represents, over the mean.
#[inline]
pub fn texel_point(mesh: &Mesh, k: u32, patch: u32, s: u32) -> Vec4 {
    let texel = &mesh.texels[k as usize];
    if mesh.samples == 1 {
        return texel.position.extend(1.0);
    }
    let face = &mesh.faces[texel.face as usize];
    let uv = texel_uv(s, k, patch);
    point_on_texel(face, texel.kind, texel.lattice_corner, texel.area, uv)
}

/// Returns point `uv` of the texel at `place`.
#[inline(always)]
pub fn point_on_texel(face: &MeshFace, kind: TexelKind, place: [u32; 2], area: f32, [mut u, mut v]: [f32; 2]) -> Vec4 {
    let [a, b, c, d] = face.corners;
    let (i, j) = (place[0] as f32, place[1] as f32);
    let (w, h) = (face.resolution[0] as f32, face.resolution[1] as f32);
    if kind != TexelKind::Quad {
        (u, v) = fold_triangle(u, v);
        if kind == TexelKind::Inverted {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        return (a + (b - a) * ((i + u) / w) + (c - a) * ((j + v) / h)).extend(1.0);
    }
    u = (i + u) / w;
    v = (j + v) / h;
    let low = a * (1.0 - u) + b * u;
    let high = d * (1.0 - u) + c * u;
    let along_u = (b - a) * (1.0 - v) + (c - d) * v;
    let along_v = (d - a) * (1.0 - u) + (c - b) * u;
    let normal: Vec3 = along_u.cross(along_v);
    let weight = normal.dot(normal).sqrt() / (w * h * area.max(1e-30));
    (low * (1.0 - v) + high * v).extend(weight)
}

/// Returns the outline of a texel; a triangle repeats its third corner.
pub fn texel_corners(mesh: &Mesh, texel: &Texel) -> [Vec3; 4] {
    let face = &mesh.faces[texel.face as usize];
    let uv = match texel.kind {
        TexelKind::Quad => [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        _ => [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 1.0]],
    };
    uv.map(|uv| point_on_texel(face, texel.kind, texel.lattice_corner, texel.area, uv).truncate())
}

/// A texel's or face's corners in mesh units, from which points are drawn evenly; a triangle repeats its third.
#[derive(Clone, Copy, Debug)]
pub struct SampledOutline {
    /// The corners.
    pub corners: [Vec3; 4],
    /// Its area.
    pub area: f32,
    /// Share of the area in the triangle of the first three corners.
    share: f32,
}

impl SampledOutline {
    /// Makes the outline of `corners`.
    pub fn new(corners: [Vec3; 4]) -> Self {
        let area = |p: Vec3, q: Vec3| (p - corners[0]).cross(q - corners[0]).length();
        let [one, other] = [1, 2].map(|k| area(corners[k], corners[k + 1]));
        let share = if other > 0.0 { one / (one + other) } else { 1.0 };
        Self {
            corners,
            area: 0.5 * (one + other),
            share,
        }
    }

    /// Maps u, v in 0…1 to a point; the map keeps ratios of areas.
    pub fn point_at(&self, [u, v]: [f32; 2]) -> Vec3 {
        let (c, share) = (&self.corners, self.share);
        let (u, p, q) = if u < share {
            (u / share, c[1], c[2])
        } else {
            ((u - share) / (1.0 - share), c[2], c[3])
        };
        // The square root makes the density uniform over a triangle.
        c[0] + ((p - c[0]) * (1.0 - v) + (q - c[0]) * v) * u.sqrt()
    }
}

/// The texels of a mesh, found by face and point.
pub struct TexelLookup<'a> {
    mesh: &'a Mesh,
    /// First texel of each face, in face order.
    first: Vec<usize>,
    /// The texel of each rank in face order.
    order: Vec<usize>,
}

impl<'a> TexelLookup<'a> {
    /// Sorts the texels of `mesh`.
    pub fn new(mesh: &'a Mesh) -> Self {
        let resolutions: Vec<[u32; 2]> = mesh.faces.iter().map(|face| face.resolution).collect();
        Self {
            mesh,
            first: first_texels(&resolutions),
            order: mesh.texels_in_face_order(),
        }
    }

    /// Returns the texel at `point` of face `f`.
    pub fn texel_at(&self, f: u32, point: Vec3) -> usize {
        let index = locate_texel(&self.mesh.faces[f as usize], point);
        self.order[self.first[f as usize] + index as usize]
    }
}

/// Steps of Newton's method in [`locate_texel`]; each squares the error, which starts at ½ at most.
const MAX_NEWTON_STEPS: usize = 5;

/// Returns the index in the face of the texel at `point` of its plane; outside its outline, of one near it.
pub fn locate_texel(face: &MeshFace, point: Vec3) -> u32 {
    let [w, h] = face.resolution;
    if w * h == 1 {
        return 0;
    }
    let [a, b, c, d] = face.corners;
    let step = |x: f32, n: u32| ((x.max(0.0) * n as f32) as u32).min(n - 1);
    let is_triangle = c == d;
    let (along, across) = (b - a, if is_triangle { c - a } else { d - a });
    let skew = if is_triangle { Vec3::ZERO } else { a - b + c - d };
    let (mut u, mut v) = (0.5, 0.5);
    let steps = if skew == Vec3::ZERO { 1 } else { MAX_NEWTON_STEPS };
    for _ in 0..steps {
        let off = point - a - along * u - across * v - skew * (u * v);
        let (du, dv) = least_squares_coordinates(along + skew * v, across + skew * u, off);
        (u, v) = (u + du, v + dv);
    }
    let (i, j) = (step(u, w), step(v, h));
    if !is_triangle {
        return j * w + i;
    }
    // Rounding may put a point outside.
    let j = j.min(w - 1 - i);
    let upright = u * w as f32 - i as f32 + (v * h as f32 - j as f32) < 1.0 || i + j + 1 >= w;
    triangle_index(h, i, j, upright)
}

/// Solves `off` = x·p + y·q for x and y in the sense of least squares.
fn least_squares_coordinates(p: Vec3, q: Vec3, off: Vec3) -> (f32, f32) {
    let (pp, pq, qq) = (p.dot(p), p.dot(q), q.dot(q));
    let (x, y) = (off.dot(p), off.dot(q));
    let scale = pp * qq - pq * pq;
    if scale > 0.0 {
        ((qq * x - pq * y) / scale, (pp * y - pq * x) / scale)
    } else {
        (0.0, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Face, Scene};
    use crate::texel::texel_outline;
    use glam::DVec3;

    /// Rows of sample points.
    const POINT_ROWS: usize = 128;

    fn faces() -> [Face; 3] {
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.5 * x - y);
        let skew = [p(0.0, 0.0), p(4.0, 0.5), p(3.0, 2.0), p(0.5, 1.0)];
        // Side by side: a face under another front would exchange no light.
        let straight = [p(6.0, 0.0), p(10.0, 0.5), p(11.0, 2.0), p(7.0, 1.5)];
        let triangle = [p(12.0, 0.0), p(16.0, 0.5), p(13.0, 3.0)];
        [
            Face::quad("skew", skew, Vec3::ZERO, Vec3::ONE),
            Face::quad("straight", straight, Vec3::ZERO, Vec3::ONE),
            Face::triangle("triangle", triangle, Vec3::ZERO, Vec3::ONE),
        ]
    }

    #[test]
    fn sampled_points_lie_in_their_texel_with_uniform_density() {
        let scene = Scene {
            name: "faces".into(),
            faces: faces().into(),
            ..Scene::default()
        };
        let mesh = Mesh::uniform(&scene, 7, 1).unwrap();
        for texel in &mesh.texels {
            let face = texel.face as usize;
            let (own, of) = (&mesh.faces[face], &scene.faces[face]);
            let outline = texel_outline(of, own.resolution, texel.index);
            let corners = SampledOutline::new(outline.padded_corners().map(|p| mesh.local_point(p).as_vec3()));
            let mut mean = Vec3::ZERO;
            for s in 0..4 * POINT_ROWS {
                let uv = [(s / 4) as f32 / POINT_ROWS as f32, (s % 4) as f32 / 4.0];
                let uv = [uv[0] + 0.5 / POINT_ROWS as f32, uv[1] + 0.125];
                let p = corners.point_at(uv);
                assert_eq!(locate_texel(own, p), texel.index, "{face} {uv:?}");
                mean += p / (4 * POINT_ROWS) as f32;
            }
            // Half a row may fall into the wrong one of the two triangles, whose centroids are at most 4/3
            // radii apart; the quadrature over rows of density √u is off by less than 1e-3.
            let bound = 4.0 / 3.0 * 0.5 / POINT_ROWS as f32 + 1e-3;
            let off = mean.distance(mesh.local_point(outline.centroid()).as_vec3());
            assert!(off < bound * own.texel_radius, "{face}: {off}");
        }
    }
}
