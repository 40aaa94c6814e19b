//! Comparison, explanation of differences, exact answers, pictures and the report.

pub mod comparison;
