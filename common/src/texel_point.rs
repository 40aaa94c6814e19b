//! Points of a texel.

use crate::mesh::{Mesh, MeshFace, TexelKind};
use crate::sampling::{fold_triangle, texel_uv};
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
