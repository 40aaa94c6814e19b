//! The hierarchical solver: its trees and links, exact solutions, and random scenes to which nothing was tuned.

mod bounded_light;
mod error_budget;
mod final_gather;
mod linkers;
mod many_faces;
mod rays;
mod recorded_links;
mod tree;
