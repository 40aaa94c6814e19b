//! How much a submission holds, by the time that the earlier ones took.

use std::time::Instant;

/// A submission should take about this long: far below the seconds after which drivers kill one.
const SUBMISSION_SECONDS: f64 = 0.5;
/// Shots of the first submission.
const FIRST: u32 = 8;
/// Longer than this, even a few shots are too many for one submission.
const LONGEST_SECONDS: f64 = 1.5;
/// Submissions under way at any time: one is read while the next one runs.
pub const IN_FLIGHT: usize = 2;

/// What is known of a shot's time.
pub struct Pace {
    /// Submissions of fewer shots than this pay only where a shot is slow.
    fewest: u32,
    most: u32,
    software: bool,
    /// Seconds that a shot takes, as measured so far.
    seconds: Option<f64>,
    /// When the latest submission ended.
    previous: Instant,
}

impl Pace {
    pub fn new(fewest: u32, most: u32, software: bool) -> Self {
        Self {
            fewest,
            most,
            software,
            seconds: None,
            previous: Instant::now(),
        }
    }

    /// A new series of submissions begins.
    pub fn start(&mut self) {
        self.previous = Instant::now();
    }

    /// How many shots the next submission holds: few at first, because nothing is known of their
    /// length and a short solve should not end in empty shots; at most doubled each time.
    pub fn shots(&self, launched: u32, left: u32) -> u32 {
        let shots = match self.seconds {
            None => FIRST,
            Some(seconds) => {
                let longest = if self.software {
                    f64::INFINITY
                } else {
                    LONGEST_SECONDS
                };
                let fewest = f64::from(self.fewest).min(longest / seconds);
                (SUBMISSION_SECONDS / seconds).max(fewest).max(1.0) as u32
            }
        };
        shots.min(self.most).min(launched.max(FIRST)).min(left)
    }

    /// `shots` that were submitted at `start` have landed now.
    pub fn landed(&mut self, start: Instant, shots: u32) {
        // A submission starts when it is submitted or when the one before it ends.
        let seconds = start.max(self.previous).elapsed().as_secs_f64();
        self.previous = Instant::now();
        self.seconds = Some((seconds / f64::from(shots)).max(1e-7));
    }
}
