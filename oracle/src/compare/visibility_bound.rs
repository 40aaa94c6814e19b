//! Bounds the error in radiosity that wrong visibilities near silhouettes can cause, for the criteria.
//!
//! D_ik is the change of texel k's link to patch i if every sample of the pair near a silhouette had the opposite
//! visibility. With w' = w ± D and u = the radiosity that patches have shot,
//!
//! ```text
//! B' − B = (I − ρT')⁻¹ ρ (w' − w) u      |B' − B| ≤ (I − ρ(T + D))⁻¹ ρ D |u|
//! ```
//! element by element, since all terms are non-negative. The unshot radiosity r of a run can still add
//! (I − ρT)⁻¹ρ T r. The bound has no adjustable constants.

use super::visibility::LinkRows;
use crate::diff::difference::Difference;
use crate::diff::difference::{channel_differences, reflected_radiosity, worst_channel};
use common::mesh::{Mesh, Texel};
use common::shooting::{RadiosityField, SolveRun};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Remaining share of the flux at which the propagation stops.
const MAX_REMAINING_SHARE: f64 = 1e-4;
/// Bounces after which the bound counts as infinite: walls of ρ = 0.99 need 920.
const MAX_BOUND_BOUNCES: usize = 2000;

/// Links of the CPU with a bound of each one's error.
pub struct VisibilityBound<'a> {
    mesh: &'a Mesh,
    links: &'a LinkRows,
    conserve: bool,
    /// D, scaled as the links are; an empty row stands for zeros.
    link_bounds: Vec<Vec<f32>>,
    /// Flux that patch c receives per radiosity of patch i, by w + D: row i, column c.
    patch_exchange: Vec<Vec<f64>>,
}

impl<'a> VisibilityBound<'a> {
    /// Creates the bound from the unscaled D of each patch's links; an empty row stands for zeros.
    pub fn new(mesh: &'a Mesh, links: &'a LinkRows, rows: Vec<Vec<f32>>, conserve: bool) -> Self {
        let link_bounds: Vec<Vec<f32>> = (rows.into_par_iter().enumerate())
            .map(|(i, row)| scale_bounds(mesh, links, row, conserve, i))
            .collect();
        let mut bound = Self {
            mesh,
            links,
            conserve,
            link_bounds,
            patch_exchange: Vec::new(),
        };
        bound.patch_exchange = (0..mesh.patches.len())
            .into_par_iter()
            .map(|i| bound.exchange_of(i))
            .collect();
        bound
    }

    fn exchange_of(&self, i: usize) -> Vec<f64> {
        let of = |k: usize| self.largest_link(i, k) * f64::from(self.mesh.texels[k].area);
        let patches = self.mesh.patches.iter();
        patches.map(|patch| patch.texels().map(of).sum()).collect()
    }

    /// Returns the scaled w + D of patch `i` and texel `k`.
    fn largest_link(&self, i: usize, k: usize) -> f64 {
        let scale = self.links.closures[i].link_scale(self.conserve);
        f64::from(self.links.rows[i][k] * scale) + self.link_bound(i, k)
    }

    fn link_bound(&self, i: usize, k: usize) -> f64 {
        self.link_bounds[i].get(k).copied().map_or(0.0, f64::from)
    }

    /// Returns ρ Σ weight·|shot| of every texel.
    fn reflect_shots(&self, weight: impl Fn(usize, usize) -> f64 + Sync, shot: &[DVec3]) -> Vec<DVec3> {
        let texels = self.mesh.texels.par_iter().enumerate();
        let of = |(k, texel): (usize, &Texel)| {
            let each = (0..shot.len()).map(|i| shot[i].abs() * weight(i, k));
            each.sum::<DVec3>() * texel.reflectance.as_dvec3()
        };
        texels.map(of).collect()
    }

    /// Returns the bound, per texel, of the change in reflected radiosity by the errors of the links; with `fixed`
    /// shots the direct change only, else with all bounces. None: unbounded.
    pub fn bound_of_links(&self, run: &SolveRun, fixed: bool) -> Option<Vec<DVec3>> {
        let shot = shot_radiosity(self.mesh, run);
        let mut direct = self.reflect_shots(|i, k| self.link_bound(i, k), &shot);
        if !fixed {
            let more = self.propagate_flux(&patch_flux(self.mesh, |k| direct[k]))?;
            for (sum, more) in direct.iter_mut().zip(more) {
                *sum += more;
            }
        }
        Some(direct)
    }

    /// Returns the bound, per texel, of the radiosity that the unshot light of `field` can still add.
    pub fn bound_of_unshot(&self, field: &RadiosityField) -> Option<Vec<DVec3>> {
        self.propagate_flux(&patch_flux(self.mesh, |k| {
            field.residual[k].truncate().abs().as_dvec3()
        }))
    }

    /// Returns the radiosity that texels finally reflect of a flux that patches have yet to shoot. None: unbounded.
    fn propagate_flux(&self, flux: &[DVec3]) -> Option<Vec<DVec3>> {
        let patches = &self.mesh.patches;
        let start: f64 = flux.iter().map(|f| f.element_sum()).sum();
        let mut unshot = flux.to_vec();
        let mut shot = vec![DVec3::ZERO; patches.len()];
        for _ in 0..MAX_BOUND_BOUNCES {
            let radiosity: Vec<DVec3> = (unshot.iter().zip(patches))
                .map(|(flux, patch)| *flux / f64::from(patch.shooter.area).max(f64::MIN_POSITIVE))
                .collect();
            for (sum, radiosity) in shot.iter_mut().zip(&radiosity) {
                *sum += *radiosity;
            }
            unshot = (0..patches.len())
                .into_par_iter()
                .map(|c| {
                    let received: DVec3 = (0..patches.len())
                        .map(|i| radiosity[i] * self.patch_exchange[i][c])
                        .sum();
                    let texels = self.mesh.texels[patches[c].texels()].iter();
                    let reflectance = texels.fold(Vec3::ZERO, |largest, t| largest.max(t.reflectance));
                    received * reflectance.as_dvec3()
                })
                .collect();
            let remaining: f64 = unshot.iter().map(|f| f.element_sum()).sum();
            if remaining <= MAX_REMAINING_SHARE * start {
                return Some(self.reflect_shots(|i, k| self.largest_link(i, k), &shot));
            }
        }
        None
    }
}

/// Scales D of patch `i` as a shot scales its links. A conserving shot divides by ΣF, which D changes too:
/// s' ≤ (1 − escaped) / (ΣF − ΣD), and w's' − ws ≤ Ds' + w(s' − s).
fn scale_bounds(mesh: &Mesh, links: &LinkRows, bounds: Vec<f32>, conserve: bool, i: usize) -> Vec<f32> {
    if !conserve || bounds.is_empty() {
        return bounds;
    }
    let closure = links.closures[i];
    let area = mesh.patches[i].shooter.area;
    let sum_of_bounds: f32 = (bounds.iter().zip(&mesh.texels))
        .map(|(d, texel)| d * texel.area / area)
        .sum();
    let smallest_sum = closure.form_factor_sum - sum_of_bounds;
    let largest_scale = if smallest_sum > 0.0 {
        (1.0 - closure.escaped) / smallest_sum
    } else {
        f32::INFINITY
    };
    let spread = largest_scale - closure.link_scale(true);
    // 0·∞ counts as 0.
    let times = |x: f32, y: f32| if x > 0.0 { x * y } else { 0.0 };
    let scale_bound = |(d, w): (&f32, &f32)| times(*d, largest_scale) + times(*w, spread);
    bounds.iter().zip(&links.rows[i]).map(scale_bound).collect()
}

/// Returns the total radiosity that each patch has shot.
pub fn shot_radiosity(mesh: &Mesh, run: &SolveRun) -> Vec<DVec3> {
    let mut shot = vec![DVec3::ZERO; mesh.patches.len()];
    for s in &run.shots {
        let area = f64::from(mesh.patches[s.patch as usize].shooter.area);
        if area > 0.0 {
            shot[s.patch as usize] += Vec3::from(s.power).as_dvec3() / area;
        }
    }
    shot
}

/// Returns Σ b·A of each patch.
fn patch_flux(mesh: &Mesh, b: impl Fn(usize) -> DVec3) -> Vec<DVec3> {
    let of = |k: usize| b(k) * f64::from(mesh.texels[k].area);
    let patches = mesh.patches.iter();
    patches.map(|patch| patch.texels().map(of).sum()).collect()
}

/// Returns the difference from `field` if every texel gains the sum of `parts`; infinite if a part is unbounded.
pub fn bound_difference(mesh: &Mesh, parts: &[Option<Vec<DVec3>>], field: &RadiosityField) -> Difference {
    let of = |k: usize| move |part: &Option<Vec<DVec3>>| part.as_ref().map_or(DVec3::INFINITY, |p| p[k]);
    let texels = (0..mesh.texels.len()).map(|k| {
        let b = reflected_radiosity(mesh, field, k);
        let more = parts.iter().map(of(k)).sum::<DVec3>();
        (f64::from(mesh.texels[k].area), b + more, b)
    });
    // An unbounded part gives ∞ − ∞ or ∞/∞, that is NaN, which would fail every criterion.
    let limit = |x: f64| if x.is_nan() { f64::INFINITY } else { x };
    worst_channel(channel_differences(texels).map(|channel| Difference {
        relative_rms: limit(channel.relative_rms),
        max_relative: limit(channel.max_relative),
        bias: limit(channel.bias),
    }))
}
