//! A solve in slices of time: between two of them its worker receives messages, and may stop it.

use common::Result;
use common::settings::Schedule;
use common::shooting::{Shoot, ShotSeries, SolveRun, solve_progress};
use std::ops::ControlFlow;
use std::time::Duration;
use web_time::Instant;

/// Time after which a slice ends with the shot that is being made.
const SLICE_TIME: Duration = Duration::from_millis(100);

/// Shoots the largest unshot power first until the schedule is met, and awaits `pause` after each slice with the progress,
/// 0…1; a break of it ends the solve. The shots are those of a solve without slices.
///
/// Errors: those of [`common::shooting::shoot_until_converged`].
pub async fn shoot_in_slices(
    engine: &mut dyn Shoot,
    schedule: &Schedule,
    pause: &mut impl AsyncFnMut(f64) -> ControlFlow<()>,
) -> Result<SolveRun> {
    let mut series = ShotSeries::until_converged(schedule, &engine.patch_power()?)?;
    let (order, mut left) = (series.order, series.max_shots);
    loop {
        let begin = Instant::now();
        let mut progress = None;
        engine.run(order, left, &mut |shot| {
            left -= 1;
            series.record_shot(shot, &mut |shot, emitted| {
                if begin.elapsed() < SLICE_TIME {
                    return ControlFlow::Continue(());
                }
                progress = Some(solve_progress(shot, emitted, schedule.epsilon));
                ControlFlow::Break(())
            })
        })?;
        // A slice whose time is not over has met the schedule.
        let Some(progress) = progress.filter(|_| left > 0) else {
            break;
        };
        if pause(progress).await.is_break() {
            break;
        }
    }
    Ok(series.into_run(engine.read_field()?))
}
