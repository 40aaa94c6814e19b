//! Time of a call to the device: with shaders of others it may never return.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Clock of the call to a device that is under way.
#[derive(Default)]
pub struct CallClock(Mutex<Option<Instant>>);

impl CallClock {
    /// Makes a call.
    pub(crate) fn time_call<T>(&self, call: impl FnOnce() -> T) -> T {
        self.set_start(Some(Instant::now()));
        let result = call();
        self.set_start(None);
        result
    }

    /// Returns how long the call under way has taken; 0 if there is none.
    pub fn call_time(&self) -> Duration {
        let start = *self.0.lock().unwrap_or_else(PoisonError::into_inner);
        start.map_or(Duration::ZERO, |start| start.elapsed())
    }

    fn set_start(&self, start: Option<Instant>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = start;
    }
}
