//! Hard scenes, odd units, and what is said of an answer that cannot be trusted.

mod estimate;
mod refused;
mod scales;
mod stability;
mod units;
mod warnings;
