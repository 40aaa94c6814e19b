//! The points of a texel. Twin of `gpu/src/shaders/texel_point.wgsl`.

use common::mesh::{Mesh, MeshFace, TexelKind};
use common::sampling::{fold, texel_uv};
use glam::{Vec3, Vec4};

/// Point `s` of texel `k` as `cell` sees it; w is the area that it stands for over the mean.
pub fn texel_point(mesh: &Mesh, k: u32, cell: u32, s: u32) -> Vec4 {
    let texel = &mesh.texels[k as usize];
    if mesh.samples == 1 {
        return texel.position.extend(1.0);
    }
    let face = &mesh.faces[texel.face as usize];
    let uv = texel_uv(s, k, cell);
    point(face, texel.kind, texel.place, texel.area, uv)
}

/// Point `uv` of the texel at `place`.
#[inline(always)]
pub fn point(
    face: &MeshFace,
    kind: TexelKind,
    place: [u32; 2],
    area: f32,
    [mut u, mut v]: [f32; 2],
) -> Vec4 {
    let [a, b, c, d] = face.corners;
    let (i, j) = (place[0] as f32, place[1] as f32);
    let (w, h) = (face.resolution[0] as f32, face.resolution[1] as f32);
    if kind != TexelKind::Quad {
        (u, v) = fold(u, v);
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
