//! What wrong visibilities could do to the answer: the bound of the verdict on radiosity, worked
//! out from the scene's own silhouettes.
//!
//! D_ik is what texel k's link to cell i would change by, were every sample of the pair that lies
//! within reach of a silhouette judged the other way. With w' = w ± D and u = what cells have shot,
//!
//! ```text
//! B' − B = (I − ρT')⁻¹ ρ (w' − w) u      |B' − B| ≤ (I − ρ(T + D))⁻¹ ρ D |u|
//! ```
//! element by element, since nothing here is negative. What a run leaves unshot, r, could still
//! bring (I − ρT)⁻¹ρ T r. No constant of it is chosen.

use super::difference::{channels, reflected, worst};
use super::linked::Links;
use crate::judge::comparison::Difference;
use common::mesh::{Mesh, Texel};
use common::shooting::{Field, Run};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// What is left to carry when it is thought to be all, as a share of what there was.
const CARRIED: f64 = 1e-4;
/// Rounds after which light in doubt is taken to have no limit: walls of ρ = 0.99 need 920.
const ROUNDS: usize = 2000;

/// The links of the CPU, and what each could be wrong by.
pub struct Doubt<'a> {
    mesh: &'a Mesh,
    links: &'a Links,
    conserve: bool,
    /// D as shots scale it; an empty row where nothing is in doubt.
    wrong: Vec<Vec<f32>>,
    /// What cell c takes of what cell i shoots, by w + D.
    taken: Vec<Vec<f64>>,
}

impl<'a> Doubt<'a> {
    /// `rows` are what the CPU's links could be wrong by; empty ones are right.
    pub fn new(mesh: &'a Mesh, links: &'a Links, rows: Vec<Vec<f32>>, conserve: bool) -> Self {
        let wrong: Vec<Vec<f32>> = (rows.into_par_iter().enumerate())
            .map(|(i, row)| scaled(mesh, links, row, conserve, i))
            .collect();
        let mut doubt = Self {
            mesh,
            links,
            conserve,
            wrong,
            taken: Vec::new(),
        };
        doubt.taken = (0..mesh.cells.len())
            .into_par_iter()
            .map(|i| doubt.taken_of(i))
            .collect();
        doubt
    }

    fn taken_of(&self, i: usize) -> Vec<f64> {
        let of = |k: usize| self.most(i, k) * f64::from(self.mesh.texels[k].area);
        let cells = self.mesh.cells.iter();
        cells.map(|cell| cell.texels().map(of).sum()).collect()
    }

    /// (w + D) of cell `i` and texel `k`, scaled.
    fn most(&self, i: usize, k: usize) -> f64 {
        let scale = self.links.closures[i].scale(self.conserve);
        f64::from(self.links.rows[i][k] * scale) + self.wrong(i, k)
    }

    fn wrong(&self, i: usize, k: usize) -> f64 {
        self.wrong[i].get(k).copied().map_or(0.0, f64::from)
    }

    /// ρ Σ weight·x of every texel.
    fn reflected(&self, weight: impl Fn(usize, usize) -> f64 + Sync, shot: &[DVec3]) -> Vec<DVec3> {
        let texels = self.mesh.texels.par_iter().enumerate();
        let of = |(k, texel): (usize, &Texel)| {
            let each = (0..shot.len()).map(|i| shot[i].abs() * weight(i, k));
            each.sum::<DVec3>() * texel.reflectance.as_dvec3()
        };
        texels.map(of).collect()
    }

    /// What doubtful links could change in what each texel reflects of the shots of `run`; the shots
    /// themselves as they are where `fixed`, else with all that follows. None: there is no limit.
    pub fn of(&self, run: &Run, fixed: bool) -> Option<Vec<DVec3>> {
        let shot = shot(self.mesh, run);
        let mut direct = self.reflected(|i, k| self.wrong(i, k), &shot);
        if !fixed {
            let more = self.carried(&flux(self.mesh, |k| direct[k]))?;
            for (sum, more) in direct.iter_mut().zip(more) {
                *sum += more;
            }
        }
        Some(direct)
    }

    /// What the unshot light of `field` could still bring to each texel.
    pub fn left(&self, field: &Field) -> Option<Vec<DVec3>> {
        self.carried(&flux(self.mesh, |k| {
            field.residual[k].truncate().abs().as_dvec3()
        }))
    }

    /// What texels reflect in the end of a flux that cells have yet to shoot.
    fn carried(&self, flux: &[DVec3]) -> Option<Vec<DVec3>> {
        let cells = &self.mesh.cells;
        let start: f64 = flux.iter().map(|f| f.element_sum()).sum();
        let mut rest = flux.to_vec();
        let mut shot = vec![DVec3::ZERO; cells.len()];
        for _ in 0..ROUNDS {
            let now: Vec<DVec3> = (rest.iter().zip(cells))
                .map(|(flux, cell)| *flux / f64::from(cell.shooter.area).max(f64::MIN_POSITIVE))
                .collect();
            for (sum, now) in shot.iter_mut().zip(&now) {
                *sum += *now;
            }
            rest = (0..cells.len())
                .into_par_iter()
                .map(|c| {
                    let taken: DVec3 = (0..cells.len()).map(|i| now[i] * self.taken[i][c]).sum();
                    let texels = self.mesh.texels[cells[c].texels()].iter();
                    let most = texels.fold(Vec3::ZERO, |most, t| most.max(t.reflectance));
                    taken * most.as_dvec3()
                })
                .collect();
            let left: f64 = rest.iter().map(|f| f.element_sum()).sum();
            if left <= CARRIED * start {
                return Some(self.reflected(|i, k| self.most(i, k), &shot));
            }
        }
        None
    }
}

/// D of cell `i` as a shot multiplies it. A scaled shot divides by ΣF, which the doubt moves as
/// well: s' = (1 − escaped) / (ΣF − ΣD) at most, and w's' − ws ≤ Ds' + w(s' − s).
fn scaled(mesh: &Mesh, links: &Links, doubt: Vec<f32>, conserve: bool, i: usize) -> Vec<f32> {
    if !conserve || doubt.is_empty() {
        return doubt;
    }
    let closure = links.closures[i];
    let area = mesh.cells[i].shooter.area;
    let moved: f32 = (doubt.iter().zip(&mesh.texels))
        .map(|(d, texel)| d * texel.area / area)
        .sum();
    let least = closure.form_factor_sum - moved;
    let most = if least > 0.0 {
        (1.0 - closure.escaped) / least
    } else {
        f32::INFINITY
    };
    let spread = most - closure.scale(true);
    // 0·∞ is nothing in doubt.
    let times = |x: f32, y: f32| if x > 0.0 { x * y } else { 0.0 };
    let wrong = |(d, w): (&f32, &f32)| times(*d, most) + times(*w, spread);
    doubt.iter().zip(&links.rows[i]).map(wrong).collect()
}

/// Radiosity that each cell has shot in all.
pub fn shot(mesh: &Mesh, run: &Run) -> Vec<DVec3> {
    let mut shot = vec![DVec3::ZERO; mesh.cells.len()];
    for s in &run.shots {
        let area = f64::from(mesh.cells[s.cell as usize].shooter.area);
        if area > 0.0 {
            shot[s.cell as usize] += Vec3::from(s.power).as_dvec3() / area;
        }
    }
    shot
}

/// Σ b·A of each cell.
fn flux(mesh: &Mesh, b: impl Fn(usize) -> DVec3) -> Vec<DVec3> {
    let of = |k: usize| b(k) * f64::from(mesh.texels[k].area);
    let cells = mesh.cells.iter();
    cells.map(|cell| cell.texels().map(of).sum()).collect()
}

/// The figures of a change by `parts` of each texel against `field`, all of it upward; without limit
/// where one of them has none.
pub fn difference(mesh: &Mesh, parts: &[Option<Vec<DVec3>>], field: &Field) -> Difference {
    let of =
        |k: usize| move |part: &Option<Vec<DVec3>>| part.as_ref().map_or(DVec3::INFINITY, |p| p[k]);
    let texels = (0..mesh.texels.len()).map(|k| {
        let b = reflected(mesh, field, k);
        let more = parts.iter().map(of(k)).sum::<DVec3>();
        (f64::from(mesh.texels[k].area), b + more, b)
    });
    // Without a limit ∞ − ∞ or ∞/∞ would read as NaN, and fail.
    let limit = |x: f64| if x.is_nan() { f64::INFINITY } else { x };
    worst(channels(texels).map(|next| Difference {
        relative_rms: limit(next.relative_rms),
        max_relative: limit(next.max_relative),
        bias: limit(next.bias),
    }))
}
