//! The program as scripts use it.

mod bake;
mod chart;
mod check;
mod command;
mod diff;
mod error;
mod merge;
mod relight;
mod solve;
mod stress;
mod viewer;
