//! Comparison, explanation of differences, exact answers, pictures and the report.

#![cfg_attr(
    not(test),
    deny(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

pub mod cli;
pub mod judge;
pub mod merge;
pub mod plan;
pub mod relight;
pub mod show;
pub mod solve;
pub mod study;
