//! The commands, run as a program.

mod bake;
mod bake_kept;
mod browser;
mod chart;
mod check;
pub mod command;
mod demo;
mod diff;
mod error;
mod merge;
mod pages;
mod relight;
mod scripts;
mod shoot;
mod solve;
mod stress;
mod viewer;
