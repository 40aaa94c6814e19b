//! The program, and the studies, pages and plans behind its commands.

mod baked;
mod examples;
mod hostile;
mod painted;
mod path_tracer;
mod plan;
mod program;
mod random;
mod report;
mod scenes;
mod stress;
mod study;
mod table4;
mod view;
