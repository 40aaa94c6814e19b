//! Why a check failed, in the words that a person reads.

use crate::loops::LoopHead;
use crate::races::RaceReport;
use crate::tally::{Compared, Value};
use std::fmt;
use std::time::Duration;

/// A check that failed. `Debug` prints what `Display` does, so that a test that returns it shows the message.
pub struct Failure {
    /// File, entry point and size.
    pub subject: String,
    /// What is wrong.
    pub fault: Fault,
}

/// What is wrong.
pub enum Fault {
    /// No adapter, or the device failed.
    Device(String),
    /// The WGSL has an error: naga's message with path, line and column.
    Wgsl(String),
    /// Case and shader do not fit each other, or nothing is compared.
    Case(String),
    /// The run did not end within this time.
    TimeLimit(Duration),
    /// Lanes of a workgroup use an element without a barrier between, one of them to write.
    Race(RaceReport),
    /// A loop takes more turns than [`crate::loops::max_loop_turns`].
    EndlessLoop(LoopHead),
    /// Values differ.
    Difference(Box<Difference>),
}

/// Values of a buffer that differ by more than their bound.
pub struct Difference {
    /// The buffer.
    pub buffer: String,
    /// Number of values that differ.
    pub count: u64,
    /// Number of compared values.
    pub values: u64,
    /// What the values that differ have in common.
    pub pattern: String,
    /// The first value that differs, by its name in WGSL.
    pub first: Compared<String>,
    /// The value of the largest error.
    pub worst: Compared<String>,
    /// Largest error allowed.
    pub bound: f64,
    /// Unit of error and bound of numbers in f32, after a space.
    pub unit: &'static str,
    /// Inputs of the first.
    pub inputs: Vec<String>,
    /// Sizes at which the stage agrees, and the difference at a larger one.
    pub other_sizes: Vec<String>,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self {
            buffer, count, values, ..
        } = self;
        write!(f, "`{buffer}` differs in {count} of {values} values: {}", self.pattern)?;
        let mut examples = vec![("first", &self.first)];
        if self.worst.label != self.first.label {
            examples.push(("worst", &self.worst));
        }
        for (rank, example) in examples {
            write!(f, "\n  {rank}: {} = {}, ", example.label, example.found)?;
            write!(f, "the reference is {}", example.expected)?;
            if example.error.is_finite() {
                let [error, bound] = [example.error, self.bound].map(format_number);
                let unit = match example.found {
                    Value::Float(_) => self.unit,
                    _ => "",
                };
                write!(f, ": {error}{unit} apart, {bound} allowed")?;
            }
        }
        if !self.inputs.is_empty() {
            write!(f, "\n  inputs of the first: {}", self.inputs.join(", "))?;
        }
        let mut lines = self.other_sizes.iter();
        lines.try_for_each(|line| write!(f, "\n  {line}"))
    }
}

/// Formats an error or a bound with few digits.
pub fn format_number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        size if (1e-3..1e5).contains(&size) => {
            let digits = (3.0 - size.log10()).clamp(0.0, 6.0) as usize;
            let text = format!("{value:.digits$}");
            match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
                false => text,
            }
        }
        _ => format!("{value:.3e}"),
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Device(text) | Self::Case(text) => f.write_str(text),
            Self::Wgsl(listing) => f.write_str(listing.trim_end()),
            Self::TimeLimit(limit) => write!(f, "no end after {} s", format_number(limit.as_secs_f64())),
            Self::Race(races) => races.fmt(f),
            Self::EndlessLoop(head) => head.fmt(f),
            Self::Difference(difference) => difference.fmt(f),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match &self.fault {
            // It names the file itself.
            Fault::Wgsl(_) => self.fault.fmt(f),
            fault => write!(f, "{}: {fault}", self.subject),
        }
    }
}

impl fmt::Debug for Failure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for Failure {}
