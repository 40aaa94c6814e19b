//! F of a texel and a cell, more closely than a solver can afford.

use common::form_factor::{FormFactor, Shooter, form_factor};
use common::mesh::{Mesh, MeshFace, Texel, TexelKind};
use common::sampling::outline_point;
use cpu::sampling::point;
use glam::Vec3;

/// Places along a side of the larger one, and of the smaller one.
const PLACES: u32 = 8;

/// The mean of Lambert's factor over places of the smaller of the two, seen from which the larger
/// one's edges and horizon are exact. From the cell it is turned about: A_j F_ji = A_i F_ij.
pub fn exact(mesh: &Mesh, i: u32, k: u32) -> f32 {
    let cell = &mesh.cells[i as usize];
    let texel = &mesh.texels[k as usize];
    let face = &mesh.faces[texel.face as usize];
    if texel.face == cell.face || texel.area <= 0.0 || cell.shooter.area <= 0.0 {
        return 0.0;
    }
    if cell.shooter.radius < face.texel_radius {
        let outline = outline(face, texel);
        let shares = cell.shooter.area / texel.area;
        return shares
            * mean(|uv| {
                let q = outline_point(&cell.shooter.corners, uv);
                q.w * polygon(&outline, q.truncate(), cell.shooter.normal)
            });
    }
    mean(|uv| {
        let p = point(face, texel.kind, texel.place, texel.area, uv);
        p.w * polygon(&cell.shooter, p.truncate(), face.normal)
    })
}

fn polygon(shooter: &Shooter, position: Vec3, normal: Vec3) -> f32 {
    form_factor(FormFactor::Polygon, shooter, position, normal, 0.0)
}

fn mean(of: impl Fn([f32; 2]) -> f32) -> f32 {
    let along = |k: u32| (k as f32 + 0.5) / PLACES as f32;
    let places = PLACES * PLACES;
    let sum: f32 = (0..places)
        .map(|place| of([along(place % PLACES), along(place / PLACES)]))
        .sum();
    sum / places as f32
}

/// The texel as if it shone.
fn outline(face: &MeshFace, texel: &Texel) -> Shooter {
    let at = |u: f32, v: f32| point(face, texel.kind, texel.place, texel.area, [u, v]).truncate();
    let corners = match texel.kind {
        TexelKind::Quad => [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)],
        _ => [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(0.0, 1.0)],
    };
    Shooter {
        centre: texel.position,
        normal: face.normal,
        area: texel.area,
        corners,
        radius: face.texel_radius,
    }
}
