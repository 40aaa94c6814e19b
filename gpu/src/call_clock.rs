//! Time of a call to the device: with shaders of others it may never return.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;
use web_time::Instant;

/// Time between two looks at the clock.
const POLL_INTERVAL: Duration = Duration::from_millis(500);

/// Clock of the call to a device that is under way.
#[derive(Default)]
pub struct CallClock(Mutex<CallState>);

#[derive(Clone, Copy, Default)]
struct CallState {
    start: Option<Instant>,
    stage: Option<&'static str>,
    suspect: Option<&'static str>,
}

impl CallClock {
    /// Makes a call.
    pub(crate) fn time_call<T>(&self, call: impl FnOnce() -> T) -> T {
        self.state().start = Some(Instant::now());
        let result = call();
        self.state().start = None;
        result
    }

    /// Awaits work of which all calls run one shader.
    pub(crate) async fn await_stage<T>(&self, stage: &'static str, work: impl Future<Output = T>) -> T {
        self.state().stage = Some(stage);
        let result = work.await;
        self.state().stage = None;
        result
    }

    /// Sets the shader that is to blame for a call that runs several: the only one that is not the program's.
    pub(crate) fn suspect_stage(&self, stage: Option<&'static str>) {
        self.state().suspect = stage;
    }

    /// Calls `end` in another thread when a call takes longer than `limit`, with the shader that it runs if it runs a single
    /// one, or else the suspect. Such a call may never return, nor the closing of its device: `end` has to end the process.
    pub fn watch_calls(self: &Arc<Self>, limit: Duration, end: impl FnOnce(Option<&'static str>) + Send + 'static) {
        let clock = Arc::downgrade(self);
        thread::spawn(move || {
            while let Some(clock) = clock.upgrade() {
                let CallState { start, stage, suspect } = *clock.state();
                if start.is_some_and(|start| start.elapsed() > limit) {
                    return end(stage.or(suspect));
                }
                drop(clock);
                thread::sleep(POLL_INTERVAL);
            }
        });
    }

    fn state(&self) -> MutexGuard<'_, CallState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
