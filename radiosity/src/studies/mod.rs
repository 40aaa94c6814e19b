//! Studies over many solves: speed against accuracy and error against an option ([`chart`]), the failure
//! atlas ([`stress`]), random scenes ([`random`]), mutants of the shaders ([`sabotage`]), the paper's Table 4
//! ([`table4`]) and a check of an adapter ([`hardware`]).

pub mod chart;
pub mod hardware;
pub mod hashes;
mod limited;
pub mod random;
pub mod sabotage;
pub mod stress;
pub mod table4;
