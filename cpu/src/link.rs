//! What a texel takes of a cell's light: the form factor times the part of the cell that it sees,
//! from S pairs of points on the two. Twin of `gpu/src/shaders/link.wgsl`.
//!
//! ```text
//! w_ji = 1/S Σ_s F(p_s → cell i) · Σ_s g_s V(p_s, q_s) / (o_i Σ_s g_s)
//! ```
//! p_s on the texel, q_s on the cell; g_s, the disc factor of a cell's S-th part at q_s, weighs a
//! point by the light that comes from there. Where a body stands on the cell V = 0: all its light
//! leaves from its open share o_i.

use crate::sampling::texel_point;
use common::form_factor::{FormFactor, Shooter, form_factor, weight};
use common::mesh::Mesh;
use glam::Vec3;

/// The sums over the samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// Σ F.
    pub form_factor: f32,
    /// Σ g·V.
    pub seen: f32,
    /// Σ g.
    pub all: f32,
}

impl Sums {
    /// w_ji after all `samples`, of a cell that is `open` to that share.
    pub fn link(&self, samples: u32, open: f32) -> f32 {
        if self.seen <= 0.0 {
            return 0.0;
        }
        self.form_factor / samples as f32 * (self.seen / (self.all * open))
    }
}

/// Adds sample `s` of texel `k` and cell number `i`; `visible` is asked, of the points q and p,
/// only where light could arrive.
pub fn sample(
    mesh: &Mesh,
    kind: FormFactor,
    i: u32,
    k: u32,
    s: u32,
    sums: &mut Sums,
    visible: impl Fn(Vec3, Vec3) -> bool,
) {
    let cell = &mesh.cells[i as usize];
    let texel = &mesh.texels[k as usize];
    if texel.face == cell.face {
        return;
    }
    let q = mesh.points[(i * mesh.samples + s) as usize];
    let p = texel_point(mesh, k, i, s);
    let normal = mesh.faces[texel.face as usize].normal;
    let shooter = Shooter {
        centre: q.truncate(),
        ..cell.shooter
    };
    let f = form_factor(kind, &shooter, p.truncate(), normal, texel.area);
    if f <= 0.0 {
        return;
    }
    let part = cell.shooter.area / mesh.samples as f32;
    let g = weight(&shooter, p.truncate(), normal, part, f) * (p.w * q.w.abs());
    sums.form_factor += f * p.w;
    sums.all += g;
    if q.w > 0.0 && visible(q.truncate(), p.truncate()) {
        sums.seen += g;
    }
}
