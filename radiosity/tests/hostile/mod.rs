//! Hostile input. No input ends in a panic, a hang, an abort or a lost result. `ulimit` and signals need Unix.
#![cfg(unix)]

mod files;
mod limits;
mod memory;
mod stored;
mod terminal;
