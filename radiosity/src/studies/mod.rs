//! Studies over many solves: speed against accuracy and error against an option ([`chart`]), the failure
//! atlas ([`stress`]), random scenes ([`random`]), mutants of the shaders ([`sabotage`]) and the paper's Table 4
//! ([`table4`]).

pub mod chart;
pub mod hashes;
mod limited;
pub mod random;
pub mod sabotage;
pub mod stress;
pub mod table4;
