//! Times of the stages that make links, each alone.

use crate::link_recorder::LinkStep;
use crate::probe::LinkProbe;
use crate::solver_context::SolverContext;
use common::Result;
use common::shooting::DepositRule;
use web_time::Instant;

/// Repetitions of a step in one submission.
const STEP_REPETITIONS: u32 = 32;

/// Steps, and their names.
const TIMED_STEPS: [(&str, LinkStep); 4] = [
    ("view and item buffer", LinkStep::Draw),
    ("form factor, visibility and link", LinkStep::Links),
    ("escape", LinkStep::Escape),
    ("transfer and closure", LinkStep::Sums),
];

impl LinkProbe {
    /// Returns the seconds of each step of the links of a patch: a share of a submission that repeats it.
    pub(crate) fn time_steps(&self, context: &mut SolverContext, patch: u32) -> Result<Vec<(&'static str, f64)>> {
        let mut times = Vec::new();
        for (name, step) in TIMED_STEPS {
            self.write_shot(context, patch, DepositRule::FULL_DEPOSIT);
            let before = self.record_steps(context, patch, &[LinkStep::Draw, step]);
            let submission = context.host.submit_work(before);
            context.host.wait_for_submission(submission)?;
            let repeated = self.record_steps(context, patch, &[step; STEP_REPETITIONS as usize]);
            let start = Instant::now();
            let submission = context.host.submit_work(repeated);
            context.host.wait_for_submission(submission)?;
            times.push((name, start.elapsed().as_secs_f64() / f64::from(STEP_REPETITIONS)));
        }
        Ok(times)
    }
}
