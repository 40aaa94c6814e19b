//! Choice of the radiosity d that each patch shoots in a pass r ← r − α(d − ρ T d/A): Southwell, Chebyshev or
//! conjugate gradients. T d is the flux (W) that the patches receive from d, A their areas and α the step, which is 1
//! except in conjugate gradients. For every d and α, r is the unshot radiosity, so the choice changes the time and not
//! the solution. [`crate::passes`] runs the passes.

use crate::mesh::{Mesh, Patch, area_mean};
use crate::settings::Iteration;
use glam::{DVec3, Vec3};

/// Reflectance ρ that limits the step of conjugate gradients to 1/(1 − ρ); a longer step is replaced by 1.
const MAX_STEP_REFLECTANCE: f64 = 0.9999;
/// Largest reflectance in the Chebyshev polynomial: 16 roundings of f32, the precision of links, below 1.
const MAX_CHEBYSHEV_REFLECTANCE: f64 = 1.0 - 8.0 * f32::EPSILON as f64;
/// Maximum passes without progress before an iteration restarts.
const MAX_STALLED_PASSES: u32 = 4;

/// Unshot and shot radiosity of the patches, W/m² by channel.
pub struct PassState {
    /// Unshot radiosity r.
    pub residual: Vec<DVec3>,
    /// Radiosity that was shot so far: the sum of α d over the passes.
    pub shot: Vec<DVec3>,
    /// Area of each patch.
    pub areas: Vec<f64>,
    /// Mean reflectance of each patch.
    reflectance: Vec<DVec3>,
    /// The latest pass since the start or restart.
    last: Option<LatestPass>,
    /// Least unshot power after a pass.
    least_unshot: f64,
    /// Passes since then.
    stalled_passes: u32,
}

/// The latest pass.
struct LatestPass {
    /// Radiosity d that each patch shot, before the step.
    direction: Vec<DVec3>,
    /// Residual before it.
    residual: Vec<DVec3>,
    /// Σ r² A/ρ over the patches that took part.
    energy: DVec3,
    /// Factor of the Chebyshev recurrence.
    chebyshev: DVec3,
    /// Passes before it since the start or restart.
    passes: u32,
}

impl PassState {
    /// Makes the state before the first pass: r = E times the open share.
    pub fn new(mesh: &Mesh) -> Self {
        let mut residual = patch_means(mesh, |_, texel| mesh.texels[texel].emission);
        for (r, patch) in residual.iter_mut().zip(&mesh.patches) {
            *r *= f64::from(patch.open_share);
        }
        if mesh.texels.iter().any(|texel| texel.sky != Vec3::ZERO) {
            let outside = patch_means(mesh, |_, k| mesh.texels[k].reflectance * mesh.texels[k].sky);
            residual.iter_mut().zip(outside).for_each(|(r, outside)| *r += outside);
        }
        let areas = mesh.patches.iter().map(|c| f64::from(c.shooter.area));
        let mut state = Self {
            shot: vec![DVec3::ZERO; residual.len()],
            areas: areas.collect(),
            reflectance: patch_means(mesh, |_, texel| mesh.texels[texel].reflectance),
            residual,
            last: None,
            least_unshot: f64::INFINITY,
            stalled_passes: 0,
        };
        state.least_unshot = state.unshot_power();
        state
    }

    /// Restarts the iteration with the patches' total radiosity `light`: r is `light` less the radiosity
    /// that was shot.
    pub fn restart_from_light(&mut self, light: Vec<DVec3>) {
        let unshot = light.iter().zip(&self.shot).map(|(all, shot)| *all - *shot);
        self.residual = unshot.collect();
        (self.last, self.stalled_passes) = (None, 0);
        self.least_unshot = self.unshot_power();
    }

    /// Returns Σ|r|A over the channels of patch `k`.
    pub fn patch_power(&self, k: usize) -> f64 {
        self.residual[k].abs().element_sum() * self.areas[k]
    }

    /// Returns Σ|r|A over all patches.
    pub fn unshot_power(&self) -> f64 {
        (0..self.areas.len()).map(|k| self.patch_power(k)).sum()
    }

    /// Returns the radiosity that each patch shoots next; 0 for patches that do not take part.
    pub fn next_direction(&mut self, iteration: Iteration, taking_part: &[bool]) -> Vec<DVec3> {
        let mut direction: Vec<DVec3> = (self.residual.iter().zip(taking_part))
            .map(|(r, part)| if *part { *r } else { DVec3::ZERO })
            .collect();
        let energy = self.energy_product(&direction, &self.residual);
        let mut chebyshev = DVec3::ZERO;
        match iteration {
            Iteration::Southwell => keep_strongest(&mut direction, &self.areas, 1),
            Iteration::Chebyshev => chebyshev = self.chebyshev_direction(&mut direction),
            Iteration::Cg => self.conjugate_direction(&mut direction),
        }
        self.last = Some(LatestPass {
            direction: direction.clone(),
            residual: self.residual.clone(),
            energy,
            chebyshev,
            passes: self.last.as_ref().map_or(0, |last| last.passes + 1),
        });
        direction
    }

    /// Updates the state by the flux per patch that was `received` from `direction`.
    pub fn apply_pass(&mut self, iteration: Iteration, direction: &[DVec3], received: &[Vec3]) {
        let reflected = |k: usize| match self.areas[k] {
            area if area > 0.0 => self.reflectance[k] * received[k].as_dvec3() / area,
            _ => DVec3::ZERO,
        };
        let net: Vec<DVec3> = (0..direction.len()).map(|k| direction[k] - reflected(k)).collect();
        let step = match (&self.last, iteration) {
            (Some(last), Iteration::Cg) if last.passes > 0 => self.step_length(direction, &net),
            _ => DVec3::ONE,
        };
        for (k, (d, q)) in direction.iter().zip(&net).enumerate() {
            self.shot[k] += *d * step;
            self.residual[k] -= *q * step;
        }
        let unshot = self.unshot_power();
        self.stalled_passes += 1;
        if unshot < self.least_unshot {
            (self.least_unshot, self.stalled_passes) = (unshot, 0);
        } else if self.stalled_passes > MAX_STALLED_PASSES {
            // The links are too far from reciprocal: restart from the present residual.
            (self.last, self.stalled_passes) = (None, 0);
        }
    }

    /// Applies the Chebyshev semi-iteration for eigenvalues of ρF in −ρ…ρ (Saad 2003, algorithm 12.1 with
    /// θ = 1, δ = ρ) to `direction`. Returns the factor of its recurrence.
    fn chebyshev_direction(&self, direction: &mut [DVec3]) -> DVec3 {
        let largest = (self.reflectance.iter()).fold(DVec3::ZERO, |largest, r| largest.max(*r));
        let delta = largest.clamp(DVec3::splat(1e-3), DVec3::splat(MAX_CHEBYSHEV_REFLECTANCE));
        let Some(last) = &self.last else { return delta };
        let next = (2.0 / delta - last.chebyshev).recip();
        for (d, before) in direction.iter_mut().zip(&last.direction) {
            *d = next * last.chebyshev * *before + 2.0 * next / delta * *d;
        }
        next
    }

    /// Makes `direction` conjugate in the product Σ a b A/ρ, in which ρF is symmetric by reciprocity.
    /// The β of Polak & Ribière (1969) tolerates links that are not quite reciprocal. The first pass shoots r with
    /// step 1, so that patches that reflect nothing have nothing unshot after it. Conjugate gradients begin with the
    /// second pass, whose direction is r as well.
    fn conjugate_direction(&self, direction: &mut [DVec3]) {
        let Some(last) = self.last.as_ref().filter(|last| last.passes > 0) else {
            return;
        };
        let residuals = self.residual.iter().zip(&last.residual);
        let change: Vec<DVec3> = residuals.map(|(r, before)| *r - *before).collect();
        let beta = quotient_or_zero(self.energy_product(direction, &change), last.energy).max(DVec3::ZERO);
        for (d, before) in direction.iter_mut().zip(&last.direction) {
            *d += beta * *before;
        }
    }

    /// Returns the step along `direction` that minimises the error; 1 where there is none or it is too long.
    fn step_length(&self, direction: &[DVec3], net: &[DVec3]) -> DVec3 {
        let along = self.energy_product(direction, &self.residual);
        let step = quotient_or_zero(along, self.energy_product(direction, net));
        // No step above 0: no patch that reflects shoots in this channel, or the error has no minimum along it.
        DVec3::select(
            step.cmpgt(DVec3::ZERO) & step.cmplt(DVec3::splat(1.0 / (1.0 - MAX_STEP_REFLECTANCE))),
            step,
            DVec3::ONE,
        )
    }

    /// Returns Σ a b A/ρ by channel, over the patches with ρ > 0.
    fn energy_product(&self, a: &[DVec3], b: &[DVec3]) -> DVec3 {
        let terms = (0..a.len()).map(|k| {
            let rho = self.reflectance[k];
            let term = a[k] * b[k] * self.areas[k] / rho;
            DVec3::select(rho.cmpgt(DVec3::ZERO), term, DVec3::ZERO)
        });
        terms.sum()
    }
}

/// Returns the area-weighted mean over each patch's texels of a value of patch and texel.
pub fn patch_means(mesh: &Mesh, value: impl Fn(&Patch, usize) -> Vec3) -> Vec<DVec3> {
    let mean = |patch: &Patch| area_mean(patch.texels().map(|k| (value(patch, k), mesh.texels[k].area)));
    mesh.patches.iter().map(mean).collect()
}

/// Returns a/b by channel; 0 where b is not positive.
fn quotient_or_zero(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::select(b.cmpgt(DVec3::ZERO), a / b, DVec3::ZERO)
}

/// Keeps the `count` entries with the most power, the first of equals, and sets the others to 0.
pub fn keep_strongest(direction: &mut [DVec3], areas: &[f64], count: u64) {
    let power = |k: usize, d: &[DVec3]| d[k].abs().element_sum() * areas[k];
    let mut order: Vec<usize> = (0..direction.len()).filter(|k| direction[*k] != DVec3::ZERO).collect();
    if order.len() as u64 <= count {
        return;
    }
    let by_power = |a: &usize, b: &usize| (power(*b, direction).total_cmp(&power(*a, direction))).then(a.cmp(b));
    order.select_nth_unstable_by(count as usize, by_power);
    for k in order.split_off(count as usize) {
        direction[k] = DVec3::ZERO;
    }
}
