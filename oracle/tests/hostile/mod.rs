//! Input that is meant to hurt. `ulimit` and signals are those of Unix.
#![cfg(unix)]

mod files;
mod kit;
mod limits;
