//! Progress bars on stderr, and Ctrl-C.

use super::console::{is_quiet, message};
use common::text::escape_control;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::cell::RefCell;
use std::ops::ControlFlow;
use std::sync::OnceLock;
use std::time::Duration;

pub use oracle::solve::interrupt::is_interrupted;
use oracle::solve::interrupt::request_interrupt;

static LISTENING: OnceLock<()> = OnceLock::new();

/// Installs the Ctrl-C handler: the first interrupt lets the current work stop and write its results, the second
/// ends the program at once.
pub fn handle_interrupts() {
    LISTENING.get_or_init(|| {
        let handler = || {
            if request_interrupt() {
                std::process::exit(130);
            }
        };
        if let Err(error) = ctrlc::set_handler(handler) {
            message!("note: Ctrl-C will end the program at once: {error}");
        }
    });
}

/// A progress bar with the name of the current phase; hidden under `--quiet` and where stderr is no terminal.
pub struct Progress {
    bar: ProgressBar,
    phase: RefCell<String>,
}

/// Steps of a bar.
const BAR_STEPS: f64 = 1000.0;

impl Progress {
    /// Makes a bar headed `title`.
    pub fn new(title: &str) -> Self {
        let bar = ProgressBar::new(BAR_STEPS as u64);
        if is_quiet() {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        // The template is constant and valid; without it the bar would have indicatif's default style.
        if let Ok(style) =
            ProgressStyle::with_template("{prefix:<20} {msg:<26} {bar:32} {percent:>3} % {elapsed_precise} eta {eta}")
        {
            bar.set_style(style);
        }
        bar.set_prefix(escape_control(title));
        Self {
            bar,
            phase: RefCell::default(),
        }
    }

    /// Shows the share of `phase` that is done, 0…1; breaks after Ctrl-C.
    pub fn show_phase(&self, phase: &str, done: f64) -> ControlFlow<()> {
        if *self.phase.borrow() != phase {
            self.phase.replace(phase.to_owned());
            self.bar.set_message(phase.to_owned());
            self.bar.reset();
            self.bar.enable_steady_tick(Duration::from_millis(200));
        }
        self.bar.set_position((done * BAR_STEPS) as u64);
        if is_interrupted() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    /// Removes the bar.
    pub fn remove_bar(&self) {
        self.bar.finish_and_clear();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.remove_bar();
    }
}
