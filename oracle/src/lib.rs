//! Comparison, explanation of differences, exact answers, pictures and the report.

#![cfg_attr(
    not(test),
    deny(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

pub mod answer;
pub mod chart;
pub mod cli;
pub mod compare;
pub mod comparison;
pub mod dense;
pub mod diff;
pub mod exact;
pub mod interrupt;
pub mod merge;
pub mod path_tracer;
pub mod picture;
pub mod plan;
pub mod random;
pub mod refine;
pub mod relight;
pub mod report;
pub mod resample;
pub mod speed;
pub mod stress;
pub mod study;
pub mod table4;
pub mod view;
