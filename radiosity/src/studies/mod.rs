//! Studies over many solves: speed against accuracy and error against an option ([`chart`]), the failure
//! atlas ([`stress`]), random scenes ([`random`]) and the paper's Table 4 ([`table4`]).

pub mod chart;
mod limited;
pub mod random;
pub mod stress;
pub mod table4;
