//! The hierarchical solve: what shoots is as large, and what is asked as little, as an error allows.

pub mod account;
pub mod block;
pub mod coarse;
pub mod gather;
pub mod light;
pub mod link;
pub mod solve;
pub mod tree;
