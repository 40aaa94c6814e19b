//! Iterates the linked system x = K(s + ρx): Neumann series, or GMRES (Saad & Schultz 1986) where reflectances are
//! high.

use crate::hierarchy::coarse::{CoarseNodes, StoredLink, add_fields, gather_over_links, sum_link_amounts};
use crate::hierarchy::linear_radiosity::LinearRadiosity;
use crate::hierarchy::tree::TexelTree;
use common::Result;
use glam::{DVec3, Vec3};

/// Bounces of the Neumann series before GMRES takes over; in the second half the power must fall at each bounce.
const MAX_NEUMANN_BOUNCES: usize = 24;
/// Basis vectors of GMRES before a restart.
const GMRES_BASIS_SIZE: usize = 32;
/// GMRES cycles.
const MAX_GMRES_CYCLES: usize = 8;
/// Largest ratio of the power that GMRES finds absorbed to the power that was shot. It is 1 at most where K does not gain;
/// a solution of a system that gains has much more, with either sign.
const MAX_ABSORBED_RATIO: f64 = 2.0;

/// The linked system and its source.
pub struct BounceIteration<'a> {
    /// Nodes.
    pub tree: &'a TexelTree,
    /// Receivers.
    pub coarse: &'a mut CoarseNodes,
    /// Links of each block.
    pub links: &'a [Vec<StoredLink>],
    /// s of every node.
    pub radiosity: Vec<LinearRadiosity>,
    /// Number of products with K.
    pub passes: u32,
}

/// The solution at each coarse node.
#[derive(Clone)]
pub struct BounceResult {
    /// H.
    pub received: Vec<Vec3>,
    /// Unshot radiosity.
    pub unshot: Vec<Vec3>,
    /// The tolerance is met.
    pub converged: bool,
}

impl BounceIteration<'_> {
    /// Iterates until the unshot power, with all its bounces, is the share `tolerance` of the first reflected power.
    /// Where the power grows, the sources' radiosity is made constant and the iteration starts again: then K cannot gain,
    /// whatever its links. What is not converged in the end is `unshot`.
    ///
    /// Errors: those of `go_on`, which is called before each bounce.
    pub fn iterate_until(&mut self, tolerance: f64, go_on: &mut dyn FnMut() -> Result<()>) -> Result<BounceResult> {
        let source = self.radiosity.clone();
        if let Some(result) = self.iterate_bounces(tolerance, go_on)? {
            return Ok(result);
        }
        self.make_radiosity_constant();
        self.radiosity = source;
        let result = self.iterate_bounces(tolerance, go_on)?;
        Ok(result.unwrap_or_else(|| self.no_light()))
    }

    /// Makes the radiosity of sources constant, and limits the sums of K's rows, by amount, to 1.
    fn make_radiosity_constant(&mut self) {
        self.coarse.constant_radiosity = true;
        let ones = vec![Vec3::ONE; self.coarse.node_count()];
        self.fit_radiosity(&ones);
        self.coarse.limit_gain(&sum_link_amounts(self.links, &self.radiosity));
    }

    /// Returns darkness, for light that is not finite.
    fn no_light(&self) -> BounceResult {
        let dark = vec![Vec3::ZERO; self.coarse.node_count()];
        BounceResult {
            received: dark.clone(),
            unshot: dark,
            converged: false,
        }
    }

    /// Sums the Neumann series and solves the rest by GMRES; none if the power is not finite, or if it grows although
    /// sources vary linearly.
    fn iterate_bounces(
        &mut self,
        tolerance: f64,
        go_on: &mut dyn FnMut() -> Result<()>,
    ) -> Result<Option<BounceResult>> {
        let mut received = self.gather_sources();
        let mut unshot = self.coarse.reflected_radiosity(&received);
        let first = self.coarse.total_power(&unshot);
        let (mut power, mut ratio) = (first, 0.0);
        for bounce in 0..MAX_NEUMANN_BOUNCES {
            // The unshot power counts with all its bounces: 1 + q + q² + …
            if power <= tolerance * first * (1.0 - ratio) {
                return Ok(Some(BounceResult {
                    received,
                    unshot,
                    converged: true,
                }));
            }
            go_on()?;
            let step = self.gather_reflected(&unshot);
            received = add_fields(&received, &step);
            unshot = self.coarse.reflected_radiosity(&step);
            let next = self.coarse.total_power(&unshot);
            // Every surface absorbs. Where K cannot gain, the power may still rise for a few bounces.
            let grows = bounce >= MAX_NEUMANN_BOUNCES / 2 && next >= power && !self.coarse.constant_radiosity;
            if grows || !next.is_finite() {
                return Ok(None);
            }
            ratio = (next / power).min(0.99);
            power = next;
        }
        let rest = self.solve_by_gmres(&unshot, tolerance * first, go_on)?;
        let absorbed = self.coarse.absorbed_power(&rest.received);
        let most = match self.coarse.constant_radiosity {
            true => f64::MAX,
            false => MAX_ABSORBED_RATIO * power,
        };
        if absorbed.is_nan() || absorbed > most {
            return Ok(None);
        }
        Ok(Some(BounceResult {
            received: add_fields(&received, &rest.received),
            ..rest
        }))
    }

    /// Returns K times the current radiosity of all sources.
    fn gather_sources(&mut self) -> Vec<Vec3> {
        self.passes += 1;
        self.coarse
            .received_irradiance(&gather_over_links(self.links, &self.radiosity))
    }

    /// Returns K·`unshot`.
    fn gather_reflected(&mut self, unshot: &[Vec3]) -> Vec<Vec3> {
        self.fit_radiosity(unshot);
        self.gather_sources()
    }

    /// Sets the radiosity of all sources from `values` of the coarse nodes.
    fn fit_radiosity(&mut self, values: &[Vec3]) {
        self.coarse.fit_sources(self.tree, values, &mut self.radiosity);
    }

    /// Solves (1 − Kρ) x = K·unshot by restarted GMRES, each channel by itself, until the reflected power of the
    /// residual is at most `enough` or falls no more.
    fn solve_by_gmres(
        &mut self,
        unshot: &[Vec3],
        enough: f64,
        go_on: &mut dyn FnMut() -> Result<()>,
    ) -> Result<BounceResult> {
        let b = to_f64(&self.gather_reflected(unshot));
        let mut x = vec![DVec3::ZERO; b.len()];
        let mut residual = b.clone();
        for _ in 0..MAX_GMRES_CYCLES {
            if self.reflected_power(&residual) <= enough {
                break;
            }
            let step = self.run_gmres_cycle(&residual, enough, go_on)?;
            let next: Vec<DVec3> = x.iter().zip(step).map(|(x, step)| *x + step).collect();
            let product = self.apply_operator(&next);
            let rest: Vec<DVec3> = b.iter().zip(product).map(|(b, own)| *b - own).collect();
            let falls = self.reflected_power(&rest) < self.reflected_power(&residual);
            if !falls {
                break;
            }
            (x, residual) = (next, rest);
        }
        Ok(BounceResult {
            converged: self.reflected_power(&residual) <= enough,
            received: to_f32(&x),
            unshot: self.coarse.reflected_radiosity(&to_f32(&residual)),
        })
    }

    /// Returns (1 − Kρ) x.
    fn apply_operator(&mut self, x: &[DVec3]) -> Vec<DVec3> {
        let reflected = self.coarse.reflected_radiosity(&to_f32(x));
        let gathered = self.gather_reflected(&reflected);
        x.iter()
            .zip(gathered)
            .map(|(x, gathered)| *x - gathered.as_dvec3())
            .collect()
    }

    fn reflected_power(&self, received: &[DVec3]) -> f64 {
        let reflected = self.coarse.reflected_radiosity(&to_f32(received));
        self.coarse.total_power(&reflected)
    }

    /// Returns the x of one Krylov basis that minimises the residual of `b`.
    fn run_gmres_cycle(
        &mut self,
        b: &[DVec3],
        enough: f64,
        go_on: &mut dyn FnMut() -> Result<()>,
    ) -> Result<Vec<DVec3>> {
        let length = channel_norm(b);
        let first = self.reflected_power(b);
        let mut basis = vec![scale_channels(b, inverse_or_zero(length))];
        let mut columns: Vec<Vec<DVec3>> = Vec::new();
        let mut rotations: Vec<[DVec3; 2]> = Vec::new();
        let mut right = vec![length];
        for j in 0..GMRES_BASIS_SIZE {
            go_on()?;
            let mut w = self.apply_operator(&basis[j]);
            let mut column = Vec::with_capacity(j + 2);
            for v in &basis {
                let h = channel_dot(&w, v);
                w = w.iter().zip(v).map(|(w, v)| *w - h * *v).collect();
                column.push(h);
            }
            let h = channel_norm(&w);
            basis.push(scale_channels(&w, inverse_or_zero(h)));
            column.push(h);
            for (i, [c, s]) in rotations.iter().enumerate() {
                let (above, below) = (column[i], column[i + 1]);
                column[i] = *c * above + *s * below;
                column[i + 1] = *c * below - *s * above;
            }
            let (above, below) = (column[j], column[j + 1]);
            let inverse = inverse_or_zero((above * above + below * below).map(f64::sqrt));
            let [c, s] = [above * inverse, below * inverse];
            column[j] = c * above + s * below;
            column.truncate(j + 1);
            columns.push(column);
            rotations.push([c, s]);
            right.push(-s * right[j]);
            right[j] *= c;
            let share = (right[j + 1].abs() * inverse_or_zero(length)).max_element();
            if share * first <= enough {
                break;
            }
        }
        let mut y = vec![DVec3::ZERO; columns.len()];
        for i in (0..columns.len()).rev() {
            let known: DVec3 = (i + 1..columns.len()).map(|k| columns[k][i] * y[k]).sum();
            y[i] = (right[i] - known) * inverse_or_zero(columns[i][i]);
        }
        let mut x = vec![DVec3::ZERO; b.len()];
        for (y, v) in y.iter().zip(&basis) {
            x = x.iter().zip(v).map(|(x, v)| *x + *y * *v).collect();
        }
        Ok(x)
    }
}

fn inverse_or_zero(v: DVec3) -> DVec3 {
    v.map(|v| if v == 0.0 { 0.0 } else { 1.0 / v })
}

fn channel_dot(a: &[DVec3], b: &[DVec3]) -> DVec3 {
    a.iter().zip(b).map(|(a, b)| *a * *b).sum()
}

fn channel_norm(a: &[DVec3]) -> DVec3 {
    channel_dot(a, a).map(f64::sqrt)
}

fn scale_channels(a: &[DVec3], by: DVec3) -> Vec<DVec3> {
    a.iter().map(|a| *a * by).collect()
}

fn to_f64(a: &[Vec3]) -> Vec<DVec3> {
    a.iter().map(|a| a.as_dvec3()).collect()
}

fn to_f32(a: &[DVec3]) -> Vec<Vec3> {
    a.iter().map(|a| a.as_vec3()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channel_without_light_has_no_inverse() {
        let found = inverse_or_zero(DVec3::new(4.0, 0.0, -0.5));
        assert_eq!(found, DVec3::new(0.25, 0.0, -2.0));
    }
}
