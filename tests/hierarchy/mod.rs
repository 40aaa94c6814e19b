//! The hierarchical solver: its trees and links, exact solutions, and random scenes to which nothing was tuned.

mod clusters;
mod error_budget;
mod final_gather;
mod linkers;
mod narrow_gap;
mod residual;
mod tree;
