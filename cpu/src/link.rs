//! What a texel takes of a cell's light: the form factor times the part of the cell that it sees,
//! from S pairs of points on the two. Twin of `gpu/src/shaders/link.wgsl`.
//!
//! ```text
//! w_ji = 1/S Σ_s F(p_s → cell i) · Σ_s g_s V(p_s, q_s) / (o_i Σ_s g_s)
//! ```
//! p_s on the texel, q_s on the cell; g_s, the disc factor of a cell's S-th part at q_s, weighs a
//! point by the light that comes from there. Where a body stands on the cell V = 0: all its light
//! leaves from its open share o_i.

use crate::rays::Sight;
use crate::sampling::texel_point;
use common::form_factor::{FormFactor, Shooter, form_factor, weight};
use common::mesh::{Cell, Cover, Mesh};
use common::shooting::{Had, Rule};
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
    /// Σ g·V before the objects came.
    pub before: f32,
}

/// What a texel of the room had of a shot, by which its link is compared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Past {
    /// What is subtracted from its link.
    pub had: f32,
    /// The link without the objects.
    pub before: f32,
}

impl Sums {
    /// w_ji after all `samples`, of a cell that is `open` to that share.
    pub fn link(&self, samples: u32, open: f32) -> f32 {
        self.share(samples, self.seen, open)
    }

    fn share(&self, samples: u32, seen: f32, open: f32) -> f32 {
        if seen <= 0.0 {
            return 0.0;
        }
        self.form_factor / samples as f32 * (seen / (self.all * open))
    }

    /// What texel `k` had of a shot of `cell`; nothing where one of them is an object's.
    pub fn past(&self, mesh: &Mesh, rule: Rule, cell: &Cell, k: u32) -> Past {
        if mesh.is_object(mesh.texels[k as usize].face) {
            return Past::default();
        }
        let object = mesh.is_object(cell.face);
        let before = if object {
            0.0
        } else {
            self.share(mesh.samples, self.before, cell.open_before)
        };
        let had = if rule.captured || object {
            match rule.had {
                Had::Nothing => 0.0,
                Had::Before => before,
                Had::Unhidden => self.form_factor / mesh.samples as f32,
                Had::All => self.link(mesh.samples, cell.open),
            }
        } else {
            0.0
        };
        Past { had, before }
    }
}

/// Adds sample `s` of texel `k` and cell number `i`; `sight` is asked, of the points q and p,
/// only where light could arrive.
pub fn sample(
    mesh: &Mesh,
    kind: FormFactor,
    i: u32,
    k: u32,
    s: u32,
    sums: &mut Sums,
    sight: impl Fn(Vec3, Vec3) -> Sight,
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
        centre: q.position,
        ..cell.shooter
    };
    let f = form_factor(kind, &shooter, p.truncate(), normal, texel.area);
    if f <= 0.0 {
        return;
    }
    let part = cell.shooter.area / mesh.samples as f32;
    let g = weight(&shooter, p.truncate(), normal, part, f) * (p.w * q.weight);
    sums.form_factor += f * p.w;
    sums.all += g;
    if q.cover == Cover::Room {
        return;
    }
    let sight = sight(q.position, p.truncate());
    if sight != Sight::Blocked {
        sums.before += g;
    }
    if sight == Sight::Clear && q.cover == Cover::Open {
        sums.seen += g;
    }
}
