//! Progress on stderr.

use super::tell::say;
use common::text::plain;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::ops::ControlFlow;
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
    phase: String,
}

impl Progress {
    /// A bar for the work on `title`.
    pub fn new(title: &str, quiet: bool) -> Self {
        let bar = ProgressBar::new(0);
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
        bar.enable_steady_tick(Duration::from_millis(200));
        Self {
            bar,
            phase: String::new(),
        }
    }

    /// `done` of `all` steps of `phase`; breaks after Ctrl-C.
    pub fn show(&mut self, phase: &str, done: u64, all: u64) -> ControlFlow<()> {
        if self.phase != phase {
            phase.clone_into(&mut self.phase);
            self.bar.set_message(self.phase.clone());
            self.bar.reset();
        }
        self.bar.set_length(all);
        self.bar.set_position(done);
        if interrupted() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
