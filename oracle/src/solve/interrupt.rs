//! Whether Ctrl-C was pressed: preparing asks on all threads.

use std::sync::atomic::{AtomicBool, Ordering};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// From now on it was. Whether it was before.
pub fn interrupt() -> bool {
    INTERRUPTED.swap(true, Ordering::SeqCst)
}

/// Whether it was.
pub fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::SeqCst)
}
