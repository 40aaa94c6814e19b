//! Link from a patch to a texel, the share of the patch's radiosity that the texel receives: the form factor
//! times the visible part of the patch, from S pairs of points on the two. [`super::lanes`] makes most links by rays;
//! this is their scalar reference, and makes those of item buffers and the baselines of a relight.
//!
//! ```text
//! w_ji = F(texel j → patch i) · Σ_s g_s V(p_s, q_s) / (o_i Σ_s g_s)
//! ```
//! p_s on the texel, q_s on the patch; g_s, the disc factor of 1/S of the patch at q_s, weighs a
//! point by the light that comes from there. Pairs with p_s behind the patch are left out of both sums. Where a body stands on the patch V = 0: all its light
//! leaves from its open share o_i. V = 0, too, for a point below the texel's horizon (S > 1).

use common::constants::{CONTACT_DISTANCE, NEAR_POINTS_PER_SIDE};
use common::form_factor::{FormFactor, Shooter, form_factor, is_far, point_weight};
use common::mesh::{Cover, Mesh, Patch, far_distance};
use common::rays::LineOfSight;
use common::sampling::near_point_uv;
use common::shooting::{DepositRule, SubtractedLink};
use common::texel_point::{point_on_texel, texel_point};
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

/// Baseline of a texel of the room, with which its link is compared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Baseline {
    /// Part that is subtracted from its link.
    pub subtracted: f32,
    /// The link without the objects.
    pub before: f32,
}

impl Sums {
    /// Returns w_ji after all samples; `open` is the open share of the patch.
    pub fn link_weight(&self, open: f32) -> f32 {
        self.visible_factor(self.seen, open)
    }

    fn visible_factor(&self, seen: f32, open: f32) -> f32 {
        if seen <= 0.0 {
            return 0.0;
        }
        self.form_factor * (seen / (self.all * open))
    }

    /// Returns the baseline of texel `k` for a shot of a patch (the paper's Table 2, line 6, subtracts F): both parts
    /// are 0 if the texel is an object's, and `before` is 0 if the patch is.
    pub fn link_baseline(&self, mesh: &Mesh, rule: DepositRule, patch: &Patch, k: u32) -> Baseline {
        if mesh.is_object(mesh.texels[k as usize].face) {
            return Baseline::default();
        }
        let object = mesh.is_object(patch.face);
        let before = if object {
            0.0
        } else {
            self.visible_factor(self.before, patch.room_open_share)
        };
        let subtracted = if rule.captured || object {
            match rule.subtracted {
                SubtractedLink::Nothing => 0.0,
                SubtractedLink::Before => before,
                SubtractedLink::Unhidden => self.form_factor,
                SubtractedLink::All => self.link_weight(patch.open_share),
            }
        } else {
            0.0
        };
        Baseline { subtracted, before }
    }
}

/// Returns F of texel `k` and patch number `i` (Table 1, line 7): at the texel's centre, and where the patch
/// is near and has several sample points, the mean over [`NEAR_POINTS_PER_SIDE`](common::constants::NEAR_POINTS_PER_SIDE)² places of the texel.
pub fn texel_form_factor(mesh: &Mesh, kind: FormFactor, i: u32, k: u32) -> f32 {
    let (shooter, texel) = (&mesh.patches[i as usize].shooter, &mesh.texels[k as usize]);
    let normal = mesh.faces[texel.face as usize].normal;
    mean_over_texel(mesh, i, k, |p| form_factor(kind, shooter, p, normal, texel.area))
}

/// Returns the mean over texel `k` of a function of its points, at the points of [`texel_form_factor`]; 0 on the face of
/// patch number `i`.
pub fn mean_over_texel(mesh: &Mesh, i: u32, k: u32, value_at: impl Fn(Vec3) -> f32) -> f32 {
    let patch = &mesh.patches[i as usize];
    let texel = &mesh.texels[k as usize];
    if texel.face == patch.face {
        return 0.0;
    }
    let face = &mesh.faces[texel.face as usize];
    let reach = far_distance(patch, face);
    if mesh.samples == 1 || is_far(texel.position, patch.shooter.centre, reach) {
        return value_at(texel.position);
    }
    let mut sum = 0.0;
    for place in 0..NEAR_POINTS_PER_SIDE * NEAR_POINTS_PER_SIDE {
        let uv = near_point_uv(place, texel.kind);
        let p = point_on_texel(face, texel.kind, texel.lattice_corner, texel.area, uv);
        sum += value_at(p.truncate()) * p.w;
    }
    sum / (NEAR_POINTS_PER_SIDE * NEAR_POINTS_PER_SIDE) as f32
}

/// Adds sample `s` of texel `k` and patch number `i`, whose form factor is known; calls `sight` with the
/// points q and p only where light could arrive.
pub fn add_sample(mesh: &Mesh, i: u32, k: u32, s: u32, sums: &mut Sums, sight: impl Fn(Vec3, Vec3) -> LineOfSight) {
    if sums.form_factor <= 0.0 {
        return;
    }
    let patch = &mesh.patches[i as usize];
    let texel = &mesh.texels[k as usize];
    let q = mesh.patch_points[(i * mesh.samples + s) as usize];
    let p = texel_point(mesh, k, i, s);
    let normal = mesh.faces[texel.face as usize].normal;
    let shooter = Shooter {
        centre: q.position,
        ..patch.shooter
    };
    // p lies behind the patch.
    if patch.shooter.normal.dot(p.truncate() - q.position) <= CONTACT_DISTANCE {
        return;
    }
    let part = patch.shooter.area / mesh.samples as f32;
    let g = point_weight(&shooter, p.truncate(), normal, part, sums.form_factor) * (p.w * q.weight);
    sums.all += g;
    // From below the texel's horizon a ray would come through the texel's own face.
    let below = normal.dot(p.truncate() - q.position) >= CONTACT_DISTANCE;
    if q.cover == Cover::Room || (below && mesh.samples > 1) {
        return;
    }
    let sight = sight(q.position, p.truncate());
    if sight != LineOfSight::Blocked {
        sums.before += g;
    }
    if sight == LineOfSight::Clear && q.cover == Cover::Open {
        sums.seen += g;
    }
}

/// Returns the sums of texel `k` and patch number `i` over all samples.
pub fn link_texel(mesh: &Mesh, kind: FormFactor, i: u32, k: u32, sight: impl Fn(Vec3, Vec3) -> LineOfSight) -> Sums {
    let mut sums = Sums {
        form_factor: texel_form_factor(mesh, kind, i, k),
        ..Sums::default()
    };
    for s in 0..mesh.samples {
        add_sample(mesh, i, k, s, &mut sums, &sight);
    }
    sums
}
