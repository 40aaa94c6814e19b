//! Tests that take long or need the files of RADIOSITY_DATA; `make atlas` runs them.

mod breaks;
mod capture_data;
mod errors;
mod healthy;
mod properties;
mod stress;
mod stress_random;
