//! Defect correction (Hackbusch 1981): the light of all sources is gathered at every texel, and its difference
//! from the coarse light is iterated over the coarse links. In a narrow gap coarse nodes resolve little of that
//! difference, so the correction is gathered as well, until it is small.

use crate::hierarchy::coarse::{StoredLink, add_fields};
use crate::hierarchy::solver::{
    CORRECTION_TOLERANCE, CoarseLight, ErrorBudget, FINE_PROGRESS, HierarchicalSolver, TexelSolution,
};
use common::Result;
use common::passes::ProgressCallback;
use glam::Vec3;

/// Maximum number of corrections.
const MAX_CORRECTION_ROUNDS: usize = 12;
/// A correction below this share of the requested error is not gathered.
const NEGLIGIBLE_SHARE: f32 = 0.25;
/// A correction as large as the light is not gathered: links add more than walls absorb.
const DIVERGENT_SHARE: f32 = 1.0;

impl HierarchicalSolver<'_> {
    /// Gathers and corrects the light of `radiosity`, of which `coarse` was found over `links`.
    pub(super) fn correct_defects(
        mut self,
        links: &[Vec<StoredLink>],
        radiosity: Vec<Vec3>,
        coarse: CoarseLight,
        budget: ErrorBudget,
        watch: ProgressCallback,
    ) -> Result<TexelSolution> {
        let mut fine = vec![Vec3::ZERO; radiosity.len()];
        let mut coarse_error = Vec::new();
        let (mut sent, mut estimate, mut progress) = (radiosity, coarse, FINE_PROGRESS);
        let mut last_share = f32::INFINITY;
        for round in 0..MAX_CORRECTION_ROUNDS {
            let sources = self.fit_sources(&sent);
            let half = 0.5 * (progress.start + progress.end);
            let gathered = self.gather_arriving(&sources, budget.fine, progress.start..half, watch)?;
            progress.start = half;
            let new = self.open_part_mean(&gathered);
            let delta = new.iter().zip(&estimate.received).map(|(f, x)| *f - *x);
            let delta: Vec<Vec3> = delta.collect();
            if round == 0 {
                let reflected = self.reflected_radiosity(&delta).into_iter();
                coarse_error = reflected.map(|v| (v * self.scale).abs().max_element()).collect();
            }
            let source = self.reflected_radiosity(&delta);
            let next = self.iterate_coarse(links, &source, CORRECTION_TOLERANCE, watch)?;
            let rest = self.reflected_radiosity(&add_fields(&delta, &next.received));
            let share = self.share_of_light(&rest);
            // The correction diverges where links add more than walls absorb: the last estimate stands.
            if share >= last_share {
                break;
            }
            (sent, last_share) = (rest, share);
            fine = add_fields(&fine, &gathered);
            estimate = CoarseLight {
                unshot: add_fields(&estimate.unshot, &next.unshot),
                converged: estimate.converged && next.converged,
                received: next.received,
            };
            if share <= NEGLIGIBLE_SHARE * budget.error || share >= DIVERGENT_SHARE {
                break;
            }
        }
        let whole = fine.iter().zip(estimate.received.iter().zip(&self.open));
        let unshot = estimate.unshot.iter().zip(&self.open);
        Ok(TexelSolution {
            irradiance: whole.map(|(h, (rest, open))| *h + *rest * *open).collect(),
            residual: unshot.map(|(unshot, open)| *unshot * *open).collect(),
            direct: Vec::new(),
            noise: vec![Vec3::ZERO; self.open.len()],
            removed: Vec::new(),
            coarse_error,
            open: self.open,
            links: self.links,
            passes: self.passes,
            converged: estimate.converged,
        })
    }

    /// Returns the RMS of a radiosity relative to that of the reflected light.
    fn share_of_light(&self, sent: &[Vec3]) -> f32 {
        let squares = sent.iter().map(|v| (*v * self.scale).powf(2.0));
        let mean = self.area_mean(&squares.collect::<Vec<_>>());
        mean.max_element().sqrt() as f32
    }
}
