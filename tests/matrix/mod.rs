//! The matrix solver, which judges the others.

mod factors;
mod printed;
mod solve;
mod visibility;
