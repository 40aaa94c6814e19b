//! Coarse light made fine: all that is sent is gathered anew at every texel, and what differs from the
//! coarse light is sent over the kept links in turn (defect correction, Hackbusch 1981). In a narrow gap
//! coarse nodes tell little of that, so it is gathered as well, until it is little.

use crate::hierarchy::coarse::Kept;
use crate::hierarchy::descent::Receiving;
use crate::hierarchy::solve::{CORRECTED, FINE, Goal, sum};
use crate::hierarchy::state::{Solve, Spent};
use crate::hierarchy::world::{Watch, What};
use common::Result;
use glam::Vec3;

/// Rounds at most.
const ROUNDS: usize = 12;
/// A correction of so much of the error that is asked for need not be gathered.
const LITTLE: f32 = 0.25;
/// Nor one of so much of the light: then links make up more than walls absorb.
const ALL: f32 = 1.0;

/// Light that was made fine.
pub(super) struct Corrected {
    /// H of each texel, the mean over its area.
    pub(super) irradiance: Vec<Vec3>,
    /// What is unshot of its open part.
    pub(super) unshot: Vec<Vec3>,
    /// How far the coarse light was off, of the RMS of the reflected light.
    pub(super) off: Vec<f32>,
    /// Whether all was sent until it was spent.
    pub(super) done: bool,
}

impl Solve<'_> {
    /// The light of `shone`, of which over the `kept` links `coarse` was found.
    pub(super) fn corrected(
        &mut self,
        kept: &[Vec<Kept>],
        shone: Vec<Vec3>,
        coarse: Spent,
        goal: Goal,
        watch: Watch,
    ) -> Result<Corrected> {
        let all = Receiving::on(0..self.world.mesh.faces.len());
        let mut fine = vec![Vec3::ZERO; shone.len()];
        let mut off = Vec::new();
        let (mut sent, mut told, mut part) = (shone, coarse, FINE);
        let mut before = f32::INFINITY;
        for round in 0..ROUNDS {
            let glow = self.glow(&sent);
            let half = 0.5 * (part.start + part.end);
            let within = part.start..half;
            let found = self.at_texels(What::Light, &glow, &all, goal.fine, within, watch)?;
            part.start = half;
            let new = self.of_open(&found);
            let delta = new.iter().zip(&told.received).map(|(f, x)| *f - *x);
            let delta: Vec<Vec3> = delta.collect();
            if round == 0 {
                let reflected = self.reflected(&delta).into_iter();
                off = reflected
                    .map(|v| (v * self.scale).abs().max_element())
                    .collect();
            }
            let next = self.spend(kept, &self.reflected(&delta), CORRECTED, watch)?;
            let rest = self.reflected(&sum(&delta, &next.received));
            let left = self.share_of_light(&rest);
            // Where links make up more than walls absorb it grows: what was told before stays.
            if left >= before {
                break;
            }
            (sent, before) = (rest, left);
            fine = sum(&fine, &found);
            told = Spent {
                unshot: sum(&told.unshot, &next.unshot),
                done: told.done && next.done,
                received: next.received,
            };
            if left <= LITTLE * goal.error || left >= ALL {
                break;
            }
        }
        let whole = fine.iter().zip(told.received.iter().zip(&self.open));
        Ok(Corrected {
            irradiance: whole.map(|(h, (rest, open))| *h + *rest * *open).collect(),
            unshot: told.unshot,
            off,
            done: told.done,
        })
    }

    /// The RMS of what is sent, of that of the reflected light.
    fn share_of_light(&self, sent: &[Vec3]) -> f32 {
        let squares = sent.iter().map(|v| (*v * self.scale).powf(2.0));
        let mean = self.mean(&squares.collect::<Vec<_>>());
        mean.max_element().sqrt() as f32
    }
}
