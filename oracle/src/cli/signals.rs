//! Signals that would end the program in the middle of a file.

/// With a handler, a write beyond `ulimit -f` fails as on a full disk: with exit code 4 and no part
/// of a file. Without one it kills.
#[cfg(unix)]
pub fn survive_file_limit() {
    use signal_hook::{consts::SIGXFSZ, flag};
    use std::sync::{Arc, atomic::AtomicBool};
    // Without the handler nothing is wrong but for those who have such a limit.
    let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
}

/// There are no such limits here.
#[cfg(not(unix))]
pub fn survive_file_limit() {}
