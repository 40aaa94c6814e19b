//! What a hierarchical solve did, as a run: each face has shot once, all that has left it.

use crate::hierarchy::solve::Outcome;
use crate::twin::escape::meets_front;
use common::escape::directions;
use common::mesh::{Cover, Mesh};
use common::rays::Rays;
use common::shooting::{Field, Run, Shot};
use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;

/// Rays of all faces that tell what escapes, where there are few: a tenth of a second's work. Each point
/// of a face asks two directions at least.
const RAYS: usize = 1 << 17;

/// The run of `outcome` on `mesh`, each of whose faces is one cell, looked at in some points.
pub fn run(mesh: &Mesh, outcome: &Outcome) -> Run {
    let mut powers = vec![DVec3::ZERO; mesh.cells.len()];
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
        powers[texel.face as usize] += left.as_dvec3() * area;
        emitted += sum(texel.emission) * area;
        unshot += sum(r.abs()) * area;
        received += sum(h) * area;
    }
    let shot: f64 = powers.iter().map(|p| p.element_sum()).sum();
    let taken = if shot > 0.0 { received / shot } else { 0.0 };
    let escaped = escaped(mesh, &powers);
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

/// The share of each shooter's cosine hemisphere that meets no front, from its open points. A face asks as
/// many rays as its share of the power: of few large lamps among many small faces all hangs on these.
fn escaped(mesh: &Mesh, powers: &[DVec3]) -> Vec<f32> {
    let rays = Rays::new(mesh);
    let all = directions();
    let of = |power: &DVec3| power.abs().element_sum();
    let whole: f64 = powers.iter().map(of).sum();
    let cells = mesh.cells.par_iter().enumerate();
    cells
        .map(|(k, cell)| {
            if powers[k] == DVec3::ZERO {
                return 0.0;
            }
            let face = &mesh.faces[cell.face as usize];
            let first = k * mesh.samples as usize;
            let points: Vec<Vec3> = mesh.points[first..first + mesh.samples as usize]
                .iter()
                .filter(|point| point.cover == Cover::Open)
                .map(|point| point.position)
                .collect();
            if points.is_empty() {
                return 0.0;
            }
            let own = RAYS as f64 * of(&powers[k]) / whole / points.len() as f64;
            let step = all.len() / (own as usize).clamp(2, all.len());
            let bitangent = face.normal.cross(face.tangent);
            let (mut lost, mut count) = (0, 0);
            for (n, origin) in points.iter().enumerate() {
                // Each point has strata of its own.
                for d in all.iter().skip((n * 7 + k) % step).step_by(step) {
                    let direction = face.tangent * d.x + bitangent * d.y + face.normal * d.z;
                    lost += usize::from(!meets_front(&rays, face.sheet, *origin, direction));
                    count += 1;
                }
            }
            lost as f32 / count as f32
        })
        .collect()
}

fn sum(light: Vec3) -> f64 {
    light.as_dvec3().element_sum()
}
