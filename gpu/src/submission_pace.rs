//! Size of the next submission, from the times of the earlier ones.

use web_time::Instant;

/// Target time of a submission: far below the seconds after which drivers kill one.
const TARGET_SUBMISSION_SECONDS: f64 = 0.5;
/// Shots of the first submission.
const FIRST_SHOTS: u32 = 8;
/// A submission of few shots may take this long at most.
const MAX_SUBMISSION_SECONDS: f64 = 1.5;
/// Submissions under way at any time: the host reads one while the next one runs.
pub const IN_FLIGHT: usize = 2;

/// Estimate of a shot's time, and the sizes of submissions that follow from it.
pub struct SubmissionPace {
    /// Fewest shots of a submission, unless a shot is slow.
    fewest: u32,
    most: u32,
    software: bool,
    /// Seconds of a shot, as measured last.
    seconds: Option<f64>,
    /// End of the latest submission.
    previous: Instant,
}

impl SubmissionPace {
    pub fn new(fewest: u32, most: u32, software: bool) -> Self {
        Self {
            fewest,
            most,
            software,
            seconds: None,
            previous: Instant::now(),
        }
    }

    /// Starts a new series of submissions.
    pub fn start_series(&mut self) {
        self.previous = Instant::now();
    }

    /// Returns the number of shots of the next submission: few at first, as their time is unknown and a short
    /// solve should not end in empty shots; then at most twice as many as before.
    pub fn next_shots(&self, launched: u32, left: u32) -> u32 {
        let shots = match self.seconds {
            None => FIRST_SHOTS,
            Some(seconds) => {
                let longest = if self.software {
                    f64::INFINITY
                } else {
                    MAX_SUBMISSION_SECONDS
                };
                let fewest = f64::from(self.fewest).min(longest / seconds);
                (TARGET_SUBMISSION_SECONDS / seconds).max(fewest).max(1.0) as u32
            }
        };
        shots.min(self.most).min(launched.max(FIRST_SHOTS)).min(left)
    }

    /// Records that the `shots` submitted at `start` have ended now.
    pub fn record_landing(&mut self, start: Instant, shots: u32) {
        // A submission starts when it is submitted or when the one before it ends.
        let seconds = start.max(self.previous).elapsed().as_secs_f64();
        self.previous = Instant::now();
        self.seconds = Some((seconds / f64::from(shots)).max(1e-7));
    }
}
