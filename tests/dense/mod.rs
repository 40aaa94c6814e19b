//! The dense solver, the reference of the others.

mod factors;
mod printed;
mod solve;
mod visibility;
