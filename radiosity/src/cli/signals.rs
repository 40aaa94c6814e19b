//! Signals that would end the program in the middle of a file.

/// Installs a handler for SIGXFSZ: a write beyond `ulimit -f` then fails like one on a full disk (exit code 4,
/// no partial file) instead of killing the program.
#[cfg(unix)]
pub fn survive_file_limit() {
    use signal_hook::{consts::SIGXFSZ, flag};
    use std::sync::{Arc, atomic::AtomicBool};
    // If it cannot be installed, only users with such a limit notice.
    let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
}

/// Does nothing: this system has no file size limits.
#[cfg(not(unix))]
pub fn survive_file_limit() {}
