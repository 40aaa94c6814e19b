//! Hard scenes, odd units, and the warnings and error estimates of answers that cannot be trusted.

mod estimate;
mod flush_lamp;
mod properties;
mod refused;
mod scales;
mod sky;
mod stability;
mod two_sided;
mod units;
mod warnings;
