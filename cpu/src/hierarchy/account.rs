//! What a hierarchical solve did, as a run: each face has shot once, all that has left it.

use crate::hierarchy::solve::Outcome;
use crate::twin::escape::meets_front;
use crate::twin::texel_point::point;
use common::cover::{asked, open};
use common::escape::directions;
use common::mesh::{Cell, Mesh};
use common::rays::Rays;
use common::shooting::{Field, Run, Shot};
use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;

/// Rays of all faces that tell what escapes: a tenth of a second's work. Each face asks some.
const RAYS: usize = 1 << 17;
const FEWEST: usize = 32;
/// Points of a texel on which a body stands that are looked at for one that is open.
const TRIES: usize = 8;

/// The run of `outcome` on `mesh`, each of whose faces is one cell, looked at in some points.
pub fn run(mesh: &Mesh, outcome: &Outcome) -> Run {
    let mut powers = vec![DVec3::ZERO; mesh.cells.len()];
    let mut sent = Vec::with_capacity(mesh.texels.len());
    let (mut emitted, mut unshot, mut received) = (0.0, 0.0, 0.0);
    let mut field = Field {
        origin: "hierarchy".into(),
        radiosity: Vec::with_capacity(mesh.texels.len()),
        residual: outcome.residual.iter().map(|r| r.extend(0.0)).collect(),
        irradiance: outcome
            .irradiance
            .iter()
            .map(|h| h.extend(0.0))
            .collect::<Vec<Vec4>>(),
    };
    for (k, texel) in mesh.texels.iter().enumerate() {
        let area = f64::from(texel.area);
        let (h, r) = (outcome.irradiance[k], outcome.residual[k]);
        let reflected = texel.reflectance * h;
        field
            .radiosity
            .push((texel.emission + reflected).extend(0.0));
        let left = texel.emission * outcome.open[k] + reflected - r;
        sent.push(left.as_dvec3() * area);
        powers[texel.face as usize] += left.as_dvec3() * area;
        emitted += sum(texel.emission) * area;
        unshot += sum(r.abs()) * area;
        received += sum(h) * area;
    }
    let shot: f64 = powers.iter().map(|p| p.element_sum()).sum();
    let taken = if shot > 0.0 { received / shot } else { 0.0 };
    let escaped = escaped(mesh, &sent, &outcome.open);
    let cells = (0..mesh.cells.len()).filter(|k| powers[*k] != DVec3::ZERO);
    let shots: Vec<Shot> = cells
        .map(|k| Shot {
            cell: k as u32,
            power: powers[k].as_vec3().into(),
            form_factor_sum: taken as f32,
            escaped: escaped[k],
            unshot: unshot as f32,
        })
        .collect();
    Run {
        emitted: emitted as f32,
        converged: outcome.spent,
        stagnated: false,
        passes: outcome.passes,
        shooters: shots.len() as u64,
        shots,
        field,
    }
}

/// Each face is open as far as its texels are.
pub fn uncover(mesh: &mut Mesh, outcome: &Outcome) {
    let mut open = vec![[0.0; 2]; mesh.cells.len()];
    for (texel, share) in mesh.texels.iter().zip(&outcome.open) {
        let area = f64::from(texel.area);
        open[texel.face as usize][0] += area;
        open[texel.face as usize][1] += area * f64::from(*share);
    }
    for (cell, [all, open]) in mesh.cells.iter_mut().zip(open) {
        cell.open = if all > 0.0 { (open / all) as f32 } else { 0.0 };
    }
}

/// The share of what each face sends that meets no front. Its texels send what they have left, which may be
/// nothing just where the open is seen: above a lamp, or outside of a wall. A face asks as many rays as its
/// share of the power: of few large lamps among many small faces all hangs on these.
fn escaped(mesh: &Mesh, left: &[DVec3], shares: &[f32]) -> Vec<f32> {
    let sky = Sky {
        mesh,
        rays: Rays::new(mesh),
        asked: asked(),
        shares,
    };
    let directions = directions();
    let of = |left: &DVec3| left.abs().element_sum();
    let all: f64 = left.iter().map(of).sum();
    let lost = |cell: &Cell| {
        let sums = cell.texels().scan(0.0, |sum, k| {
            *sum += of(&left[k]);
            Some(*sum)
        });
        let sums: Vec<f64> = sums.collect();
        let power = sums.last().copied().unwrap_or(0.0);
        if power == 0.0 {
            return 0.0;
        }
        let count = ((RAYS as f64 * power / all) as usize).max(FEWEST);
        let strata = count.min(directions.len());
        let seen = (0..count).filter_map(|n| {
            let drawn = power * sequence(n, 0.618_033_988_749_895);
            let drawn = sums.partition_point(|sum| *sum <= drawn);
            let k = cell.texels().start + drawn.min(sums.len() - 1);
            // All strata in turn, or as many of them, evenly.
            let along = directions[n % strata * directions.len() / strata];
            sky.is_seen(k, n, along)
        });
        let seen: Vec<bool> = seen.collect();
        seen.iter().filter(|seen| **seen).count() as f32 / seen.len().max(1) as f32
    };
    mesh.cells.par_iter().map(lost).collect()
}

/// Where no front is.
struct Sky<'a> {
    mesh: &'a Mesh,
    rays: Rays,
    asked: Vec<Vec3>,
    /// The open share of each texel.
    shares: &'a [f32],
}

impl Sky<'_> {
    /// Whether it is seen from an open point of texel `k`, a new one for each `n`; none if a few tries find no
    /// such point.
    fn is_seen(&self, k: usize, n: usize, along: Vec3) -> Option<bool> {
        let texel = &self.mesh.texels[k];
        let face = &self.mesh.faces[texel.face as usize];
        let mut places = (TRIES * n..TRIES * (n + 1)).map(|n| {
            let uv = [0.754_877_666_246_693, 0.569_840_290_998_053];
            let uv = uv.map(|alpha| sequence(n, alpha) as f32);
            point(face, texel.kind, texel.place, texel.area, uv).truncate()
        });
        let faces = self.mesh.faces.len();
        let origin = places
            .find(|at| self.shares[k] == 1.0 || open(&self.rays, faces, face, *at, &self.asked))?;
        let bitangent = face.normal.cross(face.tangent);
        let direction = face.tangent * along.x + bitangent * along.y + face.normal * along.z;
        Some(!meets_front(&self.rays, face.sheet, origin, direction))
    }
}

fn sequence(k: usize, alpha: f64) -> f64 {
    (0.5 + alpha * k as f64).fract()
}

fn sum(light: Vec3) -> f64 {
    light.as_dvec3().element_sum()
}
