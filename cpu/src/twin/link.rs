//! The share of a cell's radiosity that a texel receives: the form factor times the part of the cell
//! that it sees, from S pairs of points on the two. Twin of `gpu/src/shaders/link.wgsl`.
//!
//! ```text
//! w_ji = F(texel j → cell i) · Σ_s g_s V(p_s, q_s) / (o_i Σ_s g_s)
//! ```
//! p_s on the texel, q_s on the cell; g_s, the disc factor of a cell's S-th part at q_s, weighs a
//! point by the light that comes from there. Where a body stands on the cell V = 0: all its light
//! leaves from its open share o_i. V = 0, too, for a point below the texel's horizon (S > 1).

use crate::twin::texel_point::{point, texel_point};
use common::constants::{CONTACT, NEAR};
use common::form_factor::{FormFactor, Shooter, far, form_factor, weight};
use common::mesh::{Cell, Cover, Mesh, reach};
use common::rays::Sight;
use common::sampling::near_uv;
use common::shooting::{Rule, Subtracted};
use glam::Vec3;

/// The sums over the samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// F, before the samples.
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
pub struct Baseline {
    /// What is subtracted from its link.
    pub subtracted: f32,
    /// The link without the objects.
    pub before: f32,
}

impl Sums {
    /// w_ji after all samples, of a cell that is `open` to that share.
    pub fn link(&self, open: f32) -> f32 {
        self.share(self.seen, open)
    }

    fn share(&self, seen: f32, open: f32) -> f32 {
        if seen <= 0.0 {
            return 0.0;
        }
        self.form_factor * (seen / (self.all * open))
    }

    /// What texel `k` had of a shot of `cell` (Table 2, line 6, takes F); nothing where one of them
    /// is an object's.
    pub fn baseline(&self, mesh: &Mesh, rule: Rule, cell: &Cell, k: u32) -> Baseline {
        if mesh.is_object(mesh.texels[k as usize].face) {
            return Baseline::default();
        }
        let object = mesh.is_object(cell.face);
        let before = if object {
            0.0
        } else {
            self.share(self.before, cell.open_before)
        };
        let subtracted = if rule.captured || object {
            match rule.subtracted {
                Subtracted::Nothing => 0.0,
                Subtracted::Before => before,
                Subtracted::Unhidden => self.form_factor,
                Subtracted::All => self.link(cell.open),
            }
        } else {
            0.0
        };
        Baseline { subtracted, before }
    }
}

/// F of texel `k` and cell number `i` (Table 1, line 7): from the texel's centre, and where the cell
/// is near and looked at in several points, the mean over [`NEAR`]² places of the texel.
pub fn factor(mesh: &Mesh, kind: FormFactor, i: u32, k: u32) -> f32 {
    let cell = &mesh.cells[i as usize];
    let texel = &mesh.texels[k as usize];
    if texel.face == cell.face {
        return 0.0;
    }
    let face = &mesh.faces[texel.face as usize];
    let reach = reach(cell, face);
    if mesh.samples == 1 || far(texel.position, cell.shooter.centre, reach) {
        return form_factor(kind, &cell.shooter, texel.position, face.normal, texel.area);
    }
    let mut sum = 0.0;
    for place in 0..NEAR * NEAR {
        let uv = near_uv(place, texel.kind);
        let p = point(face, texel.kind, texel.place, texel.area, uv);
        let f = form_factor(kind, &cell.shooter, p.truncate(), face.normal, texel.area);
        sum += f * p.w;
    }
    sum / (NEAR * NEAR) as f32
}

/// Adds sample `s` of texel `k` and cell number `i`, whose form factor is known; `sight` is asked,
/// of the points q and p, only where light could arrive.
pub fn sample(
    mesh: &Mesh,
    i: u32,
    k: u32,
    s: u32,
    sums: &mut Sums,
    sight: impl Fn(Vec3, Vec3) -> Sight,
) {
    if sums.form_factor <= 0.0 {
        return;
    }
    let cell = &mesh.cells[i as usize];
    let texel = &mesh.texels[k as usize];
    let q = mesh.points[(i * mesh.samples + s) as usize];
    let p = texel_point(mesh, k, i, s);
    let normal = mesh.faces[texel.face as usize].normal;
    let shooter = Shooter {
        centre: q.position,
        ..cell.shooter
    };
    // The texel reaches behind the cell.
    if cell.shooter.normal.dot(p.truncate() - q.position) <= CONTACT {
        return;
    }
    let part = cell.shooter.area / mesh.samples as f32;
    let g = weight(&shooter, p.truncate(), normal, part, sums.form_factor) * (p.w * q.weight);
    sums.all += g;
    // From below the texel's horizon a ray would come through the texel's own face.
    let below = normal.dot(p.truncate() - q.position) >= CONTACT;
    if q.cover == Cover::Room || (below && mesh.samples > 1) {
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
