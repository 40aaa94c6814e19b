//! Progress on stderr.

use super::tell::say;
use common::text::plain;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::cell::RefCell;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;

use crate::solve::interrupt::interrupt;
pub use crate::solve::interrupt::interrupted;

static LISTENING: OnceLock<()> = OnceLock::new();

/// From now on the first Ctrl-C ends the work in hand in good order, the second one at once.
pub fn listen() {
    LISTENING.get_or_init(|| {
        let handler = || {
            if interrupt() {
                std::process::exit(130);
            }
        };
        if let Err(error) = ctrlc::set_handler(handler) {
            say!("note: Ctrl-C will end the program at once: {error}");
        }
    });
}

/// A bar with a phase's name; hidden when quiet or when stderr is no terminal.
pub struct Progress {
    bar: ProgressBar,
    phase: RefCell<String>,
}

/// Reads what `path` names, and says so: a large file takes seconds.
pub fn reading<T>(path: &Path, quiet: bool, read: impl FnOnce() -> T) -> T {
    let name = path.file_name().unwrap_or(path.as_os_str());
    let progress = Progress::new(&name.to_string_lossy(), quiet);
    // Nobody listens to Ctrl-C yet.
    let _ = progress.show("reading", 0.0);
    read()
}

/// Steps of a bar.
const STEPS: f64 = 1000.0;

impl Progress {
    /// A bar for the work on `title`.
    pub fn new(title: &str, quiet: bool) -> Self {
        let bar = ProgressBar::new(STEPS as u64);
        if quiet {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        // The template is a constant: it cannot fail, and without it the bar is only plainer.
        if let Ok(style) = ProgressStyle::with_template(
            "{prefix:<20} {msg:<26} {bar:32} {percent:>3} % {elapsed_precise} eta {eta}",
        ) {
            bar.set_style(style);
        }
        bar.set_prefix(plain(title));
        Self {
            bar,
            phase: RefCell::default(),
        }
    }

    /// The share of `phase` that is done, 0…1; breaks after Ctrl-C.
    pub fn show(&self, phase: &str, done: f64) -> ControlFlow<()> {
        if *self.phase.borrow() != phase {
            self.phase.replace(phase.to_owned());
            self.bar.set_message(phase.to_owned());
            self.bar.reset();
            self.bar.enable_steady_tick(Duration::from_millis(200));
        }
        self.bar.set_position((done * STEPS) as u64);
        if interrupted() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    /// There is no bar any more.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.clear();
    }
}
