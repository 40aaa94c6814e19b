//! Which cells shoot how much in a pass. All are choices of d in r ← r − α(d − ρ T d/A): whatever
//! d is, r stays what is unshot, so the choice decides the time and not the answer.

use crate::mesh::Mesh;
use crate::settings::Iteration;
use glam::{DVec3, Vec3};

/// Above this reflectance steps and guesses stop following.
const LARGEST: f64 = 0.9999;
/// Above this one Chebyshev's polynomial does: 16 roundings of f32, in which links are known, below 1.
const WHITEST: f64 = 1.0 - 8.0 * f32::EPSILON as f64;
/// Passes without progress after which an iteration starts anew.
const PATIENCE: u32 = 4;

/// What the cells have and have shot; r, S and d in W/m², by channel.
pub struct State {
    /// Unshot: r.
    pub residual: Vec<DVec3>,
    /// Shot so far: S.
    pub shot: Vec<DVec3>,
    /// Area of each cell.
    pub areas: Vec<f64>,
    reflectance: Vec<DVec3>,
    last: Option<Last>,
    /// The least that was unshot after a pass, and the passes since.
    least: f64,
    stalled: u32,
}

/// The latest pass.
struct Last {
    direction: Vec<DVec3>,
    /// Before it.
    residual: Vec<DVec3>,
    /// Σ r² A/ρ of those that took part.
    energy: DVec3,
    /// The factor of Chebyshev's recurrence.
    chebyshev: DVec3,
    /// Passes before it.
    passes: u32,
}

impl State {
    /// Before the first pass: r = E where no body buries it.
    pub fn new(mesh: &Mesh) -> Self {
        let mean = |value: &dyn Fn(usize) -> Vec3| -> Vec<DVec3> {
            let cells = mesh.cells.iter().map(|cell| {
                let (mut sum, mut area) = (DVec3::ZERO, 0.0);
                for k in cell.texels() {
                    let a = f64::from(mesh.texels[k].area);
                    sum += value(k).as_dvec3() * a;
                    area += a;
                }
                if area > 0.0 { sum / area } else { DVec3::ZERO }
            });
            cells.collect()
        };
        let mut residual = mean(&|k| mesh.texels[k].emission);
        for (r, cell) in residual.iter_mut().zip(&mesh.cells) {
            *r *= f64::from(cell.open);
        }
        let areas = mesh.cells.iter().map(|c| f64::from(c.shooter.area));
        let mut state = Self {
            shot: vec![DVec3::ZERO; residual.len()],
            areas: areas.collect(),
            reflectance: mean(&|k| mesh.texels[k].reflectance),
            residual,
            last: None,
            least: f64::INFINITY,
            stalled: 0,
        };
        state.least = state.unshot();
        state
    }

    /// Goes on from here: cells have all this `light`, and have shot what they have.
    pub fn start_again(&mut self, light: Vec<DVec3>) {
        let left = light.iter().zip(&self.shot).map(|(all, shot)| *all - *shot);
        self.residual = left.collect();
        (self.last, self.stalled) = (None, 0);
        self.least = self.unshot();
    }

    /// Σ|r|A over the channels of cell `k`.
    pub fn power(&self, k: usize) -> f64 {
        self.residual[k].abs().element_sum() * self.areas[k]
    }

    /// Σ|r|A over all cells.
    pub fn unshot(&self) -> f64 {
        (0..self.areas.len()).map(|k| self.power(k)).sum()
    }

    /// What every cell shoots next; nothing from those that do not take part.
    pub fn direction(&mut self, iteration: Iteration, taking_part: &[bool]) -> Vec<DVec3> {
        let mut direction: Vec<DVec3> = (self.residual.iter().zip(taking_part))
            .map(|(r, part)| if *part { *r } else { DVec3::ZERO })
            .collect();
        let energy = self.energy(&direction, &self.residual);
        let mut chebyshev = DVec3::ZERO;
        match iteration {
            Iteration::Southwell => strongest(&mut direction, &self.areas, 1),
            Iteration::Chebyshev => chebyshev = self.chebyshev(&mut direction),
            Iteration::Cg => self.conjugate(&mut direction),
        }
        self.last = Some(Last {
            direction: direction.clone(),
            residual: self.residual.clone(),
            energy,
            chebyshev,
            passes: self.last.as_ref().map_or(0, |last| last.passes + 1),
        });
        direction
    }

    /// Takes the flux per cell that `direction` sent.
    pub fn shoot(&mut self, iteration: Iteration, direction: &[DVec3], received: &[Vec3]) {
        let net: Vec<DVec3> = (0..direction.len())
            .map(|k| direction[k] - self.reflected(k, received[k]))
            .collect();
        let step = match (&self.last, iteration) {
            (Some(last), Iteration::Cg) if last.passes > 0 => self.step(direction, &net),
            _ => DVec3::ONE,
        };
        for (k, (d, q)) in direction.iter().zip(&net).enumerate() {
            self.shot[k] += *d * step;
            self.residual[k] -= *q * step;
        }
        let unshot = self.unshot();
        self.stalled += 1;
        if unshot < self.least {
            (self.least, self.stalled) = (unshot, 0);
        } else if self.stalled > PATIENCE {
            // Links too far from reciprocal: from here anew, with what every cell has.
            (self.last, self.stalled) = (None, 0);
        }
    }

    fn reflected(&self, k: usize, received: Vec3) -> DVec3 {
        if self.areas[k] > 0.0 {
            self.reflectance[k] * received.as_dvec3() / self.areas[k]
        } else {
            DVec3::ZERO
        }
    }

    /// Chebyshev's semi-iteration for eigenvalues of ρF in −ρ…ρ (Saad 2003, algorithm 12.1 with
    /// θ = 1, δ = ρ). The factor of its recurrence.
    fn chebyshev(&self, direction: &mut [DVec3]) -> DVec3 {
        let largest = (self.reflectance.iter()).fold(DVec3::ZERO, |most, r| most.max(*r));
        let delta = largest.clamp(DVec3::splat(1e-3), DVec3::splat(WHITEST));
        let Some(last) = &self.last else { return delta };
        let next = (2.0 / delta - last.chebyshev).recip();
        for (d, before) in direction.iter_mut().zip(&last.direction) {
            *d = next * last.chebyshev * *before + 2.0 * next / delta * *d;
        }
        next
    }

    /// Conjugate gradients in the product Σ a b A/ρ, in which ρF is symmetric by reciprocity;
    /// Polak and Ribière's β forgives links that are not quite. The first pass shoots r itself,
    /// so that cells that reflect nothing are done with.
    fn conjugate(&self, direction: &mut [DVec3]) {
        let Some(last) = self.last.as_ref().filter(|last| last.passes > 0) else {
            return;
        };
        let change: Vec<DVec3> = (self.residual.iter().zip(&last.residual))
            .map(|(r, before)| *r - *before)
            .collect();
        let beta = quotient(self.energy(direction, &change), last.energy).max(DVec3::ZERO);
        for (d, before) in direction.iter_mut().zip(&last.direction) {
            *d += beta * *before;
        }
    }

    /// How far along `direction` the error is least.
    fn step(&self, direction: &[DVec3], net: &[DVec3]) -> DVec3 {
        let (along, curvature) = (
            self.energy(direction, &self.residual),
            self.energy(direction, net),
        );
        let step = quotient(along, curvature);
        // Nothing that reflects shoots in this channel, or the links have no minimum there.
        DVec3::select(
            step.cmpgt(DVec3::ZERO) & step.cmplt(DVec3::splat(1.0 / (1.0 - LARGEST))),
            step,
            DVec3::ONE,
        )
    }

    /// Σ a b A/ρ by channel, over the cells that reflect it.
    fn energy(&self, a: &[DVec3], b: &[DVec3]) -> DVec3 {
        let terms = (0..a.len()).map(|k| {
            let rho = self.reflectance[k];
            let term = a[k] * b[k] * self.areas[k] / rho;
            DVec3::select(rho.cmpgt(DVec3::ZERO), term, DVec3::ZERO)
        });
        terms.sum()
    }
}

fn quotient(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::select(b.cmpgt(DVec3::ZERO), a / b, DVec3::ZERO)
}

/// Leaves the `most` entries with most power, the first of equals, and makes the others nothing.
pub fn strongest(direction: &mut [DVec3], areas: &[f64], most: u64) {
    let power = |k: usize, d: &[DVec3]| d[k].abs().element_sum() * areas[k];
    let mut order: Vec<usize> = (0..direction.len())
        .filter(|k| direction[*k] != DVec3::ZERO)
        .collect();
    if order.len() as u64 <= most {
        return;
    }
    let by_power = |a: &usize, b: &usize| {
        (power(*b, direction).total_cmp(&power(*a, direction))).then(a.cmp(b))
    };
    order.select_nth_unstable_by(most as usize, by_power);
    for k in order.split_off(most as usize) {
        direction[k] = DVec3::ZERO;
    }
}
