//! Hostile input. No input ends in a panic, a hang, an abort or a lost result. Each row of the tables is a call of the
//! program in a folder of hostile files, with its exit code and the text of its message. `ulimit` and signals need Unix.
#![cfg(unix)]

mod cube;
mod files;
mod kit;
mod limits;
mod memory;
mod options;
mod room;
mod stored;
mod terminal;
