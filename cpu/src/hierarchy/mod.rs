//! The hierarchical solve: what shoots is as large, and what is asked as little, as an error allows.

pub mod account;
pub mod again;
pub mod anew;
pub mod block;
pub mod choice;
pub mod cluster;
pub mod cluster_link;
pub mod coarse;
mod correct;
pub mod descent;
pub mod find;
pub mod gather;
pub mod light;
pub mod link;
pub mod question;
pub mod relight;
pub mod solve;
pub mod spend;
pub mod state;
pub mod tree;
pub mod world;
