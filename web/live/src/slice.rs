//! A recorded solve in slices of time: between two of them its worker receives messages, and may stop it.

use common::Result;
use common::settings::Schedule;
use common::shooting::{RadiosityField, Shoot, Shot, ShotOrder, ShotSeries, SolveRun, solve_progress};
use cpu::CpuSolver;
use gpu::GpuSolver;
use oracle::trace::recorder::{ShotRecord, ShotRecorder};
use std::ops::ControlFlow;
use std::time::Duration;
use web_time::Instant;

/// Time after which a slice ends with the shot that is being made.
const SLICE_TIME: Duration = Duration::from_millis(100);

/// An engine that a page awaits, and whose shots are recorded.
pub trait RecordedEngine {
    /// Returns the unshot power of each patch.
    fn request_power(&mut self) -> impl Future<Output = Result<Vec<f32>>>;

    /// Shoots until the greedy `order` ends, after `max_shots`, or until `watch` breaks.
    fn request_shots(
        &mut self,
        order: ShotOrder<'_>,
        max_shots: u32,
        watch: &mut dyn FnMut(&Shot) -> ControlFlow<()>,
    ) -> impl Future<Output = Result<()>>;

    /// Returns the texels' state.
    fn request_field(&mut self) -> impl Future<Output = Result<RadiosityField>>;
}

impl RecordedEngine for ShotRecorder<'_, CpuSolver<'_>> {
    async fn request_power(&mut self) -> Result<Vec<f32>> {
        self.patch_power()
    }

    async fn request_shots(
        &mut self,
        order: ShotOrder<'_>,
        max_shots: u32,
        watch: &mut dyn FnMut(&Shot) -> ControlFlow<()>,
    ) -> Result<()> {
        self.run(order, max_shots, watch)
    }

    async fn request_field(&mut self) -> Result<RadiosityField> {
        self.read_field()
    }
}

/// A solver on the GPU with the record of its shots.
pub struct RecordedGpu<'a> {
    /// The solver.
    pub solver: GpuSolver<'a>,
    /// The record.
    pub record: ShotRecord<'a>,
    /// Unshot power of each patch before the next shot.
    pub power: Vec<f32>,
}

impl RecordedEngine for RecordedGpu<'_> {
    async fn request_power(&mut self) -> Result<Vec<f32>> {
        Ok(self.power.clone())
    }

    async fn request_shots(
        &mut self,
        order: ShotOrder<'_>,
        max_shots: u32,
        watch: &mut dyn FnMut(&Shot) -> ControlFlow<()>,
    ) -> Result<()> {
        for done in 0..max_shots {
            if self.record.is_full() {
                // What is only counted needs no read-back.
                let record = &mut self.record;
                let mut count = |shot: &Shot| {
                    record.count_shot(shot);
                    watch(shot)
                };
                return self.solver.request_shots(order, max_shots - done, &mut count).await;
            }
            let Some(next) = self.solver.request_observed_shot(order).await? else {
                break;
            };
            if self.record.count_shot(&next.shot) {
                self.record.add_shot(next.shot, &self.power, &next.field);
            }
            self.power = next.power;
            if watch(&next.shot).is_break() {
                break;
            }
        }
        Ok(())
    }

    async fn request_field(&mut self) -> Result<RadiosityField> {
        self.solver.request_field().await
    }
}

/// Shoots the largest unshot power first until the schedule is met, and awaits `pause` after each slice with the progress,
/// 0…1; a break of it ends the solve. The shots are those of a solve without slices.
///
/// Errors: those of [`common::shooting::shoot_until_converged`].
pub async fn shoot_in_slices(
    engine: &mut impl RecordedEngine,
    schedule: &Schedule,
    pause: &mut impl AsyncFnMut(f64) -> ControlFlow<()>,
) -> Result<SolveRun> {
    let mut series = ShotSeries::until_converged(schedule, &engine.request_power().await?)?;
    let (order, mut left) = (series.order, series.max_shots);
    loop {
        let begin = Instant::now();
        let mut progress = None;
        engine
            .request_shots(order, left, &mut |shot| {
                left -= 1;
                series.record_shot(shot, &mut |shot, emitted| {
                    if begin.elapsed() < SLICE_TIME {
                        return ControlFlow::Continue(());
                    }
                    progress = Some(solve_progress(shot, emitted, schedule.epsilon));
                    ControlFlow::Break(())
                })
            })
            .await?;
        // A slice whose time is not over has met the schedule.
        let Some(progress) = progress.filter(|_| left > 0) else {
            break;
        };
        if pause(progress).await.is_break() {
            break;
        }
    }
    Ok(series.into_run(engine.request_field().await?))
}
