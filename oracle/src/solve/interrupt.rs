//! The interrupt flag that Ctrl-C sets; long work on any thread tests it.

use std::sync::atomic::{AtomicBool, Ordering};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Sets the flag. Returns true if it was already set.
pub fn request_interrupt() -> bool {
    INTERRUPTED.swap(true, Ordering::SeqCst)
}

/// Tests the flag.
pub fn is_interrupted() -> bool {
    INTERRUPTED.load(Ordering::SeqCst)
}
