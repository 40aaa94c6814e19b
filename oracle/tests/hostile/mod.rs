//! Input that is meant to hurt. No input ends in a panic, a hang, an abort or a lost result: each row of these
//! tables is one call of the program in a folder of hostile files, its exit code, and what it has to say.
//! `ulimit` and signals are those of Unix.
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
