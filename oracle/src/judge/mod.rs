//! Whether an answer is right: exact answers, a path tracer, solvers against each other, results
//! against results.

pub mod compare;
pub mod comparison;
pub mod diff;
pub mod exact;
pub mod path_tracer;
pub mod resample;
