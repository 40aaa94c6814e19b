//! Solves whose failures do not end a study: `chart` and `stress` go on after an error, a panic or a solve that takes
//! too long.

use common::Error;
use oracle::solve::progress::{PhaseCallback, ProgressMonitor};
use std::cell::Cell;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// Solves, and stops at the first report of progress after `limit` seconds. Returns the answer, or the error, panic or
/// excess of time in words, and the wall-clock seconds; none if the solve was interrupted or `show` asked to stop.
pub fn solve_limited<T>(
    limit: f64,
    show: PhaseCallback,
    solve: impl FnOnce(&ProgressMonitor) -> common::Result<T>,
) -> Option<(Result<T, String>, f64)> {
    let (asked, late) = (Cell::new(false), Cell::new(false));
    let start = Instant::now();
    let progress = |phase: &str, done: f64| {
        late.set(late.get() || start.elapsed().as_secs_f64() > limit);
        asked.set(asked.get() || show(phase, done).is_break());
        match asked.get() || late.get() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    };
    let monitor = ProgressMonitor::new(&progress);
    let solved = catch_unwind(AssertUnwindSafe(|| solve(&monitor)));
    let seconds = start.elapsed().as_secs_f64();
    let answer = match solved {
        _ if asked.get() => return None,
        _ if late.get() => Err(format!("took longer than {limit} s")),
        Ok(Err(Error::Interrupted)) => return None,
        Ok(solved) => solved.map_err(|error| error.to_string()),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
            Err(format!("panic: {}", text.unwrap_or("without a message")))
        }
    };
    Some((answer, seconds))
}
