//! Points of a texel.

use crate::mesh::{Mesh, MeshFace, TexelKind};
use crate::sampling::{fold_triangle, texel_uv};
use crate::texel::triangle_index;
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

/// Steps of Newton's method in [`texel_at`].
const MAX_NEWTON_STEPS: usize = 4;

/// Returns the index in the face of the texel at `point` of its plane; outside its outline, of one near it.
pub fn texel_at(face: &MeshFace, point: Vec3) -> u32 {
    let [a, b, c, d] = face.corners;
    let [w, h] = face.resolution;
    let from_corner = point - a;
    let along = |of: f32, n: u32| ((of * n as f32) as u32).min(n - 1);
    // Solves p = u·x + v·y in the face's plane.
    let solve = |p: Vec3, x: Vec3, y: Vec3| {
        let inverse = 1.0 / face.normal.dot(x.cross(y)).max(f32::MIN_POSITIVE);
        [
            face.normal.dot(p.cross(y)) * inverse,
            face.normal.dot(x.cross(p)) * inverse,
        ]
    };
    if c == d {
        let [u, v] = solve(from_corner, b - a, c - a).map(|x| x.clamp(0.0, 1.0));
        let (i, j) = (along(u, w), along(v, h));
        let i = i.min(h - 1 - j);
        let upright = u * w as f32 - i as f32 + (v * h as f32 - j as f32) <= 1.0 || i + j + 1 == h;
        return triangle_index(h, i, j, upright);
    }
    let skew = a - b + c - d;
    let [mut u, mut v] = solve(from_corner, b - a, d - a);
    for _ in 0..MAX_NEWTON_STEPS {
        if skew == Vec3::ZERO {
            break;
        }
        let at = (b - a) * u + (d - a) * v + skew * (u * v);
        let [du, dv] = solve(from_corner - at, b - a + skew * v, d - a + skew * u);
        (u, v) = ((u + du).clamp(0.0, 1.0), (v + dv).clamp(0.0, 1.0));
    }
    along(v, h) * w + along(u, w)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Face, Scene};
    use glam::DVec3;

    #[test]
    fn texel_at_points_of_a_texel_is_that_texel() {
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.3 * x - 0.2 * y);
        let black = Vec3::ZERO;
        let faces = [
            Face::quad("square", [p(0., 0.), p(1., 0.), p(1., 1.), p(0., 1.)], black, black),
            Face::quad("skewed", [p(0., 0.), p(3., 0.2), p(2., 1.), p(0.4, 1.5)], black, black),
            Face::triangle("triangle", [p(0., 0.), p(2., 0.), p(0.3, 1.)], black, black),
        ];
        for (face, side) in faces.iter().flat_map(|face| [1, 2, 5, 16].map(|side| (face, side))) {
            // By itself: of coinciding faces only the first has an area.
            let scene = Scene {
                faces: vec![face.clone()],
                ..Scene::default()
            };
            let mesh = Mesh::uniform(&scene, side, 1).unwrap();
            for texel in &mesh.texels {
                let face = &mesh.faces[texel.face as usize];
                // An inverted sub-triangle begins at the lattice's upper corner, and folds onto the lower half.
                for uv in [[0.3, 0.3], [0.05, 0.9], [0.9, 0.05], [0.02, 0.02], [0.45, 0.5]] {
                    let point = point_on_texel(face, texel.kind, texel.lattice_corner, texel.area, uv);
                    assert_eq!(texel_at(face, point.truncate()), texel.index, "{side} {texel:?} {uv:?}");
                }
            }
        }
    }
}
