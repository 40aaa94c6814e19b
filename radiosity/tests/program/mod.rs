//! The commands, run as a program.

mod article;
pub mod bake;
mod browser;
mod chart;
mod check;
pub mod command;
pub mod diff;
mod error;
mod lights;
mod links;
mod live;
pub mod merge;
mod pages;
mod refused_options;
mod relight;
pub mod room;
mod sabotage;
mod scripts;
mod shader;
mod shoot;
mod solve;
mod stress;
mod trace;
mod viewer;
