//! The `radiosity` program as a library: command line, pages, studies, relighting's pictures.

#![cfg_attr(
    not(test),
    deny(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

#[cfg(not(target_arch = "wasm32"))]
pub mod cli;
pub mod diff;
pub mod merge;
pub mod plan;
pub mod relight;
pub mod report;
pub mod studies;
